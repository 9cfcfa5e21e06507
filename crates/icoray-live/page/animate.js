// Saving an animation of all times: pictures at rest one after the other, put together on the page.
'use strict';

import { animation } from './apng.js';
import { file } from './api.js';
import { byId } from './dom.js';
import { save } from './format.js';
import { on, say, store } from './store.js';

/** Pictures per second. */
const FPS = 10;

const button = byId('save-animation');
let isStopped = true;

async function draw() {
  const count = store.describe.times.length;
  const pictures = [];
  for (let time = 0; time < count && !isStopped; time++) {
    say(`Time ${time + 1} of ${count} is drawn.`);
    const { blob } = await file(`/api/picture?format=png&time=${time}`);
    pictures.push(new Uint8Array(await blob.arrayBuffer()));
  }
  if (isStopped) return say('No animation is saved.');
  save(new Blob(animation(pictures, FPS), { type: 'image/apng' }), 'animation.png');
  say('The animation is saved as animation.png.');
}

/** Draws and saves the animation, or stops that. */
async function toggle() {
  isStopped = !isStopped;
  if (isStopped) return;
  button.textContent = 'Stop the animation';
  try {
    await draw();
  } catch (error) {
    say(error.message, 'error');
  } finally {
    isStopped = true;
    button.textContent = 'Save animation';
  }
}

/** Listens to the button, which is there where a file has several times. */
export function start() {
  button.addEventListener('click', toggle);
  on('describe', ({ times }) => {
    button.hidden = times.length < 2;
  });
}
