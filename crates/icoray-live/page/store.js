// The state of the page: the description, the scene, the last frame. Modules listen to its events.
'use strict';

import { get } from './api.js';

const listeners = new Map();

/** State of the page; null until the server has answered. */
export const store = {
  describe: null,
  scene: null,
  frame: null,
  /** Whether a hand moves something now: then the scene on the page is ahead of the server's. */
  isMoving: false,
};

/** Calls `listener` at each event: `describe`, `scene`, `frame`, `camera`, `time`, `message`, `moving`. */
export function on(event, listener) {
  if (!listeners.has(event)) listeners.set(event, []);
  listeners.get(event).push(listener);
}

/** Calls the listeners of an event. */
export function emit(event, value) {
  for (const listener of listeners.get(event) ?? []) listener(value);
}

/** Shows a sentence; `kind` is `error`, `info` or `none`. */
export const say = (text, kind = 'info') => emit('message', { text, kind });

let reading = null;
let isStale = false;

/** Reads the scene anew; calls during a reading lead to one more. */
export async function readScene() {
  isStale = true;
  reading ??= (async () => {
    try {
      while (isStale) {
        isStale = false;
        const scene = await get('/api/scene');
        if (!isStale) {
          store.scene = scene;
          emit('scene', scene);
        }
      }
    } finally {
      reading = null;
    }
  })();
  return reading;
}

/** Reads the description of fields, times and keys. */
export async function readDescription() {
  store.describe = await get('/api/describe');
  emit('describe', store.describe);
}

/** The scene's value at a path, or undefined. */
export function valueAt(path, values = store.scene?.values) {
  let value = values;
  for (const key of path) value = value?.[key];
  return value;
}

const histograms = new Map();

/** The histogram of a field at the time shown, read once for each time. */
export function histogram(field) {
  const key = `${store.scene?.time}/${field}`;
  if (!histograms.has(key)) {
    if (histograms.size > 24) histograms.clear();
    const found = get(`/api/histogram?field=${encodeURIComponent(field)}`);
    histograms.set(key, found);
    found.catch(() => histograms.delete(key));
  }
  return histograms.get(key);
}

/** Forgets histograms, as after a change of derived fields. */
export const forgetHistograms = () => histograms.clear();
