// The views of a scene: which one is shown, and new ones of where the camera is.
'use strict';

import { byId, h } from './dom.js';
import { change } from './sender.js';
import { on, say, store } from './store.js';

const select = byId('view');
const name = byId('view-name');

function show({ view, views }) {
  byId('views').hidden = views.length === 0;
  select.replaceChildren(...views.map((text) => h('option', { value: text }, text)));
  select.value = view;
}

/** Adds a view with the camera of the one that is shown, and shows it. */
async function add() {
  const wanted = name.value.trim();
  if (!wanted) return name.focus();
  const { values, views } = store.scene;
  const value = { name: wanted };
  if (values.camera) value.camera = values.camera;
  if (await change([{ path: ['views', views.length], value }], { view: wanted })) {
    name.value = '';
    say(`The view ${wanted} is in the scene.`);
  }
}

/** Listens to the list of views and the button that adds one. */
export function start() {
  select.addEventListener('change', () => change([], { view: select.value }));
  byId('add-view').addEventListener('click', add);
  on('scene', show);
  // The views of a model that runs are its own: each writes pictures.
  on('describe', ({ live }) => {
    byId('new-view').hidden = live;
  });
}
