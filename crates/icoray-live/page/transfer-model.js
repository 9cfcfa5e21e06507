// Transfer functions as data: which a scene has and where their points are. Without DOM.
//
// `opacity` is linear in extinction between points, extinction = -ln(1 - opacity); a scale maps values to places.
'use strict';

import { hexOf, mapColours, mixed } from './colour.js';
import { plain } from './format.js';

/** Largest opacity of a point; 1 would be an infinite extinction. */
export const OPAQUE = 0.999;

/** Places of values along a scale, as the renderer defines them. */
export function scaleOf(transfer) {
  const threshold = transfer?.threshold;
  if (transfer?.scale === 'log') {
    return { name: 'log', forward: (v) => Math.log10(v), backward: (p) => 10 ** p };
  }
  if (transfer?.scale === 'symlog' && threshold > 0) {
    return {
      name: 'symlog',
      forward: (v) =>
        Math.abs(v) <= threshold ? v / threshold : Math.sign(v) * (1 + Math.log10(Math.abs(v) / threshold)),
      backward: (p) => (Math.abs(p) <= 1 ? p * threshold : Math.sign(p) * 10 ** (Math.abs(p) - 1) * threshold),
    };
  }
  return { name: 'linear', forward: (v) => v, backward: (p) => p };
}

/** The transfer functions of a scene: { id, label, path, kind: 'volume'|'colours'|'opacity', field, fieldPath }. */
export function targetsOf(scene) {
  const { values } = scene;
  const first = values.field ?? scene.field;
  const found = [];
  if (values.volumes?.length > 0) {
    values.volumes.forEach((volume, i) =>
      found.push({
        label: `Volume ${i + 1}`,
        path: ['volumes', i, 'transfer'],
        kind: volume.opacity ? 'colours' : 'volume',
        field: volume.field ?? (i > 0 ? values.volumes[0].field : undefined) ?? first,
        fieldPath: ['volumes', i, 'field'],
        isFirst: i === 0,
      }),
    );
  } else if (scene.transfer || values.transfer) {
    found.push({
      label: 'Volume',
      path: ['transfer'],
      kind: values.opacity ? 'colours' : 'volume',
      field: first,
      fieldPath: ['field'],
      isFirst: true,
    });
  }
  if (values.opacity && !values.volumes?.length) {
    found.push({
      label: 'Opacity',
      path: ['opacity'],
      kind: 'opacity',
      field: values.opacity.field ?? first,
      fieldPath: ['opacity', 'field'],
    });
  }
  const colours = (key, word, field) =>
    (values[key] ?? []).forEach((entry, i) => {
      if (entry.color || entry.colors || !(key === 'surfaces' || entry.transfer || entry.color_by)) return;
      found.push({
        label: `${word} ${i + 1}`,
        path: [key, i, 'transfer'],
        kind: 'colours',
        field: entry[field] ?? entry.field ?? first,
        fieldPath: [key, i, field],
      });
    });
  colours('surfaces', 'Surface', 'field');
  colours('isosurfaces', 'Isosurface', 'color_by');
  return found.map((target) => ({ ...target, id: target.path.join('.') }));
}

/** The value below which a percentage of the histogram's values lies. */
export function percentile(histogram, percent) {
  const known = histogram.percentiles?.[String(percent)];
  if (known !== undefined) return known;
  const [low, high] = histogram.range;
  const total = histogram.counts.reduce((sum, count) => sum + count, 0);
  let rest = (percent / 100) * total;
  for (let i = 0; i < histogram.counts.length; i += 1) {
    const count = histogram.counts[i];
    if (rest <= count && count > 0) return low + ((high - low) * (i + rest / count)) / histogram.counts.length;
    rest -= count;
  }
  return high;
}

/** How a transfer function's range is found: `fixed`, `percentile` or `union`, and its percentages. */
export function rangeModeOf(transfer) {
  const range = transfer?.range;
  if (Array.isArray(range)) return { mode: 'fixed', percents: [1, 99] };
  if (range?.union) return { mode: 'union', percents: range.union };
  return { mode: 'percentile', percents: range?.percentile ?? [1, 99] };
}

function rangeOf(target, transfer, scene, histogram, scale) {
  if (Array.isArray(transfer.range)) return transfer.range;
  if (target.isFirst && scene.transfer?.is_map && scene.transfer.range) return scene.transfer.range;
  const { percents } = rangeModeOf(transfer);
  let ends = percents.map((percent) => percentile(histogram, percent)).map(scale.forward);
  if (transfer.center !== undefined) {
    const middle = scale.forward(transfer.center);
    const half = Math.max(...ends.map((end) => Math.abs(end - middle)));
    ends = [middle - half, middle + half];
  }
  return ends.map(scale.backward);
}

/** A transfer function ready to be drawn: { isMap, range, points, hasOpacity, hasColour, colours, scale, ... }. */
export function resolve(target, scene, histogram, maps, transfer) {
  const hasOpacity = target.kind !== 'colours';
  if (target.kind === 'opacity') {
    const points = (transfer.values ?? []).map(([value, opacity]) => ({ value, opacity }));
    const scale = scaleOf({});
    return {
      isMap: true,
      isRelative: false,
      range: histogram.range,
      points,
      hasOpacity,
      hasColour: false,
      colours: ['#c8d2dc', '#c8d2dc'],
      scale,
    };
  }
  if (transfer.knots) {
    const points = transfer.knots.map((knot) => ({
      value: knot.value,
      colour: hexOf(knot.color) ?? '#ffffff',
      opacity: knot.opacity ?? 1 - Math.exp(-(knot.extinction ?? 0)),
    }));
    return {
      isMap: false,
      range: [points[0].value, points.at(-1).value],
      points,
      hasOpacity,
      hasColour: true,
      scale: scaleOf({}),
    };
  }
  const scale = scaleOf(transfer);
  const range = rangeOf(target, transfer, scene, histogram, scale);
  const hasCentre = transfer.center !== undefined;
  const name = transfer.map ?? (hasCentre ? 'vik' : 'viridis');
  const isFixed = Array.isArray(transfer.range);
  const isRelative = transfer.opacity ? (transfer.opacity_in ?? (isFixed ? 'values' : 'range')) === 'range' : !isFixed;
  const given =
    transfer.opacity ??
    (hasCentre
      ? [
          [0, 0.9],
          [0.5, 0],
          [1, 0.9],
        ]
      : [
          [0, 0],
          [1, 0.9],
        ]);
  const isParts = transfer.opacity ? isRelative : true;
  const points = hasOpacity
    ? given.map(([at, opacity]) => ({ value: isParts ? valueOf(at, range, scale) : at, opacity }))
    : [];
  return {
    isMap: true,
    isRelative,
    isFixed,
    range,
    points,
    hasOpacity,
    hasColour: false,
    name,
    colours: mapColours(maps, name, transfer.reverse),
    scale,
  };
}

/** The value at a part of a range, and the part at a value. */
export const valueOf = (part, range, scale) =>
  scale.backward(scale.forward(range[0]) + (scale.forward(range[1]) - scale.forward(range[0])) * part);
export const partOf = (value, range, scale) =>
  (scale.forward(value) - scale.forward(range[0])) / (scale.forward(range[1]) - scale.forward(range[0]));

/** The opacity of points at a value: linear in extinction, constant beyond the ends. */
export function opacityAt(points, value) {
  if (points.length === 0) return 0;
  if (value <= points[0].value) return points[0].opacity;
  for (let i = 1; i < points.length; i += 1) {
    const [a, b] = [points[i - 1], points[i]];
    if (value > b.value) continue;
    const part = b.value > a.value ? (value - a.value) / (b.value - a.value) : 1;
    const extinction = (p) => -Math.log(1 - Math.min(p.opacity, OPAQUE));
    return 1 - Math.exp(-(extinction(a) + (extinction(b) - extinction(a)) * part));
  }
  return points.at(-1).opacity;
}

/** Text of a point for screen readers. */
export function describePoint(point, units) {
  const opacity = point.opacity === undefined ? '' : `, opacity ${point.opacity.toFixed(2)}`;
  return `value ${plain(point.value, 4)}${units ? ` ${units}` : ''}${opacity}`;
}

/** The colour of knots at a value. */
export function colourNear(points, value) {
  const after = points.findIndex((p) => p.value >= value);
  if (after <= 0) return points.at(after).colour;
  const [a, b] = [points[after - 1], points[after]];
  return mixed(a.colour, b.colour, (value - a.value) / (b.value - a.value || 1));
}

/** The part of the scale to show: the range with its points and marks, or all data. */
export function windowOf(resolved, histogram, marks, isWhole) {
  const { forward } = resolved.scale;
  let data = histogram.range;
  if (resolved.scale.name === 'log' && data[0] <= 0) data = [Math.min(resolved.range[0], data[1]) / 10, data[1]];
  const own = [...resolved.range, ...resolved.points.map((p) => p.value), ...marks]
    .map(forward)
    .filter(Number.isFinite);
  const seen = [Math.min(...own), Math.max(...own)];
  const all = data.map(forward);
  const room = (seen[1] - seen[0]) * 0.12;
  const ends = isWhole ? [Math.min(all[0], seen[0]), Math.max(all[1], seen[1])] : [seen[0] - room, seen[1] + room];
  return ends[1] > ends[0] ? ends : [ends[0] - 1, ends[1] + 1];
}
