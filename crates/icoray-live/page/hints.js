// Hints for generated controls that the description lacks: comfortable ranges of sliders and first entries of lists.
// A key that is not named here gets its control from the description.
'use strict';

import { histogram, store } from './store.js';

/** Keys that few need, folded away under the others of their section. */
const ADVANCED = new Set([
  ...['every', 'method', 'antialias', 'time_budget_ms', 'precision', 'ranks', 'backend', 'device', 'heights'],
  ...['camera.eye', 'camera.target', 'camera.up', 'transfer.unit_length', 'transfer.scale', 'transfer.threshold'],
  ...['transfer.opacity_in', 'transfer.range.percentile', 'transfer.range.union', 'transfer.range.hysteresis'],
]);

/** Whether a key of a section is one of those. */
export const isAdvanced = (section, key) => ADVANCED.has(section ? `${section}.${key.name}` : key.name);

/** Ranges of sliders: [low, high, isLogarithmic]. The number beside a slider accepts the whole range. */
const SLIDERS = {
  exaggeration: [1, 300, true],
  tolerance: [1e-5, 1e-1, true],
  samples: [1, 64, true],
  'camera.lon': [-180, 180],
  'camera.fov': [5, 90],
  'camera.distance': [1.05, 12, true],
  'camera.altitude': [0.05, 11, true],
  'light.lon': [-180, 180],
  'light.shininess': [1, 200, true],
  'lines.width': [0.1, 6],
  'transfer.unit_length': [1e-3, 1, true],
  'opacity.unit_length': [1e-3, 1, true],
};

/** The slider of a key, or null: none where the range has no end or is too wide for a hand. */
export function sliderOf(section, key) {
  const named = SLIDERS[section ? `${section}.${key.name}` : key.name];
  if (named) return { low: named[0], high: named[1], isLog: named[2] === true };
  const { min, max } = key;
  if (min === null || max === null || min === undefined || max === undefined || !(max > min) || max - min > 1000)
    return null;
  return { low: min, high: max, isLog: min > 0 && max / min >= 64 };
}

const firstField = () => store.scene?.values.field ?? store.scene?.field ?? store.describe?.fields[0]?.name;

/** A new isosurface, in the middle of its field's values: those of the last picture may be another field's. */
async function isosurface() {
  const field = firstField();
  const { range } = await histogram(field).catch(() => ({}));
  const value = range ? Number(((range[0] + range[1]) / 2).toPrecision(4)) : 0;
  return { field, value, color: '#9fe0e8', opacity: 0.6 };
}

const ENTRIES = {
  volumes: () => ({ field: firstField() }),
  surfaces: () => ({ layer: 'bottom', field: firstField() }),
  isosurfaces: isosurface,
  lines: () => ({ pattern: 'graticule', opacity: 0.4 }),
  clip: () => ({ cut: 'inside', lon: [0, 90], lat: [0, 90] }),
  derive: () => ({ name: 'anomaly', anomaly: firstField(), from: 'zonal mean' }),
  opacity: () => ({
    values: [
      [0, 0],
      [1, 0.5],
    ],
  }),
  ground: () => ({ land: '#66754e', ocean: '#24466a' }),
  light: () => ({ kind: 'headlight' }),
};

/**
 * Changes that keep the volume when something else is added: a scene without `[transfer]` has a volume only as long as
 * it shows nothing else, and `[[volumes]]` stand in place of `[transfer]`.
 */
export function keepVolume(name) {
  const { values, transfer, field } = store.scene;
  if (values.volumes?.length > 0 || !transfer) return [];
  if (name === 'volumes') {
    const first = { field, transfer: values.transfer ?? {}, ...(values.opacity && { opacity: values.opacity }) };
    const gone = ['transfer', 'opacity'].filter((key) => values[key]).map((key) => ({ path: [key], value: null }));
    return [...gone, { path: ['volumes', 0], value: first }];
  }
  const hides = ['surfaces', 'isosurfaces', 'lines', 'ground'].includes(name);
  return hides && !values.transfer && !values.opacity ? [{ path: ['transfer'], value: {} }] : [];
}

/** Changes that add an entry to a list of tables. */
export async function additionOf(section) {
  const kept = keepVolume(section.name);
  const count =
    (store.scene.values[section.name] ?? []).length + (section.name === 'volumes' && kept.length > 0 ? 1 : 0);
  return [...kept, { path: [section.name, count], value: await newEntry(section) }];
}

/** A first value for a required key of a type. */
function guess(key) {
  if (key.choices?.length > 0) return key.choices[0];
  if (/^(number|integer)/.test(key.type)) return key.min ?? 0;
  if (key.type === 'boolean') return true;
  if (key.type.startsWith('colour')) return '#ffffff';
  return key.name === 'field' ? firstField() : key.name;
}

/** A new entry of a section: a useful one, or one with its required keys. That of isosurfaces is to be awaited. */
export function newEntry(section) {
  const known = ENTRIES[section.name]?.();
  if (known) return known;
  const required = section.keys.filter(
    (key) => /^required/.test(key.default ?? '') && !key.name.includes('.') && !/,| or /.test(key.default),
  );
  return Object.fromEntries(required.map((key) => [key.name, guess(key)]));
}
