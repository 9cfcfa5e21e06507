// Pictures from the server: one request for the next picture is in flight at any time.
'use strict';

import { bytes } from './api.js';
import { byId } from './dom.js';
import { readCoast } from './lines.js';
import { emit, on, readDescription, readScene, say, store } from './store.js';
import { draw, room } from './view.js';

const RETRY = 2000;
let inFlight = new AbortController();
const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** The header, the picture and its labels of an answer; without a picture where the scene could not be drawn. */
async function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const meta = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  if (meta.failure) return { meta, layers: [] };
  const end = buffer.byteLength - (meta.labels ?? 0);
  const parts = [buffer.slice(4 + length, end), buffer.slice(end)].filter((part) => part.byteLength > 0);
  const layers = parts.map((part) => createImageBitmap(new Blob([part], { type: 'image/png' })));
  return { meta, layers: await Promise.all(layers) };
}

/** Takes what the server knows that the page does not: steps of a model that runs, changes of another page. */
async function follow(meta) {
  const { scene } = store;
  if (scene && !store.isMoving && meta.revision !== scene.revision) await readScene();
}

// Labels are made for the size that the page had when it asked.
on('resize', () => inFlight.abort());

/** Asks for pictures for ever. When the program has ended, tries again every two seconds. */
export async function run() {
  readCoast().catch(() => {});
  let number = 0;
  let isGone = false;
  for (;;) {
    try {
      if (isGone) {
        await readDescription();
        await readScene();
        number = 0;
        isGone = false;
        say('The program answers again.', 'info');
        emit('back');
      }
      const [width, height] = room();
      inFlight = new AbortController();
      const path = `/api/frame?after=${number}&width=${width}&height=${height}`;
      const buffer = await bytes(path, { signal: inFlight.signal });
      if (!buffer) continue;
      const { meta, layers } = await decode(buffer);
      number = meta.number;
      byId('drawing').hidden = true;
      if (meta.failure) {
        say(meta.failure, 'error');
        await follow(meta);
        continue;
      }
      store.frame = meta;
      draw(layers, meta.overlay);
      emit('frame', meta);
      if (meta.refused) say(meta.refused, 'error');
      await follow(meta);
    } catch (error) {
      if (error.name === 'AbortError') continue;
      if (error.isGone && !isGone) {
        isGone = true;
        say(error.message, 'error');
        emit('gone');
      } else if (!error.isGone && error.message) {
        say(error.message, 'error');
      }
      if (error.status === 401) return;
      await wait(RETRY);
    }
  }
}
