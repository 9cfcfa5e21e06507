// Isosurfaces as marks on the histogram.
'use strict';

import { hexOf } from './colour.js';
import { keepVolume } from './hints.js';
import { store } from './store.js';
import { percentile } from './transfer-model.js';

const COLOURS = ['#9fe0e8', '#f2b36b', '#c3a6ff', '#9fd88a', '#f08ca0'];
let moved = new Map();

const fieldOf = (entry) => entry.field ?? store.scene.values.field ?? store.scene.field;

/** Isosurfaces of a field: { value, colour, path }, in the scene's order. */
export function markersOf(field) {
  if (!store.isMoving) moved = new Map();
  const found = [];
  (store.scene.values.isosurfaces ?? []).forEach((entry, i) => {
    if (fieldOf(entry) !== field) return;
    const values = entry.values ?? (entry.value === undefined ? [] : [entry.value]);
    values.forEach((value, j) =>
      found.push({
        value: moved.get(`${i}/${j}`) ?? value,
        entry: i,
        part: j,
        isList: Boolean(entry.values),
        count: values.length,
        colour: hexOf(entry.colors?.[j] ?? entry.color) ?? '#ffffff',
      }),
    );
  });
  return found;
}

/** Changes that move an isosurface of a field to a value, or remove it (null). */
export function moveMarker(field, index, value) {
  const marker = markersOf(field)[index];
  if (!marker) return [];
  const { entry, part, isList, count } = marker;
  if (value === null) {
    if (!isList || count === 1) return [{ path: ['isosurfaces', entry], value: null }];
    const own = store.scene.values.isosurfaces[entry];
    const without = (list) => list.filter((_, i) => i !== part);
    const colors = own.colors ? [{ path: ['isosurfaces', entry, 'colors'], value: without(own.colors) }] : [];
    return [{ path: ['isosurfaces', entry, 'values'], value: without(own.values) }, ...colors];
  }
  moved.set(`${entry}/${part}`, value);
  if (!isList) return [{ path: ['isosurfaces', entry, 'value'], value }];
  const list = store.scene.values.isosurfaces[entry].values.map((old, i) => moved.get(`${entry}/${i}`) ?? old);
  return [{ path: ['isosurfaces', entry, 'values'], value: list }];
}

/** The change that adds an isosurface of a field at its middle value. */
export function newIsosurface(field, histogram, resolved) {
  const count = store.scene.values.isosurfaces?.length ?? 0;
  const median = percentile(histogram, 50);
  const [low, high] = resolved.range;
  const value = median > low && median < high ? median : (low + high) / 2;
  const entry = { field, value: Number(value.toPrecision(4)), color: COLOURS[count % COLOURS.length], opacity: 0.6 };
  return [...keepVolume('isosurfaces'), { path: ['isosurfaces', count], value: entry }];
}
