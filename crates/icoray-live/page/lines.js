// Coasts and graticule over pictures of a moving hand, which are drawn without them: on the ground, seen through nothing.
'use strict';

import { bytes } from './api.js';
import { towards } from './camera.js';

/** Degrees between points of meridians and parallels. */
const STEP = 2;
/** Steps of a degree in which coasts are written. */
const COAST_STEPS = 180;

let coast = null;
const graticules = new Map();
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Reads the coasts, once. Until they are there, none are drawn. */
export async function readCoast() {
  const view = new DataView(await bytes('/api/coast'));
  const runs = [];
  for (let at = 0; at < view.byteLength; ) {
    const count = view.getUint16(at, true);
    const degrees = (i, k) => view.getInt16(at + 2 + 4 * i + 2 * k, true) / COAST_STEPS;
    runs.push(Array.from({ length: count }, (_, i) => towards(degrees(i, 0), degrees(i, 1))));
    at += 2 + 4 * count;
  }
  coast = runs;
}

function points(from, to, at) {
  const count = Math.max(1, Math.ceil((to - from) / STEP));
  return Array.from({ length: count + 1 }, (_, i) => at(from + ((to - from) * i) / count));
}

/** Parallels, and meridians between the outermost of them; each fourth part of a turn goes on to the poles. */
function graticule(spacing) {
  const last = (Math.ceil(90 / spacing) - 1) * spacing;
  const most = Math.floor(180 / spacing);
  const runs = [];
  for (let lat = -last; lat <= last; lat += spacing) runs.push(points(-180, 180, (lon) => towards(lon, lat)));
  for (let k = -most; k <= most; k++) {
    const end = (k * spacing) % 90 === 0 ? 90 : last;
    runs.push(points(-end, end, (lat) => towards(k * spacing, lat)));
  }
  return runs;
}

function runsOf(spacing) {
  if (spacing === null) return coast ?? [];
  if (!graticules.has(spacing)) graticules.set(spacing, graticule(spacing));
  return graticules.get(spacing);
}

/**
 * The place of a point of the ground in a picture with this overlay and aspect ratio, in parts of its width and height,
 * or null behind the horizon.
 */
export function placeOn({ eye, axes, half_height, radius }, aspect, direction) {
  const [forward, right, up] = axes;
  const point = direction.map((x, i) => radius * x - eye[i]);
  const depth = 2 * half_height * dot(point, forward);
  if (depth <= 0 || dot(direction, eye) < radius) return null;
  return { x: 0.5 + dot(point, right) / (depth * aspect), y: 0.5 - dot(point, up) / depth };
}

/** Draws the lines of a picture's overlay on the part of the canvas that it takes, pixels of the screen. */
export function drawLines(context, [left, top, width, height], overlay) {
  context.save();
  context.beginPath();
  context.rect(left, top, width, height);
  context.clip();
  context.lineJoin = 'round';
  for (const { spacing, color, width: thickness, opacity } of overlay.lines) {
    context.beginPath();
    for (const run of runsOf(spacing)) {
      let isDrawn = false;
      for (const direction of run) {
        const place = placeOn(overlay, width / height, direction);
        const at = place && [left + width * place.x, top + height * place.y];
        if (at && isDrawn) context.lineTo(...at);
        else if (at) context.moveTo(...at);
        isDrawn = at !== null;
      }
    }
    context.lineWidth = thickness;
    context.strokeStyle = `rgb(${color.join(' ')} / ${opacity})`;
    context.stroke();
  }
  context.restore();
}
