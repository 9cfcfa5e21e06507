// The fact line: what is seen, at which error, in which time, and what was left out.
'use strict';

import { byId, h } from './dom.js';
import { shown, timeText } from './format.js';
import { on, store } from './store.js';

function seconds(value) {
  return value < 0.995 ? `${Math.max(1, Math.round(value * 1000))} ms` : `${value.toFixed(value < 10 ? 1 : 0)} s`;
}

/** Whether a model that runs has not drawn yet what was set. */
const isAhead = (frame) => store.describe?.live && (store.scene?.revision ?? 0) > frame.revision;

function show(frame) {
  const isOver = frame.error > frame.tolerance;
  const error =
    frame.error === null || frame.error === undefined
      ? 'error unknown'
      : `error ${frame.is_bound ? '≤' : '≈'} ${shown(frame.error, 2)}`;
  const aim = frame.tolerance ? h('span', { class: 'aim' }, ` (tolerance ${shown(frame.tolerance, 2)})`) : null;
  const label = frame.time_label || store.describe?.times[frame.time];
  const facts = [
    h('span', {}, store.scene?.field ?? ''),
    label ? h('span', {}, timeText(label, frame.time)) : null,
    h('span', { class: isOver ? 'is-over' : '' }, error, aim),
    h('span', {}, seconds(frame.seconds)),
    frame.quality ? h('span', { class: 'quality' }, frame.quality) : null,
    frame.pending ? h('span', { class: 'is-pending' }, 'refining') : null,
    isAhead(frame) ? h('span', { class: 'is-pending' }, 'what you have set is drawn at the next picture') : null,
  ];
  byId('facts').replaceChildren(h('span', {}, h('span', {}, ...facts)));
  const left = frame.left_out ?? [];
  byId('left-out').hidden = left.length === 0;
  byId('left-out').textContent = `Left out: ${left.join('; ')}`;
  byId('left-out').title = left.join('; ');
}

/** The status region: the sentence of the last call. */
function message({ text, kind }) {
  const isError = kind === 'error';
  const box = byId(isError ? 'alert' : 'status');
  const other = byId(isError ? 'status' : 'alert');
  other.textContent = '';
  box.textContent = text;
  clearTimeout(message.timer);
  if (text && !isError)
    message.timer = setTimeout(() => {
      box.textContent = '';
    }, 6000);
}

/** Listens to pictures and messages. */
export function start() {
  on('frame', show);
  on('scene', () => store.describe?.live && store.frame && show(store.frame));
  on('message', (said) => {
    if (said.kind !== 'none') message(said);
    else byId('alert').textContent = '';
  });
}
