// The probe: what the light of a pixel comes from, and the values along its ray.
'use strict';

import { get } from './api.js';
import { byId, h } from './dom.js';
import { degrees, shown } from './format.js';
import { plot } from './plot.js';
import { emit, on, say, store } from './store.js';
import { pictureBox, put } from './view.js';

const mark = byId('mark');
let running = null;
let last = null;
let along = 'distance';

/** The server's answer for a place of the picture, or null after an error. */
export function place(where) {
  const key = `${where.x.toFixed(4)}/${where.y.toFixed(4)}/${store.frame?.number}`;
  if (running?.key !== key) {
    const found = get(`/api/probe?x=${where.x.toFixed(5)}&y=${where.y.toFixed(5)}`).catch((error) => {
      if (!error.isGone) say(error.message, 'error');
      return null;
    });
    running = { key, found };
  }
  return running.found;
}

const aspect = () => pictureBox().width / pictureBox().height;

/** Puts the mark on the place that was probed, in a picture of another aspect too. */
function putMark() {
  if (last) put(mark, { x: 0.5 + ((last.where.x - 0.5) * last.aspect) / aspect(), y: last.where.y });
}

/** Probes a place and shows the answer; `isAgain` for the same place in a new picture. */
export async function ask(where, isAgain = false) {
  const own = place(where);
  if (!isAgain) put(mark, where);
  mark.hidden = false;
  const answer = await own;
  if (!answer || running.found !== own) return;
  last = { answer, where, aspect: aspect(), revision: store.frame?.revision };
  if (!answer.hit) {
    mark.hidden = true;
    if (!isAgain) say('This pixel shows the background.', 'info');
  } else if (!isAgain) {
    const { lon, lat, value, units, field } = answer;
    say(`${field} ${shown(value)} ${units ?? ''} at ${degrees(lat, 'N', 'S')}, ${degrees(lon, 'E', 'W')}`, 'info');
  }
  show();
  if (!isAgain) emit('probed', answer);
}

const row = (name, text, kind) => [h('dt', {}, name), h('dd', { class: kind }, text)];

function facts(answer) {
  const units = answer.units ? ` ${answer.units}` : '';
  const tolerance = store.frame?.tolerance;
  const isOver = tolerance !== undefined && answer.error > tolerance;
  return h(
    'dl',
    { class: 'facts-list' },
    ...row('Longitude', degrees(answer.lon, 'E', 'W')),
    ...row('Latitude', degrees(answer.lat, 'N', 'S')),
    ...row('Height', answer.height_m === null || answer.height_m === undefined ? '–' : `${shown(answer.height_m)} m`),
    ...row('Shows', answer.part ?? 'nothing'),
    ...row('Opacity', shown(answer.alpha, 3)),
    ...row(
      `Error of the pixel`,
      shown(answer.error, 2) + (isOver ? ', above the tolerance' : ''),
      isOver ? 'is-over' : '',
    ),
    ...row('Field', answer.field + (units && `, ${units.trim()}`)),
    ...(answer.step === null ? [] : row('Step', String(answer.step))),
  );
}

/** The parts of the scene that the pixel shows, with their shares of its light. */
function contributions(answer) {
  const rows = answer.contributions.map(({ part, field, value, weight, height_m: height }) => {
    const what = field ? `${part}: ${field}${value === null ? '' : ` ${shown(value)}`}` : part;
    return h('li', {}, `${what}, ${shown(height / 1000, 3)} km, ${shown(100 * weight, 3)} %`);
  });
  return rows.length > 1 && [h('h3', {}, 'What the pixel shows'), h('ul', { class: 'parts' }, ...rows)];
}

function show() {
  const panel = byId('probe');
  if (!last || !last.answer.hit) {
    const text = last
      ? 'This pixel shows the background.'
      : 'Click a pixel of the picture, or press P for a cross that the arrow keys move.';
    panel.replaceChildren(h('p', { class: 'hint' }, text));
    return;
  }
  const { answer } = last;
  const units = answer.units ? ` (${answer.units})` : '';
  const pick = h(
    'select',
    {
      'aria-label': 'Horizontal axis of the ray',
      onchange: (event) => {
        along = event.target.value;
        show();
        byId('probe').querySelector('select')?.focus();
      },
    },
    h('option', { value: 'distance', selected: along === 'distance' }, 'over distance'),
    h('option', { value: 'height_m', selected: along === 'height_m' }, 'over height'),
  );
  const points = answer.along.map((p) => ({
    x: along === 'distance' ? p.distance : p.height_m / 1000,
    y: p.value,
    weight: p.length > 0 ? p.weight / p.length : 0,
  }));
  const ray = plot({
    points,
    mark: along === 'distance' ? null : { x: answer.height_m / 1000, y: answer.value },
    x: along === 'distance' ? 'distance from the camera (planet radii)' : 'height (km)',
    y: answer.field + units,
    label: `${answer.field} along the ray`,
  });
  const column =
    answer.column?.values?.length > 1 &&
    plot({
      points: answer.column.values.map((value, i) => ({ x: value, y: answer.column.height_m[i] / 1000 })),
      mark: { x: answer.value, y: answer.height_m / 1000 },
      x: answer.field + units,
      y: 'height (km)',
      label: `${answer.field} in the column`,
    });
  panel.replaceChildren(
    h('p', { class: 'value' }, shown(answer.value, 5), h('span', { class: 'units' }, ` ${answer.units ?? ''}`)),
    facts(answer),
    ...(contributions(answer) || []),
    h('div', { class: 'head-row' }, h('h3', {}, 'Along the ray'), pick),
    ray,
    h('p', { class: 'hint' }, 'The shaded area is the part of the pixel’s light that comes from each place.'),
    ...(column ? [h('h3', {}, 'In the column'), column] : []),
  );
}

/** Builds the panel. */
export function start() {
  show();
  on('camera', () => {
    mark.hidden = true;
  });
  on('resize', putMark);
  on('frame', (frame) => {
    putMark();
    const isNew = last && !mark.hidden && frame.revision !== last.revision;
    if (isNew && !frame.is_moving && !frame.pending) {
      ask({ x: 0.5 + ((last.where.x - 0.5) * last.aspect) / aspect(), y: last.where.y }, true);
    }
  });
}
