// A small line plot as SVG.
'use strict';

import { s } from './dom.js';
import { shown } from './format.js';

const [WIDTH, HEIGHT] = [320, 180];
const [LEFT, RIGHT, TOP, BOTTOM] = [74, 10, 10, 38];

/** Round numbers between two ends, about `count` of them. */
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  if (!(raw > 0) || !Number.isFinite(raw)) return [];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((m) => m >= raw * 0.999);
  const first = Math.ceil(low / step - 1e-9);
  const found = new Set();
  // A step may be less than the last digit of the ends: then it leads nowhere.
  for (let k = 0; k <= 2 * count + 2 && (first + k) * step <= high + step * 1e-9; k += 1) {
    found.add(Number(((first + k) * step).toPrecision(12)));
  }
  return [...found];
}

/** Number of digits that distinguishes the ticks of an axis, at least `least`. */
export function tickDigits(places, least = 4) {
  const step = places.length > 1 ? Math.abs(places[1] - places[0]) : 0;
  const most = Math.max(...places.map(Math.abs));
  return step > 0 ? Math.max(least, Math.ceil(Math.log10(most / step)) + 2) : least;
}

function span(values) {
  const known = values.filter((v) => Number.isFinite(v));
  let [low, high] = [Math.min(...known), Math.max(...known)];
  if (known.length === 0) [low, high] = [0, 1];
  if (low === high) {
    const room = Math.abs(low) * 0.01 || 1;
    [low, high] = [low - room, high + room];
  }
  return [low, high];
}

/** A plot of points {x, y, weight}: a line that breaks where y is null, and the weights as an area. */
export function plot({ points, mark, x, y, label }) {
  const known = points.filter((p) => Number.isFinite(p.y));
  const [x0, x1] = span([...points.map((p) => p.x), mark?.x]);
  const [y0, y1] = span([...known.map((p) => p.y), mark?.y]);
  const px = (v) => LEFT + ((v - x0) / (x1 - x0)) * (WIDTH - LEFT - RIGHT);
  const py = (v) => HEIGHT - BOTTOM - ((v - y0) / (y1 - y0)) * (HEIGHT - TOP - BOTTOM);
  const base = HEIGHT - BOTTOM;
  const root = s('svg', {
    class: 'plot',
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
    role: 'img',
    'aria-label': `${label}: ${shown(y0)} to ${shown(y1)} over ${shown(x0)} to ${shown(x1)}`,
  });
  const [across, along] = [ticks(y0, y1, 4), ticks(x0, x1, 4)];
  for (const v of across) {
    root.append(
      s('line', { class: 'grid', x1: LEFT, x2: WIDTH - RIGHT, y1: py(v), y2: py(v) }),
      s('text', { x: LEFT - 6, y: py(v) + 3.5, 'text-anchor': 'end' }, shown(v, tickDigits(across))),
    );
  }
  for (const v of along) {
    root.append(
      s('line', { class: 'grid', x1: px(v), x2: px(v), y1: TOP, y2: base }),
      s('text', { x: px(v), y: base + 13, 'text-anchor': 'middle' }, shown(v, tickDigits(along))),
    );
  }
  const most = Math.max(...points.map((p) => p.weight ?? 0));
  if (most > 0) {
    const sorted = [...points].sort((a, b) => a.x - b.x);
    const top = sorted.map((p) => `${px(p.x).toFixed(1)},${(base - (p.weight / most) * (base - TOP)).toFixed(1)}`);
    root.append(
      s('polygon', {
        class: 'weight',
        points: `${px(sorted[0].x)},${base} ${top.join(' ')} ${px(sorted.at(-1).x)},${base}`,
      }),
    );
  }
  let path = '';
  let isBroken = true;
  for (const p of points) {
    if (Number.isFinite(p.y)) path += `${isBroken ? 'M' : 'L'}${px(p.x).toFixed(1)} ${py(p.y).toFixed(1)}`;
    isBroken = !Number.isFinite(p.y);
  }
  root.append(s('path', { class: 'line', d: path }));
  if (mark && Number.isFinite(mark.x) && Number.isFinite(mark.y)) {
    root.append(s('circle', { class: 'mark', cx: px(mark.x), cy: py(mark.y), r: 4 }));
  }
  root.append(
    s('text', { class: 'title', x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 6, 'text-anchor': 'middle' }, x),
    s(
      'text',
      { class: 'title', transform: `translate(11 ${(TOP + base) / 2}) rotate(-90)`, 'text-anchor': 'middle' },
      y,
    ),
  );
  return root;
}
