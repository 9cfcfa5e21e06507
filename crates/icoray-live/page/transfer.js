// The transfer function of a volume or surface, by hand: what is chosen and what inputs do. transfer-panel.js shows it.
'use strict';

import { plain, rounded } from './format.js';
import { markersOf, moveMarker, newIsosurface } from './markers.js';
import { openTab } from './panel.js';
import { act, change, move, rest } from './sender.js';
import { histogram, on, say, store, valueAt } from './store.js';
import * as changes from './transfer-changes.js';
import * as model from './transfer-model.js';
import { makePanel } from './transfer-panel.js';

let targetId = '';
let target = null;
let resolved = null;
let transfer = {};
let selected = null;
let isWhole = false;
let drawn = null;
/** Resolves once the panel shows the scene, and once the last choice of a field is taken. */
let showing = Promise.resolve();
let choosing = Promise.resolve();

const send = (key, value) => change([{ path: [...target.path, key], value }]);

const panel = makePanel({
  curve: { move: moved, done: rest, add, remove, select },
  open,
  field: (name) => {
    choosing = changes.isShownAlone(target, name, store.scene, store.describe.fields)
      ? act(`/api/look?field=${encodeURIComponent(name)}`)
      : change(changes.fieldChanges(target, resolved, transfer, name, store.scene));
  },
  map: (name) => send('map', name),
  reverse: (isOn) => send('reverse', isOn || null),
  scale: (name) => change(changes.scaleChanges(target, resolved, transfer, name)),
  mode: (mode) => change(changes.rangeChanges(target, resolved, transfer, mode, model.rangeModeOf(transfer).percents)),
  fixed: (ends) => send('range', ends),
  percents: (mode, percents) => send('range', { ...transfer.range, [mode]: percents }),
  setPoint,
  removePoint: () => selected && remove(selected.kind, selected.index),
  toKnots: async () => {
    const isTaken = await change(changes.toKnots(target, store.scene, resolved, transfer));
    if (isTaken) say('The colour map is now a list of knots.');
  },
  toMap: () => change(changes.toMap(target, resolved, transfer)),
  addIsosurface: async () => {
    // Its value is suggested from the histogram of the field that was chosen, which may be on its way.
    await choosing;
    await showing;
    change(newIsosurface(target.field, drawn, resolved));
  },
  addPoint: () => add((resolved.range[0] + resolved.range[1]) / 2),
  showVolume: () => change([{ path: ['transfer'], value: { map: 'viridis' } }]),
  showSurface: () => change([{ path: ['surfaces', 0], value: { layer: 'bottom', field: store.scene.field } }]),
  whole: () => {
    isWhole = !isWhole;
    refresh();
  },
});

/** Shows the transfer function of a target by its id. */
export function open(id) {
  targetId = id;
  selected = null;
  isWhole = false;
  refresh();
}

function paint(keepWindow = false) {
  const marks = markersOf(target.field).map((mark) => mark.value);
  const window =
    keepWindow && paint.window
      ? paint.window
      : model.windowOf(resolved, drawn, marks, isWhole || target.kind === 'opacity');
  paint.window = window;
  panel.curve.show({
    ...resolved,
    histogram: drawn,
    window,
    selected,
    units: drawn.units,
    markers: markersOf(target.field),
  });
  const kind = selected?.kind;
  const item =
    kind === 'point'
      ? resolved.points[selected.index]
      : kind === 'marker'
        ? markersOf(target.field)[selected.index]
        : null;
  panel.pointRow.element.hidden = resolved.points.length === 0 && !item;
  panel.pointRow.show(
    item && {
      ...item,
      kind,
      hasColour: kind === 'point' && resolved.hasColour,
      index: selected.index,
      units: drawn.units,
    },
  );
  if (kind === 'end' || !keepWindow) panel.range.show(transfer, resolved.range);
}

async function show() {
  const { scene, describe } = store;
  if (!scene || !describe || panel.curve.isHeld || store.isMoving) return;
  const targets = model.targetsOf(scene);
  const wanted = targets.find((t) => t.id === targetId) ?? targets[0] ?? null;
  if (!wanted) {
    target = null;
    panel.showNone();
    return;
  }
  targetId = wanted.id;
  let counts;
  try {
    counts = await histogram(wanted.field);
  } catch (error) {
    if (!error.isGone) say(error.message, 'error');
    return;
  }
  if (panel.curve.isHeld || store.isMoving || wanted.id !== targetId || scene !== store.scene) return;
  // All at once: inputs would combine the new target with what was found for the one before.
  target = wanted;
  drawn = counts;
  transfer = valueAt(target.path) ?? {};
  resolved = model.resolve(target, scene, counts, describe.maps, transfer);
  if (selected?.kind === 'point' && selected.index >= resolved.points.length) selected = null;
  panel.show({ targets, target, transfer, resolved, isWhole });
  paint();
}

/** Shows the scene as it is now. */
function refresh() {
  showing = show();
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
    move(changes.pointChanges(target, resolved, points, transfer));
  }
  paint(true);
}

/** A value held within the range where points are parts of it. */
const limited = (value) =>
  resolved.isRelative ? Math.min(resolved.range[1], Math.max(resolved.range[0], value)) : value;

function add(value, opacity) {
  if (resolved.isMap && !resolved.hasOpacity) return;
  const at = limited(Number(plain(value, 5)));
  const colour = resolved.hasColour ? model.colourNear(resolved.points, at) : undefined;
  const point = { value: at, opacity: opacity ?? model.opacityAt(resolved.points, at), colour };
  const points = [...resolved.points, point].sort((a, b) => a.value - b.value);
  selected = { kind: 'point', index: points.indexOf(point) };
  resolved.points = points;
  change(changes.pointChanges(target, resolved, points, transfer));
  paint(true);
  panel.curve.focus('point', selected.index);
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
  change(changes.pointChanges(target, resolved, resolved.points, transfer));
  paint(true);
  panel.curve.focus('point', next);
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
    move(changes.pointChanges(target, resolved, resolved.points, transfer));
    paint(true);
  } else {
    moved('point', selected.index, part === 'value' ? value : undefined, part === 'opacity' ? value : undefined);
  }
}

/** Builds the panel. */
export function start() {
  on('scene', refresh);
  on('open-transfer', (id) => {
    open(id);
    openTab('colours');
  });
  on('describe', refresh);
  on('moving', (isMoving) => {
    if (!isMoving) refresh();
  });
}
