// Shortcuts of the page, and the list of them under "?".
'use strict';

import { byId, h, takesKeys } from './dom.js';
import { crossKey, toggleCross, turnBy, zoomBy } from './hand.js';
import { saveScene } from './files.js';
import { focusTab, show as showPanel, toggleFullScreen } from './panel.js';
import { act } from './sender.js';
import { goTo, last, play, step } from './timeline.js';

const TURN = 0.04;
const help = byId('help');

/** What the list shows: keys and what they do. */
const LIST = [
  [
    'On the picture',
    [
      ['Drag, Shift + arrows', 'turn'],
      ['Wheel, Pinch, +, −', 'zoom'],
      ['Double click', 'centre'],
      ['Click', 'probe a pixel'],
      ['P', 'cross: arrow keys move it, Enter probes, C centres'],
    ],
  ],
  [
    'Time',
    [
      ['← →', 'one time back or forward'],
      ['Home, End', 'first, last time'],
      ['Space', 'play, stop'],
    ],
  ],
  [
    'Transfer function',
    [
      ['Drag, Arrow keys', 'move a point, an end of the range, an isosurface'],
      ['Double click, Insert', 'add a point'],
      ['Delete', 'remove the selected point or isosurface'],
    ],
  ],
  [
    'Page',
    [
      ['Ctrl + Z', 'undo'],
      ['Ctrl + Shift + Z, Ctrl + Y', 'redo'],
      ['Ctrl + S', 'save the scene'],
      ['1, 2, 3, 4', 'Colour, Scene, Probe, Files'],
      ['H', 'hide or show the panel'],
      ['F', 'full screen, and back'],
      ['Escape', 'back to the picture'],
      ['?', 'this list'],
    ],
  ],
];

function build() {
  const groups = LIST.map(([name, rows]) =>
    h(
      'section',
      {},
      h('h3', {}, name),
      h(
        'dl',
        {},
        ...rows.flatMap(([keys, text]) => [
          h('dt', {}, ...keys.split(/(, | and )/).map((part, i) => (i % 2 ? part : h('kbd', {}, part)))),
          h('dd', {}, text),
        ]),
      ),
    ),
  );
  byId('help-list').replaceChildren(...groups);
}

/** Shows the list of shortcuts. */
function openHelp() {
  if (!help.open) help.showModal();
}

const PLAIN = {
  ArrowLeft: () => step(-1),
  ArrowRight: () => step(1),
  Home: () => goTo(0),
  End: () => goTo(last()),
  '+': () => zoomBy(1 / 1.12),
  '=': () => zoomBy(1 / 1.12),
  '-': () => zoomBy(1.12),
  '−': () => zoomBy(1.12),
  p: () => toggleCross(),
  h: () => showPanel(),
  f: () => toggleFullScreen(),
  '?': openHelp,
  1: () => focusTab(1),
  2: () => focusTab(2),
  3: () => focusTab(3),
  4: () => focusTab(4),
};
const SHIFTED = {
  ArrowLeft: () => turnBy(-TURN, 0),
  ArrowRight: () => turnBy(TURN, 0),
  ArrowUp: () => turnBy(0, TURN),
  ArrowDown: () => turnBy(0, -TURN),
};

function isText(element) {
  return element.matches?.('input:not([type="range"], [type="checkbox"], [type="radio"], [type="color"]), textarea');
}

function pressed(event) {
  if (event.defaultPrevented || help.open) return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const target = event.target;
  if (event.ctrlKey || event.metaKey) {
    const isUndo = key === 'z' && !event.shiftKey;
    const isRedo = key === 'y' || (key === 'z' && event.shiftKey);
    if ((isUndo || isRedo) && !isText(target)) act(isUndo ? '/api/undo' : '/api/redo');
    else if (key === 's') saveScene();
    else return;
    event.preventDefault();
    return;
  }
  if (event.altKey) return;
  const onPicture = target === byId('picture') || target === document.body;
  if (onPicture && crossKey(event)) {
    event.preventDefault();
    return;
  }
  if (key === 'Escape') {
    byId('picture').focus();
    return;
  }
  if (takesKeys(target)) return;
  if (key === ' ' && onPicture) {
    event.preventDefault();
    play();
    return;
  }
  const isArrow = key.startsWith('Arrow') || key === 'Home' || key === 'End';
  if (isArrow && target.closest('#panels')) return;
  const run = event.shiftKey && SHIFTED[key] ? SHIFTED[key] : PLAIN[key];
  if (!run) return;
  event.preventDefault();
  run();
}

/** Listens to keys. */
export function start() {
  build();
  document.addEventListener('keydown', pressed);
  byId('open-help').addEventListener('click', openHelp);
  byId('close-help').addEventListener('click', () => help.close());
  help.addEventListener('click', (event) => {
    if (event.target === help) help.close();
  });
}
