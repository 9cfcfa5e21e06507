// The colour panel: the transfer function of a volume or surface, by hand.
'use strict';

import { gradient, mixed } from './colour.js';
import { makeCurve } from './curve.js';
import { byId, h } from './dom.js';
import { makeKeys } from './form.js';
import { plain, rounded } from './format.js';
import { makeSwatches } from './maps.js';
import { change, move, rest } from './sender.js';
import { histogram, on, say, store, valueAt } from './store.js';
import { openTab } from './panel.js';
import { markersOf, moveMarker, newIsosurface } from './markers.js';
import * as model from './transfer-model.js';
import { makePointRow, makeRangeRow, segmented } from './transfer-rows.js';

/** Keys of `[transfer]` that have a control of their own here. */
const OWN = /^(knots|map|reverse|scale|range(\..*)?|opacity|field|values)$/;

let targetId = '';
let target = null;
let resolved = null;
let transfer = {};
let selected = null;
let isWhole = false;
let drawn = null;
let extras = null;

const pickTarget = h('select', { 'aria-label': 'Transfer function of', onchange: (e) => open(e.target.value) });
const pickField = h('select', { 'aria-label': 'Field', onchange: (e) => change([{ path: target.fieldPath, value: e.target.value }]) });
const curve = makeCurve({ move: moved, done: rest, add, remove, select });
const swatches = makeSwatches((name) => change([{ path: [...target.path, 'map'], value: name }]));
const strip = h('span', { class: 'strip' });
const mapName = h('span', { class: 'map-name' });
const mapBox = h('details', { class: 'map-box' }, h('summary', {}, h('span', { class: 'label' }, 'Colour map'), strip, mapName), swatches.element);
const reverse = h('input', { type: 'checkbox', onchange: (e) => change([{ path: [...target.path, 'reverse'], value: e.target.checked || null }]) });
const scale = segmented('Scale', ['linear', 'log', 'symlog'], setScale);
const range = makeRangeRow({
  mode: (mode) => change(model.rangeChanges(target, resolved, transfer, mode, model.rangeModeOf(transfer).percents)),
  fixed: (ends) => change([{ path: [...target.path, 'range'], value: ends }]),
  percents: (mode, percents) => change([{ path: [...target.path, 'range'], value: { ...transfer.range, [mode]: percents } }]),
});
const pointRow = makePointRow({ set: setPoint, remove: () => selected && remove(selected.kind, selected.index) });
const toKnots = h('button', { type: 'button', onclick: convert }, 'Edit knots');
const toMap = h('button', { type: 'button', onclick: () => change([{ path: target.path, value: backToMap() }]) }, 'Use a colour map');
const addIso = h('button', { type: 'button', onclick: () => change(newIsosurface(target.field, drawn, resolved)) }, 'Add isosurface');
const addPoint = h('button', { type: 'button', onclick: () => add((resolved.range[0] + resolved.range[1]) / 2) }, 'Add point');
const whole = h('button', { type: 'button', 'aria-pressed': 'false', onclick: () => { isWhole = !isWhole; show(); } }, 'Whole data');
const mapRows = h('div', { class: 'stack' }, mapBox, h('label', { class: 'check' }, reverse, 'Reverse the map'), scale.element, range.element);
const extraBox = h('div', {});
const editor = h('div', { class: 'stack' }, curve.element, pointRow.element,
  h('div', { class: 'buttons' }, addPoint, toKnots, toMap, addIso, whole), mapRows, extraBox);
const none = h('div', { class: 'stack' }, h('p', { class: 'hint' }, 'The scene shows no volume and no surface coloured by a field.'),
  h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: () => change([{ path: ['transfer'], value: { map: 'viridis' } }]) }, 'Show a volume')));

function backToMap() {
  const unit = transfer.unit_length;
  return { map: 'viridis', ...(unit !== undefined && { unit_length: unit }), range: resolved.range.map((v) => Number(v.toPrecision(5))) };
}

async function convert() {
  if (await change(model.toKnots(target, store.scene, resolved, transfer))) say('The colour map is now a list of knots.');
}

function setScale(name) {
  const at = (key, value) => ({ path: [...target.path, key], value });
  const changes = [at('scale', name === 'linear' ? null : name)];
  if (name === 'symlog') {
    const largest = Math.max(...resolved.range.map(Math.abs)) || 1;
    changes.push(at('threshold', transfer.threshold ?? Number((largest / 100).toPrecision(1))));
  } else if (transfer.threshold !== undefined) {
    changes.push(at('threshold', null));
  }
  change(changes);
}

/** Shows the transfer function of a target by its id. */
export function open(id) {
  targetId = id;
  selected = null;
  isWhole = false;
  show();
}

/** The part of the scale that is shown. */
function windowOf() {
  const forward = resolved.scale.forward;
  let data = drawn.range;
  if (resolved.scale.name === 'log' && data[0] <= 0) data = [Math.min(resolved.range[0], data[1]) / 10, data[1]];
  const own = [...resolved.range, ...resolved.points.map((p) => p.value), ...markersOf(target.field).map((m) => m.value)];
  const seen = [Math.min(...own), Math.max(...own)].map(forward);
  const all = data.map(forward);
  const room = (seen[1] - seen[0]) * 0.12;
  const ends = isWhole || target.kind === 'opacity' ? [Math.min(all[0], seen[0]), Math.max(all[1], seen[1])] : [seen[0] - room, seen[1] + room];
  return ends[1] > ends[0] ? ends : [ends[0] - 1, ends[1] + 1];
}

function paint(keepWindow = false) {
  const window = keepWindow && paint.window ? paint.window : windowOf();
  paint.window = window;
  curve.show({ ...resolved, histogram: drawn, window, selected, units: drawn.units, markers: markersOf(target.field) });
  const kind = selected?.kind;
  const item = kind === 'point' ? resolved.points[selected.index] : kind === 'marker' ? markersOf(target.field)[selected.index] : null;
  pointRow.show(item && { ...item, kind, hasColour: kind === 'point' && resolved.hasColour, index: selected.index, units: drawn.units });
  if (kind === 'end' || !keepWindow) range.show(transfer, resolved.range);
}

async function show() {
  const { scene, describe } = store;
  if (!scene || !describe || curve.isHeld || store.isMoving) return;
  const targets = model.targetsOf(scene);
  target = targets.find((t) => t.id === targetId) ?? targets[0] ?? null;
  const box = byId('colours');
  if (!target) {
    box.replaceChildren(none);
    return;
  }
  targetId = target.id;
  pickTarget.replaceChildren(...targets.map((t) => h('option', { value: t.id, selected: t.id === targetId }, t.label)));
  const names = [...new Set([...describe.fields.map((f) => f.name), ...(scene.values.derive ?? []).map((d) => d.name), target.field])];
  pickField.replaceChildren(...names.map((name) => h('option', { value: name, selected: name === target.field }, name)));
  let counts;
  const wanted = target.id;
  try {
    counts = await histogram(target.field);
  } catch (error) {
    if (!error.isGone) say(error.message, 'error');
    return;
  }
  if (curve.isHeld || store.isMoving || wanted !== targetId || scene !== store.scene) return;
  drawn = counts;
  transfer = valueAt(target.path) ?? {};
  resolved = model.resolve(target, scene, counts, describe.maps, transfer);
  if (selected?.kind === 'point' && selected.index >= resolved.points.length) selected = null;
  const isColourMap = resolved.isMap && target.kind !== 'opacity';
  mapRows.hidden = !isColourMap;
  toKnots.hidden = !isColourMap;
  toMap.hidden = resolved.isMap;
  addPoint.hidden = !resolved.hasOpacity && resolved.isMap;
  whole.setAttribute('aria-pressed', String(isWhole));
  if (isColourMap) {
    swatches.show(describe.maps, resolved.name);
    strip.style.backgroundImage = gradient(resolved.colours);
    mapName.textContent = resolved.name;
    reverse.checked = transfer.reverse === true;
    scale.show(transfer.scale ?? 'linear');
  }
  paint();
  if (editor.parentNode !== box) box.replaceChildren(h('div', { class: 'pair' }, pickTarget, pickField), editor);
  pickTarget.hidden = targets.length < 2;
  showExtras(target.kind === 'opacity' ? 'opacity' : 'transfer');
}

/** The other keys of the section, generated. */
function showExtras(name) {
  const section = store.describe.sections.find((found) => found.name === name);
  const key = `${name}/${target.id}`;
  if (!section) return;
  if (extras?.key !== key) {
    extras = { key, keys: makeKeys(section.keys.filter((k) => !OWN.test(k.name)), target.path) };
    extraBox.replaceChildren(extras.keys.element);
  }
  extras.keys.update(transfer);
}

function select(kind, index) {
  selected = { kind, index };
  if (resolved) paint(true);
}

function moved(kind, index, value, opacity) {
  const step = (resolved.scale.backward(paint.window[1]) - resolved.scale.backward(paint.window[0])) / 2000;
  const neat = value === undefined ? undefined : rounded(value, Math.abs(step));
  if (kind === 'marker') {
    move(moveMarker(target.field, index, neat));
  } else if (kind === 'end') {
    const ends = [...resolved.range];
    ends[index] = neat;
    if (!(ends[0] < ends[1])) return;
    resolved.range = ends;
    move([{ path: [...target.path, 'range'], value: ends }]);
  } else {
    const points = resolved.points.map((p) => ({ ...p }));
    const [low, high] = [points[index - 1]?.value ?? -Infinity, points[index + 1]?.value ?? Infinity];
    if (neat !== undefined) points[index].value = Math.min(high, Math.max(low, limited(neat)));
    if (opacity !== undefined) points[index].opacity = opacity;
    resolved.points = points;
    move(model.pointChanges(target, resolved, points, transfer));
  }
  paint(true);
}

/** A value held within the range where points are parts of it. */
const limited = (value) => (resolved.isRelative ? Math.min(resolved.range[1], Math.max(resolved.range[0], value)) : value);

function add(value, opacity) {
  if (resolved.isMap && !resolved.hasOpacity) return;
  const at = limited(Number(plain(value, 5)));
  const point = { value: at, opacity: opacity ?? model.opacityAt(resolved.points, at), colour: colourNear(at) };
  const points = [...resolved.points, point].sort((a, b) => a.value - b.value);
  selected = { kind: 'point', index: points.indexOf(point) };
  resolved.points = points;
  change(model.pointChanges(target, resolved, points, transfer));
  paint(true);
  curve.focus('point', selected.index);
}

function colourNear(value) {
  if (!resolved.hasColour) return undefined;
  const after = resolved.points.findIndex((p) => p.value >= value);
  if (after <= 0) return resolved.points.at(after).colour;
  const [a, b] = [resolved.points[after - 1], resolved.points[after]];
  return mixed(a.colour, b.colour, (value - a.value) / (b.value - a.value || 1));
}

function remove(kind, index) {
  if (kind === 'end') return;
  if (kind === 'marker') {
    change(moveMarker(target.field, index, null));
    selected = null;
    return;
  }
  if (resolved.points.length <= (resolved.isMap ? 1 : 2)) {
    say('The last points cannot be deleted.', 'info');
    return;
  }
  resolved.points = resolved.points.filter((_, i) => i !== index);
  const next = Math.min(index, resolved.points.length - 1);
  selected = { kind: 'point', index: next };
  change(model.pointChanges(target, resolved, resolved.points, transfer));
  paint(true);
  curve.focus('point', next);
}

/** Sets a part of the selected point, from the number and colour inputs. */
function setPoint(part, value, isMoving) {
  if (selected.kind === 'marker') {
    (isMoving ? move : change)(moveMarker(target.field, selected.index, value));
    return;
  }
  const point = resolved.points[selected.index];
  if (part === 'colour') {
    resolved.points = resolved.points.map((p) => (p === point ? { ...p, colour: value } : p));
    move(model.pointChanges(target, resolved, resolved.points, transfer));
    paint(true);
  } else {
    moved('point', selected.index, part === 'value' ? value : undefined, part === 'opacity' ? value : undefined);
  }
}

/** Builds the panel. */
export function start() {
  on('scene', show);
  on('open-transfer', (id) => { open(id); openTab('colours'); });
  on('describe', show);
  on('moving', (isMoving) => { if (!isMoving) show(); });
}
