// Changes on their way to the server. One call is in flight at a time. Changes of a moving hand that wait are merged
// into one, so that only the newest is sent.
'use strict';

import { call, post } from './api.js';
import { emit, readScene, say, store } from './store.js';

/** Milliseconds after the last input at which a picture at rest is asked for. */
const REST = 150;

let waiting = [];
let isSending = false;
let settling = 0;
let moved = null;
let sizeOf = () => undefined;
/** This page's number among those that show the same scene: the largest has its picture's size. */
const page = crypto.getRandomValues(new Uint32Array(1))[0];

/** States where the size of a picture comes from: `(isMoving) => [width, height]`. */
export function setSize(source) {
  sizeOf = source;
}

function merge(into, from) {
  const changes = new Map(into.changes.map((change) => [JSON.stringify(change.path), change]));
  for (const change of from.changes) {
    const key = JSON.stringify(change.path);
    changes.delete(key);
    changes.set(key, change);
  }
  into.changes = [...changes.values()];
  if (from.time !== undefined) into.time = from.time;
  if (from.view !== undefined) into.view = from.view;
  return into;
}

/** Sends changes of something that a hand moves; 150 ms after the last, the picture at rest is asked for. */
export function move(changes, { time, stays = false } = {}) {
  const item = { changes, time, isMoving: true };
  moved = merge(moved ?? { changes: [] }, item);
  if (!store.isMoving) emit('moving', true);
  store.isMoving = true;
  push(item);
  clearTimeout(settling);
  if (!stays) settling = setTimeout(rest, REST);
}

/** Ends a movement at once. */
export function rest() {
  clearTimeout(settling);
  if (!moved) return;
  const { changes, time } = moved;
  moved = null;
  push({ changes, time, isMoving: false });
}

/** Sends changes that are one step of undo; resolves to whether the server took them. */
export function change(changes, { time, view } = {}) {
  rest();
  return new Promise((resolve) => push({ changes, time, view, isMoving: false, resolve }));
}

/** Calls `/api/undo`, `/api/redo`, `/api/load` or `/api/look` in turn with the changes. */
export function act(path, value) {
  rest();
  return new Promise((resolve) => push({ path, value, changes: [], isMoving: false, resolve }));
}

function push(item) {
  const last = waiting.at(-1);
  if (last?.isMoving && !item.path) {
    merge(last, item);
    last.isMoving = item.isMoving;
    last.resolve = item.resolve;
  } else {
    waiting.push(item);
  }
  if (!isSending) send();
}

async function send() {
  isSending = true;
  while (waiting.length > 0) {
    const item = waiting.shift();
    let isTaken = true;
    try {
      if (item.path) {
        await post(item.path, item.value);
      } else {
        const { changes, time, view, isMoving } = item;
        await post('/api/change', { changes, time, view, size: sizeOf(isMoving), page, is_moving: isMoving });
      }
      if (!item.isMoving) say('', 'none');
    } catch (error) {
      isTaken = false;
      if (!error.isGone) say(error.message, 'error');
    }
    if (!item.isMoving && waiting.length === 0 && !moved) {
      // Panels show the scene again when it is read, not the one from before the movement.
      const wasMoving = store.isMoving;
      store.isMoving = false;
      await readScene().catch(() => {});
      if (wasMoving && !store.isMoving) emit('moving', false);
    }
    item.resolve?.(isTaken);
  }
  isSending = false;
}

// A page that is closed gives up its size, and ends its movement: other pages would keep the coarse picture.
addEventListener('pagehide', () => {
  const headers = { 'Content-Type': 'application/json' };
  const body = JSON.stringify({ size: [0, 0], page, is_moving: false });
  call('/api/change', { method: 'POST', headers, body, keepalive: true }).catch(() => {});
});
