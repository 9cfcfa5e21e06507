// The times: a slider, steps and playing.
'use strict';

import { byId, h, icon } from './dom.js';
import { timeText } from './format.js';
import { move, rest } from './sender.js';
import { on, store } from './store.js';

/** Shortest time between two pictures while playing, milliseconds. */
const LEAST = 100;

const slider = byId('time');
const label = byId('time-label');
const button = byId('play');
let time = 0;
let isPlaying = false;
let since = 0;

const count = () => store.describe?.times.length ?? 0;

function show() {
  const last = Math.max(0, count() - 1);
  byId('timeline').hidden = count() < 2;
  slider.max = last;
  slider.value = time;
  const text = timeText(store.describe?.times[time], time);
  slider.setAttribute('aria-valuetext', text);
  label.replaceChildren(h('span', { class: 'name' }, `${text}  `), `${time + 1}/${last + 1}`);
}

/** Shows a time, by its number. */
export function goTo(wanted, { stays = false } = {}) {
  const next = Math.max(0, Math.min(count() - 1, wanted));
  if (next === time || count() < 2) return;
  time = next;
  since = performance.now();
  show();
  move([], { time, stays });
}

/** Goes a number of times forward, or back. */
export const step = (by) => goTo(time + by);

/** The number of the last time. */
export const last = () => count() - 1;

function onward() {
  if (!isPlaying) return;
  goTo(time + 1 >= count() ? 0 : time + 1, { stays: true });
}

/** Plays through the times, or stops. Each picture is awaited before the next time is asked for. */
export function play(wanted = !isPlaying) {
  if (wanted === isPlaying || count() < 2) return;
  isPlaying = wanted;
  button.replaceChildren(icon(isPlaying ? 'pause' : 'play'));
  button.setAttribute('aria-label', isPlaying ? 'Stop playing' : 'Play through the times');
  button.title = button.getAttribute('aria-label');
  if (isPlaying) onward();
  else rest();
}

/** Listens to the slider, and to pictures while playing. */
export function start() {
  slider.addEventListener('input', () => {
    play(false);
    goTo(Number(slider.value));
  });
  button.addEventListener('click', () => play());
  byId('earlier').addEventListener('click', () => step(-1));
  byId('later').addEventListener('click', () => step(1));
  on('describe', show);
  on('scene', (scene) => {
    if (!store.isMoving) time = scene.time;
    show();
  });
  on('frame', (frame) => {
    if (!isPlaying || frame.time !== time) return;
    setTimeout(onward, Math.max(0, LEAST - (performance.now() - since)));
  });
  on('message', ({ kind }) => {
    if (kind === 'error') play(false);
  });
}
