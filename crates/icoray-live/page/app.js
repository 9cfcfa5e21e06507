// The page of icoray's live viewer. Plain modules without a build step; the server sends them as they are.
//
//   api.js             calls of the server, the token, errors
//   store.js           what the page knows (description, scene, frame), its events, histograms
//   sender.js          changes on their way to the server, one call at a time, merged while a hand moves
//   frames.js          the request for the next picture, always one in flight
//   view.js            the canvas: fits pictures, places in a picture, the size to ask for
//   lines.js           coasts and graticule over pictures of a moving hand
//   camera.js          geometry of the camera (no state, no DOM)
//   hand.js            mouse, touch and the keyboard's cross on the picture
//   timeline.js        slider of times, playing
//   facts.js           the fact line and the status region
//   probe.js, plot.js  the probe and its plots; hover.js the value under the mouse
//   transfer.js        the transfer function by hand; transfer-model.js its data, transfer-changes.js what a hand
//                      changes in the scene, transfer-panel.js and transfer-rows.js its elements, curve.js its picture,
//                      markers.js isosurfaces on the histogram, maps.js the swatches
//   form.js            controls generated from the description; widgets.js a control for each type, hints.js slider
//                      ranges and first entries, toml.js values as text
//   files.js           save, load, command line
//   views.js           the views of a scene, and links to what is shown
//   animate.js         an animation of all times; apng.js puts it together
//   panel.js, keys.js  tabs and sheet; shortcuts and their list
//   dom.js, format.js, colour.js  elements, numbers, colours
//
// Data flow: an input calls `move` or `change` of sender.js; the server answers with a revision; store.js reads the
// scene; the event `scene` shows it in all panels. Pictures come on their own way through frames.js.
'use strict';

import * as animate from './animate.js';
import { takeAddress } from './api.js';
import { byId } from './dom.js';
import * as facts from './facts.js';
import * as files from './files.js';
import * as form from './form.js';
import { run } from './frames.js';
import * as hand from './hand.js';
import * as hover from './hover.js';
import * as keys from './keys.js';
import * as panel from './panel.js';
import * as probe from './probe.js';
import { act, change, setSize } from './sender.js';
import { emit, on, readDescription, readScene, say, store } from './store.js';
import * as timeline from './timeline.js';
import * as transfer from './transfer.js';
import * as views from './views.js';
import { paint, paintStage, size } from './view.js';

let resizing = 0;
let asked = '';

/** Asks for a picture of the canvas's size, when that has changed. */
async function askForSize() {
  const wanted = size(false).join('x');
  if (!store.scene || wanted === asked) return;
  asked = wanted;
  await change([]);
}

function resized() {
  paint();
  emit('resize');
  clearTimeout(resizing);
  resizing = setTimeout(askForSize, 200);
}

function showState(scene) {
  byId('undo').disabled = !scene.can_undo;
  byId('redo').disabled = !scene.can_redo;
  paintStage();
}

function showDescription({ title, program, live }) {
  byId('title').textContent = title;
  byId('program').textContent = program;
  byId('live').hidden = !live;
  document.title = `${title} – ${program}`;
}

async function start() {
  const linked = takeAddress();
  for (const part of [facts, panel, form, transfer, probe, hover, files, views, animate, timeline, hand, keys]) part.start();
  setSize(size);
  on('describe', showDescription);
  on('scene', showState);
  on('gone', () => document.body.classList.add('is-gone'));
  on('back', () => {
    document.body.classList.remove('is-gone');
    asked = '';
    askForSize();
  });
  // A hidden panel stays hidden: the status shows the value.
  on('probed', (answer) => {
    if (answer.hit && panel.isShown()) panel.openTab('probe');
  });
  byId('undo').addEventListener('click', () => act('/api/undo'));
  byId('redo').addEventListener('click', () => act('/api/redo'));
  new ResizeObserver(resized).observe(byId('picture'));
  for (;;) {
    try {
      await readDescription();
      await readScene();
      break;
    } catch (error) {
      say(error.message, 'error');
      if (error.status === 401) return;
      await new Promise((resolve) => setTimeout(resolve, 2000));
    }
  }
  say('', 'none');
  run();
  // A call that succeeds takes away what was said before.
  await askForSize();
  await views.follow(linked);
}

start();
