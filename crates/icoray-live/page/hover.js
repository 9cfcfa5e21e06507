// The value under the mouse while it rests on the picture at rest: one probe is in flight at any time.
'use strict';

import { get } from './api.js';
import { byId } from './dom.js';
import { degrees, shown } from './format.js';
import { on, store } from './store.js';
import { pictureBox, placeOf } from './view.js';

const canvas = byId('picture');
const label = byId('hover');
let wanted = null;
let isAsking = false;

/**
 * Whether a probe delays no picture: it would end a picture that is being drawn, and a running model answers one in
 * each of its steps.
 */
function isFree() {
  const { describe, frame, isMoving, scene } = store;
  return frame && !describe.live && !isMoving && !frame.pending && !frame.is_moving && frame.revision === scene.revision;
}

function hide() {
  wanted = null;
  label.hidden = true;
}

function show({ hit, field, value, units, lon, lat }, { x, y }) {
  label.hidden = !hit;
  if (!hit) return;
  label.textContent = `${field} ${shown(value)} ${units ?? ''} · ${degrees(lat, 'N', 'S')}, ${degrees(lon, 'E', 'W')}`;
  const box = pictureBox();
  const isRight = x > 0.5;
  label.style.left = isRight ? '' : `${box.left + x * box.width + 14}px`;
  label.style.right = isRight ? `${canvas.clientWidth - box.left - x * box.width + 14}px` : '';
  label.style.top = `${Math.max(0, box.top + y * box.height - 34)}px`;
}

/** Asks for the newest place until the mouse has not moved meanwhile. */
async function ask() {
  if (isAsking) return;
  isAsking = true;
  while (wanted && isFree()) {
    const place = wanted;
    const answer = await get(`/api/probe?x=${place.x.toFixed(5)}&y=${place.y.toFixed(5)}`).catch(() => null);
    if (wanted && answer) show(answer, place);
    if (!answer || wanted === place) break;
  }
  isAsking = false;
}

function moved(event) {
  const place = placeOf(event);
  const isInside = place.x >= 0 && place.x <= 1 && place.y >= 0 && place.y <= 1;
  if (event.pointerType !== 'mouse' || event.buttons > 0 || !isInside || !isFree()) return hide();
  wanted = place;
  ask();
}

/** Listens to the mouse, and to what makes the value another one. */
export function start() {
  canvas.addEventListener('pointermove', moved);
  canvas.addEventListener('pointerleave', hide);
  canvas.addEventListener('pointerdown', hide);
  for (const event of ['camera', 'moving', 'frame', 'resize']) on(event, hide);
}
