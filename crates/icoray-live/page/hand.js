// Mouse, touch and keys on the picture: turns, zooms, centres, probes, moves the cross.
'use strict';

import { byId } from './dom.js';
import { cameraOf, centred, changesOf, degreesPerPixel, placeOnGround, turned, zoomed } from './camera.js';
import { emit, on, say, store } from './store.js';
import { move, rest } from './sender.js';
import { pictureBox, placeOf, put } from './view.js';
import { ask, place as probed } from './probe.js';

const CLICK = 4;
const DOUBLE = 380;

const canvas = byId('picture');
const cross = byId('cross');
const pointers = new Map();
let camera = null;
let press = null;
let lastClick = null;
let at = null;

/** The camera as the hand has moved it, ahead of the server's scene. */
export const currentCamera = () => camera;

function go(next) {
  if (!camera || next === camera) return;
  const changes = changesOf(next, camera);
  camera = next;
  if (changes.length > 0) {
    move(changes);
    emit('camera', camera);
  }
}

/** Turns by pixels of the picture: what is under the hand follows. */
function drag(dx, dy) {
  const scale = degreesPerPixel(camera, pictureBox().height);
  go(turned(camera, dx * scale, -dy * scale));
}

/** Turns by parts of the picture's height, for keys. */
export function turnBy(right, up) {
  if (camera) drag(-right * pictureBox().height, up * pictureBox().height);
}

/** Zooms by a factor on the distance. */
export const zoomBy = (factor) => camera && go(zoomed(camera, factor));

function middle() {
  const all = [...pointers.values()];
  const x = all.reduce((sum, p) => sum + p.x, 0) / all.length;
  const y = all.reduce((sum, p) => sum + p.y, 0) / all.length;
  const spread = all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0;
  return { x, y, spread };
}

function down(event) {
  if (event.button > 0) return;
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  const from = middle();
  press = { from, last: from, isDrag: pointers.size > 1, isTouch: event.pointerType === 'touch' };
}

function moved(event) {
  if (!pointers.has(event.pointerId) || !press || !camera) return;
  pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  const now = middle();
  const slack = press.isTouch ? CLICK * 2 : CLICK;
  if (!press.isDrag) {
    if (Math.hypot(now.x - press.from.x, now.y - press.from.y) < slack) return;
    press.isDrag = true;
    canvas.classList.add('is-dragged');
  }
  drag(now.x - press.last.x, now.y - press.last.y);
  if (press.last.spread > 0 && now.spread > 0) zoomBy(press.last.spread / now.spread);
  press.last = now;
}

function up(event) {
  if (!pointers.delete(event.pointerId)) return;
  if (pointers.size > 0) {
    press.last = middle();
    return;
  }
  canvas.classList.remove('is-dragged');
  if (press && !press.isDrag && event.type === 'pointerup') click(event);
  else rest();
  press = null;
}

function click(event) {
  const place = placeOf(event);
  if (place.x < 0 || place.x > 1 || place.y < 0 || place.y > 1) return;
  const isDouble =
    lastClick &&
    event.timeStamp - lastClick.time < DOUBLE &&
    Math.hypot(event.clientX - lastClick.x, event.clientY - lastClick.y) < 24;
  lastClick = isDouble ? null : { time: event.timeStamp, x: event.clientX, y: event.clientY };
  if (isDouble) centreAt(place);
  else ask(place);
}

/** Brings what is at a place of the picture to its middle. */
async function centreAt(place) {
  const answer = await probed(place);
  const box = pictureBox();
  const found = answer?.hit ? answer : placeOnGround(camera, place, box.width / box.height);
  if (!found) return say('There is nothing here to centre.', 'info');
  go(centred(camera, found.lon, found.lat));
  rest();
}

function wheel(event) {
  event.preventDefault();
  const lines = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1;
  const pixels = Math.max(-160, Math.min(160, event.deltaY * lines));
  zoomBy(Math.exp(pixels * (event.ctrlKey ? 0.01 : 0.0016)));
}

/** Shows or hides the cross with which the keyboard probes. */
export function toggleCross() {
  at = at ? null : { x: 0.5, y: 0.5 };
  cross.hidden = !at;
  if (at) {
    put(cross, at);
    canvas.focus({ preventScroll: true });
    say('Arrow keys move the cross, Enter probes, C centres, Escape hides the cross.', 'info');
  } else {
    say('', 'none');
  }
}

/** Takes a key while the cross is shown; returns whether it did. */
export function crossKey(event) {
  if (!at) return false;
  const step = event.shiftKey ? 0.05 : 0.01;
  const steps = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
  if (steps) {
    at = { x: Math.min(1, Math.max(0, at.x + steps[0])), y: Math.min(1, Math.max(0, at.y + steps[1])) };
    put(cross, at);
  } else if (event.key === 'Enter') {
    ask(at);
  } else if (event.key === 'c' || event.key === 'C') {
    centreAt(at);
  } else if (event.key === 'Escape') {
    toggleCross();
  } else {
    return false;
  }
  return true;
}

/** Listens to the hand. */
export function start() {
  canvas.addEventListener('pointerdown', down);
  canvas.addEventListener('pointermove', moved);
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
  // Fingers lifted in motion would set off a scroll, and the next touch would stop that instead of being a click.
  canvas.addEventListener('touchmove', (event) => event.preventDefault(), { passive: false });
  canvas.addEventListener('wheel', wheel, { passive: false });
  on('scene', (scene) => {
    if (!store.isMoving) camera = cameraOf(scene);
  });
  on('resize', () => at && put(cross, at));
}
