// The editor's picture: histogram, opacity curve, colour bar, and handles that a hand or keys move.
'use strict';

import { colourAt } from './colour.js';
import { h, newId, s, set } from './dom.js';
import { shown } from './format.js';
import { tickDigits, ticks } from './plot.js';
import { describePoint, OPAQUE, opacityAt } from './transfer-model.js';

const HEIGHT = 196;
const [TOP, BASE, BAR, LEFT] = [12, 138, 16, 12];

/**
 * Builds the editor. `act` has `move(kind, index, value, opacity)`, `done()`, `add(value, opacity)`,
 * `remove(kind, index)` and `select(kind, index)`. Kinds are `point`, `end` (of the range) and `marker` (of an
 * isosurface).
 */
export function makeCurve(act) {
  const fillId = newId('gradient');
  const stops = s('linearGradient', { id: fillId, gradientUnits: 'userSpaceOnUse' });
  const bars = s('path', { class: 'bars' });
  const area = s('path', { class: 'area', fill: `url(#${fillId})` });
  const line = s('path', { class: 'opacity' });
  const bar = s('rect', { class: 'colour-bar', y: BASE + 8, height: BAR, fill: `url(#${fillId})` });
  const axis = s('g', { class: 'axis' });
  const handles = s('g', {});
  const root = s(
    'svg',
    { class: 'curve', height: HEIGHT, role: 'group', 'aria-label': 'Transfer function over the histogram' },
    s('defs', {}, stops),
    bars,
    area,
    line,
    bar,
    axis,
    handles,
  );
  const element = h('div', { class: 'curve-box' }, root);
  const known = new Map();
  let state = null;
  let width = 320;
  let held = null;

  const px = (value) =>
    LEFT + ((state.scale.forward(value) - state.window[0]) / (state.window[1] - state.window[0])) * (width - 2 * LEFT);
  const valueAt = (x) =>
    state.scale.backward(state.window[0] + ((x - LEFT) / (width - 2 * LEFT)) * (state.window[1] - state.window[0]));
  const py = (opacity) => BASE - opacity * (BASE - TOP);
  const opacityOf = (y) => Math.min(OPAQUE, Math.max(0, (BASE - y) / (BASE - TOP)));
  const clampX = (x) => Math.min(width - LEFT, Math.max(LEFT, x));

  function drawBars() {
    const { counts, range } = state.histogram;
    const most = Math.log1p(Math.max(...counts, 1));
    let path = '';
    counts.forEach((count, i) => {
      if (count <= 0) return;
      const ends = [i, i + 1].map((j) => px(range[0] + ((range[1] - range[0]) * j) / counts.length));
      if (!ends.every(Number.isFinite) || ends[1] < LEFT || ends[0] > width - LEFT) return;
      const top = BASE - (Math.log1p(count) / most) * (BASE - TOP) * 0.92;
      path += `M${clampX(ends[0]).toFixed(1)} ${BASE}V${top.toFixed(1)}H${clampX(ends[1]).toFixed(1)}V${BASE}Z`;
    });
    set(bars, { d: path });
  }

  function drawCurve() {
    set(stops, { x1: LEFT, x2: width - LEFT, y1: 0, y2: 0 });
    const list = [];
    const stop = (x, colour) =>
      list.push(s('stop', { offset: Math.min(1, Math.max(0, (x - LEFT) / (width - 2 * LEFT))), 'stop-color': colour }));
    if (state.isMap) {
      const [a, b] = state.range.map(px);
      const last = state.colours.length - 1;
      // Places outside the window are cut at its ends.
      for (let i = 0; i <= 48; i += 1) {
        const x = LEFT + ((width - 2 * LEFT) * i) / 48;
        stop(x, colourAt(state.colours, (x - a) / (b - a || 1)));
      }
      if (last === 0) stop(LEFT, state.colours[0]);
    } else {
      for (const point of state.points) stop(px(point.value), point.colour);
    }
    stops.replaceChildren(...list);
    set(bar, { x: LEFT, width: Math.max(0, width - 2 * LEFT) });
    let path = '';
    if (state.hasOpacity && state.points.length > 0) {
      for (let x = LEFT; x <= width - LEFT; x += 2)
        path += `${path ? 'L' : 'M'}${x} ${py(opacityAt(state.points, valueAt(x))).toFixed(1)}`;
    }
    set(line, { d: path });
    set(area, { d: path && `${path}L${width - LEFT} ${BASE}L${LEFT} ${BASE}Z` });
  }

  function drawAxis() {
    const [low, high] = [valueAt(LEFT), valueAt(width - LEFT)];
    const places =
      state.scale.name === 'linear'
        ? ticks(low, high, Math.max(2, Math.floor(width / 80)))
        : ticks(state.window[0], state.window[1], 5).map(state.scale.backward);
    const digits = state.scale.name === 'linear' ? tickDigits(places) : 4;
    const list = places
      .map((value) => [px(value), value])
      .filter(([x]) => x >= LEFT && x <= width - LEFT)
      .flatMap(([x, value]) => [
        s('line', { x1: x, x2: x, y1: BASE + 8 + BAR, y2: BASE + 12 + BAR }),
        s(
          'text',
          { x: Math.min(width - LEFT - 8, Math.max(LEFT + 8, x)), y: BASE + 24 + BAR, 'text-anchor': 'middle' },
          shown(value, digits),
        ),
      ]);
    axis.replaceChildren(s('line', { x1: LEFT, x2: width - LEFT, y1: BASE, y2: BASE }), ...list);
  }

  function handle(kind, index) {
    const key = `${kind}/${index}`;
    if (!known.has(key)) {
      const shape =
        kind === 'point'
          ? [s('circle', { class: 'reach', r: 14 }), s('circle', { class: 'dot', r: 5.5 })]
          : kind === 'end'
            ? [
                s('rect', { class: 'reach', x: -13, y: BASE + 2, width: 26, height: 28 }),
                s('path', { class: 'end', d: `M0 ${BASE + 6}V${BASE + 26}` }),
              ]
            : [
                s('rect', { class: 'reach', x: -9, y: 0, width: 18, height: BASE }),
                s('path', { class: 'marker', d: `M0 ${BASE}V8M-5 1H5L0 9Z` }),
              ];
      const group = s(
        'g',
        { class: `handle is-${kind}`, tabindex: 0, role: 'slider', 'data-kind': kind, 'data-index': index },
        ...shape,
      );
      group.addEventListener('focus', () => act.select(kind, index));
      known.set(key, group);
    }
    return known.get(key);
  }

  function drawHandles() {
    const list = [];
    const add = (kind, index, x, y, item, label) => {
      const outside = x < LEFT - 1 || x > width - LEFT + 1 || !Number.isFinite(x);
      const group = set(handle(kind, index), {
        transform: `translate(${clampX(Number.isFinite(x) ? x : LEFT).toFixed(1)} ${y.toFixed(1)})`,
        'aria-label': label,
        'aria-valuemin': state.histogram.range[0],
        'aria-valuemax': state.histogram.range[1],
        'aria-valuenow': item.value,
        'aria-valuetext': describePoint(item, state.units),
        'data-outside': outside,
        'data-selected': state.selected?.kind === kind && state.selected.index === index,
      });
      const dot = group.querySelector('.dot, .marker');
      if (item.colour && dot) dot.style.fill = item.colour;
      list.push(group);
    };
    state.markers.forEach((marker, i) => add('marker', i, px(marker.value), 0, marker, `Isosurface ${i + 1}`));
    if (state.isMap && state.isFixed)
      state.range.forEach((value, i) =>
        add('end', i, px(value), 0, { value }, i ? 'Upper end of the range' : 'Lower end of the range'),
      );
    state.points.forEach((point, i) =>
      add(
        'point',
        i,
        px(point.value),
        state.hasOpacity ? py(point.opacity) : BASE + 8 + BAR / 2,
        state.hasOpacity ? point : { value: point.value, colour: point.colour },
        `Point ${i + 1}`,
      ),
    );
    const wanted = new Set(list);
    for (const child of [...handles.children]) if (!wanted.has(child)) child.remove();
    list.forEach((group, i) => {
      if (handles.children[i] !== group) handles.insertBefore(group, handles.children[i] ?? null);
    });
  }

  function render() {
    if (!state || width < 40) return;
    set(root, { width, viewBox: `0 0 ${width} ${HEIGHT}` });
    drawBars();
    drawCurve();
    drawAxis();
    drawHandles();
  }

  const local = (event) => {
    const rect = root.getBoundingClientRect();
    return { x: event.clientX - rect.left, y: event.clientY - rect.top };
  };

  root.addEventListener('pointerdown', (event) => {
    const group = event.target.closest('.handle');
    if (!group || event.button > 0) return;
    event.preventDefault();
    group.focus({ preventScroll: true });
    root.setPointerCapture(event.pointerId);
    held = { kind: group.dataset.kind, index: Number(group.dataset.index), start: local(event), isMoved: false };
  });
  root.addEventListener('pointermove', (event) => {
    if (!held) return;
    const { x, y } = local(event);
    if (!held.isMoved && Math.hypot(x - held.start.x, y - held.start.y) < 3) return;
    held.isMoved = true;
    act.move(
      held.kind,
      held.index,
      valueAt(clampX(x)),
      held.kind === 'point' && state.hasOpacity ? opacityOf(y) : undefined,
    );
  });
  const release = () => {
    if (held?.isMoved) act.done();
    held = null;
  };
  root.addEventListener('pointerup', release);
  root.addEventListener('pointercancel', release);
  root.addEventListener('dblclick', (event) => {
    if (event.target.closest('.handle')) return;
    const { x, y } = local(event);
    act.add(valueAt(clampX(x)), state.hasOpacity ? opacityOf(y) : undefined);
  });
  root.addEventListener('keydown', (event) => {
    const group = event.target.closest('.handle');
    if (!group || event.ctrlKey || event.metaKey || event.altKey) return;
    const [kind, index] = [group.dataset.kind, Number(group.dataset.index)];
    const item = kind === 'end' ? { value: state.range[index] } : state[`${kind}s`][index];
    const along = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0;
    const upward = { ArrowUp: 1, ArrowDown: -1 }[event.key] ?? 0;
    const many = event.shiftKey ? 10 : 1;
    if (along || (upward && kind !== 'point')) {
      const x = px(item.value) + (along + (kind === 'point' ? 0 : upward)) * many * ((width - 2 * LEFT) / 200);
      act.move(kind, index, valueAt(clampX(x)), undefined);
    } else if (upward && state.hasOpacity) {
      act.move(kind, index, undefined, Math.min(OPAQUE, Math.max(0, item.opacity + upward * many * 0.01)));
    } else if (event.key === 'Delete' || event.key === 'Backspace') {
      act.remove(kind, index);
    } else if (event.key === 'Insert' || event.key === 'Enter') {
      const next = state.points[index + 1] ?? { value: valueAt(width - LEFT) };
      const value = state.scale.backward((state.scale.forward(item.value) + state.scale.forward(next.value)) / 2);
      act.add(value, state.hasOpacity ? opacityAt(state.points, value) : undefined);
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  });
  new ResizeObserver(() => {
    width = Math.max(40, element.clientWidth);
    render();
  }).observe(element);

  return {
    element,
    /** Shows a transfer function: what `resolve` gives, with `histogram`, `window`, `markers`, `selected`, `units`. */
    show(next) {
      state = next;
      render();
    },
    /** Puts the focus on a handle. */
    focus(kind, index) {
      known.get(`${kind}/${index}`)?.focus();
    },
    get isHeld() {
      return held !== null;
    },
  };
}
