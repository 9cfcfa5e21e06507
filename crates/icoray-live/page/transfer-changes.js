// The changes of a scene that a hand makes to a transfer function. Without DOM.
'use strict';

import { hexOf, rgbOf } from './colour.js';
import { opacityAt, partOf, targetsOf, valueOf } from './transfer-model.js';

const neat = (value, digits = 6) => Number(value.toPrecision(digits));

/** Changes that set the points, in the coordinates that the scene uses. */
export function pointChanges(target, resolved, points, transfer) {
  if (target.kind === 'opacity') {
    return [{ path: [...target.path, 'values'], value: points.map((p) => [neat(p.value), neat(p.opacity, 3)]) }];
  }
  if (resolved.isMap) {
    const at = (p) => (resolved.isRelative ? neat(partOf(p.value, resolved.range, resolved.scale), 4) : neat(p.value));
    return [{ path: [...target.path, 'opacity'], value: points.map((p) => [at(p), neat(p.opacity, 3)]) }];
  }
  const knots = points.map((p) => ({
    value: neat(p.value),
    color: p.colour,
    ...(resolved.hasOpacity && { opacity: neat(p.opacity, 3) }),
  }));
  return [{ path: [...target.path, 'knots'], value: knots }];
}

/** Changes that switch the range's mode; opacities keep their values. */
export function rangeChanges(target, resolved, transfer, mode, percents = [1, 99]) {
  const range = mode === 'fixed' ? resolved.range.map((v) => neat(v, 5)) : { [mode]: percents };
  const changes = [{ path: [...target.path, 'range'], value: range }];
  const wasFixed = Array.isArray(transfer.range);
  if (transfer.opacity && !transfer.opacity_in && wasFixed !== (mode === 'fixed')) {
    const next = { ...resolved, range: mode === 'fixed' ? range : resolved.range, isRelative: mode !== 'fixed' };
    changes.push(...pointChanges(target, next, resolved.points, transfer));
  }
  return changes;
}

/** The change that turns a colour map into knots; few knots that differ from it by less than can be seen. */
export function toKnots(target, scene, resolved, transfer) {
  const source =
    target.isFirst && scene.transfer
      ? scene.transfer.knots.map((k) => ({ value: k.value, colour: k.color, opacity: k.opacity }))
      : sampled(resolved);
  const points = simplified(source, 12);
  const value = { knots: pointChanges(target, { ...resolved, isMap: false }, points, transfer)[0].value };
  if (transfer.unit_length !== undefined && resolved.hasOpacity) value.unit_length = transfer.unit_length;
  return [{ path: target.path, value }];
}

function sampled(resolved) {
  return resolved.colours.map((colour, i) => {
    const value = valueOf(i / (resolved.colours.length - 1), resolved.range, resolved.scale);
    return { value, colour, opacity: opacityAt(resolved.points, value) };
  });
}

/** At most `most` of the knots, chosen one by one where the rest is farthest from them. */
function simplified(knots, most) {
  if (knots.length <= 2) return knots;
  const vector = (k) => [...rgbOf(hexOf(k.colour) ?? '#ffffff').map((x) => x / 255), k.opacity * 1.5];
  const vectors = knots.map(vector);
  const kept = [0, knots.length - 1];
  while (kept.length < Math.min(most, knots.length)) {
    let [worst, at] = [0.02, -1];
    for (let i = 0; i + 1 < kept.length; i += 1) {
      const [a, b] = [kept[i], kept[i + 1]];
      for (let j = a + 1; j < b; j += 1) {
        const part = (knots[j].value - knots[a].value) / (knots[b].value - knots[a].value || 1);
        const off = Math.hypot(...vectors[j].map((x, c) => x - vectors[a][c] - (vectors[b][c] - vectors[a][c]) * part));
        if (off > worst) [worst, at] = [off, j];
      }
    }
    if (at < 0) break;
    kept.push(at);
    kept.sort((a, b) => a - b);
  }
  return kept.map((i) => knots[i]);
}

/** Changes that set the scale; `symlog` gets a threshold. */
export function scaleChanges(target, resolved, transfer, name) {
  const at = (key, value) => ({ path: [...target.path, key], value });
  const changes = [at('scale', name === 'linear' ? null : name)];
  if (name === 'symlog') {
    const largest = Math.max(...resolved.range.map(Math.abs)) || 1;
    changes.push(at('threshold', transfer.threshold ?? neat(largest / 100, 1)));
  } else if (transfer.threshold !== undefined) {
    changes.push(at('threshold', null));
  }
  return changes;
}

/** The change that turns knots into a colour map over their range. */
export function toMap(target, resolved, transfer) {
  const unit = transfer.unit_length === undefined ? {} : { unit_length: transfer.unit_length };
  return [{ path: target.path, value: { map: 'viridis', ...unit, range: resolved.range.map((v) => neat(v, 5)) } }];
}

/** Whether nothing but one volume or 2D field is shown: another field of the data has a look of its own in its place. */
export function isShownAlone(target, field, scene, fields) {
  const { derive = [], isosurfaces = [] } = scene.values;
  const isDerived = derive.some((derived) => derived.name === field);
  const is2d = fields.some((known) => known.name === target.field && known.layers === 0);
  const isWhole = target.path[0] === 'transfer' || target.path[0] === 'volumes' || is2d;
  return !isDerived && isWhole && isosurfaces.length === 0 && targetsOf(scene).length === 1;
}

/** Changes that show another field: what is given in values of the old one is dropped or becomes parts of the range. */
export function fieldChanges(target, resolved, transfer, field, scene) {
  const changes = [{ path: target.fieldPath, value: field }];
  // If only a surface is shown, its field is the scene's, by which pictures are named.
  if (target.path[0] === 'surfaces' && targetsOf(scene)[0].id === target.id) {
    changes.push({ path: ['field'], value: field });
  }
  const at = (key, value) => ({ path: [...target.path, key], value });
  if (target.kind === 'opacity') return changes;
  if (transfer.knots) return [...changes, { path: target.path, value: { map: 'viridis' } }];
  for (const key of ['center', 'threshold', 'scale']) if (transfer[key] !== undefined) changes.push(at(key, null));
  if (Array.isArray(transfer.range)) changes.push(at('range', null));
  if (transfer.opacity && !resolved.isRelative) {
    const inRange = (v) => Math.min(1, Math.max(0, v));
    const parts = resolved.points.map((p) => [
      neat(inRange(partOf(p.value, resolved.range, resolved.scale)), 4),
      p.opacity,
    ]);
    changes.push(at('opacity', parts));
    if (transfer.opacity_in) changes.push(at('opacity_in', null));
  }
  return changes;
}
