// The views of a scene: which one is shown, new ones of where the camera is, and links to what is shown.
'use strict';

import { addressOf } from './api.js';
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

/** Copies a link to what is shown: the camera, the time and the view. */
async function copyLink() {
  const { values, time, view } = store.scene;
  const hasTimes = store.describe.times.length > 0;
  const camera = JSON.stringify(values.camera ?? {});
  const link = addressOf({ camera, ...(hasTimes && { time }), ...(view && { view }) });
  try {
    await navigator.clipboard.writeText(link);
    say('The link is copied. It is valid as long as this program runs.');
  } catch {
    say(link);
  }
}

/** Shows what a link has. */
export async function follow({ camera, time, view }) {
  if (camera === undefined) return;
  try {
    const wanted = JSON.parse(camera);
    const keys = new Set([...Object.keys(store.scene.values.camera ?? {}), ...Object.keys(wanted)]);
    const changes = [...keys].map((key) => ({ path: ['camera', key], value: wanted[key] ?? null }));
    await change(changes, { time: time === undefined ? undefined : Number(time), view });
  } catch (error) {
    say(`The link cannot be followed: ${error.message}`, 'error');
  }
}

/** Listens to the list of views and the button that adds one. */
export function start() {
  select.addEventListener('change', () => change([], { view: select.value }));
  byId('add-view').addEventListener('click', add);
  byId('copy-link').addEventListener('click', copyLink);
  on('scene', show);
  // The views of a model that runs are its own: each writes pictures.
  on('describe', ({ live }) => {
    byId('new-view').hidden = live;
  });
}
