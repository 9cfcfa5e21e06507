// The colour panel's elements.
'use strict';

import { gradient } from './colour.js';
import { makeCurve } from './curve.js';
import { byId, h } from './dom.js';
import { makeKeys } from './form.js';
import { makeSwatches } from './maps.js';
import { store } from './store.js';
import { makePointRow, makeRangeRow, segmented } from './transfer-rows.js';

/** Keys of `[transfer]` that have a control of their own here. */
const OWN = /^(knots|map|reverse|scale|range(\..*)?|opacity|field|values)$/;

const button = (text, onclick, attributes = {}) => h('button', { type: 'button', onclick, ...attributes }, text);

/** Whether the renderer takes a key beside the others of the transfer function. */
function isUsable(name, target, transfer) {
  if (name === 'threshold') return transfer.scale === 'symlog';
  if (name === 'opacity_in') return transfer.opacity !== undefined;
  if (name === 'unit_length') return target.kind !== 'colours';
  return name !== 'center' || !transfer.knots;
}

/** The other keys of the section, generated from the description. */
function makeExtras() {
  const element = h('div', {});
  let shown = null;
  return {
    element,
    show(target, transfer) {
      const name = target.kind === 'opacity' ? 'opacity' : 'transfer';
      const all = store.describe.sections.find((section) => section.name === name)?.keys ?? [];
      const keys = all.filter((key) => !OWN.test(key.name) && isUsable(key.name, target, transfer));
      const id = [target.id, ...keys.map((key) => key.name)].join();
      if (shown?.id !== id) {
        shown = { id, rows: makeKeys(keys, target.path, name) };
        element.replaceChildren(shown.rows.element);
      }
      shown.rows.update(transfer);
    },
  };
}

/** Fills a select with options, one of them chosen. */
function fill(select, options, chosen) {
  select.replaceChildren(...options.map(([value, text]) => h('option', { value, selected: value === chosen }, text)));
}

/** Builds the panel; `act` has a function for each thing that a hand can do there. */
export function makePanel(act) {
  const pickTarget = h('select', { 'aria-label': 'Transfer function of', onchange: (e) => act.open(e.target.value) });
  const pickField = h('select', { 'aria-label': 'Field', onchange: (e) => act.field(e.target.value) });
  const curve = makeCurve(act.curve);
  const pointRow = makePointRow({ set: act.setPoint, remove: act.removePoint });
  const buttons = {
    point: button('Add point', act.addPoint),
    knots: button('Edit knots', act.toKnots),
    map: button('Use a colour map', act.toMap),
    isosurface: button('Add isosurface', act.addIsosurface),
    whole: button('Whole data', act.whole, { 'aria-pressed': 'false' }),
  };
  const swatches = makeSwatches(act.map);
  const strip = h('span', { class: 'strip' });
  const mapName = h('span', { class: 'map-name' });
  const summary = h('summary', {}, h('span', { class: 'label' }, 'Colour map'), strip, mapName);
  const reverse = h('input', { type: 'checkbox', onchange: () => act.reverse(reverse.checked) });
  const scale = segmented('Scale', ['linear', 'log', 'symlog'], act.scale);
  const range = makeRangeRow(act);
  const mapRows = h(
    'div',
    { class: 'stack' },
    h('details', { class: 'map-box' }, summary, swatches.element),
    h('label', { class: 'check is-indented' }, reverse, 'Reverse the map'),
    scale.element,
    range.element,
  );
  const extras = makeExtras();
  const head = h('div', { class: 'pair' }, pickTarget, pickField);
  const row = h('div', { class: 'buttons' }, ...Object.values(buttons));
  const parts = [head, curve.element, pointRow.element, row, mapRows, extras.element];
  const none = [
    h('p', { class: 'hint' }, 'The scene shows no volume and no surface coloured by a field.'),
    h('div', { class: 'buttons' }, button('Show a volume', act.showVolume), button('Show a surface', act.showSurface)),
  ];

  function put(wanted) {
    const box = byId('colours');
    if (box.firstChild !== wanted[0]) box.replaceChildren(...wanted);
  }

  return {
    curve,
    pointRow,
    range,
    showNone: () => put(none),
    /** Shows the transfer function of a target; the curve is painted by its owner. */
    show({ targets, target, transfer, resolved, isWhole }) {
      const { describe, scene } = store;
      const derived = (scene.values.derive ?? []).map((field) => field.name);
      const names = new Set([...describe.fields.map((field) => field.name), ...derived, target.field]);
      fill(
        pickTarget,
        targets.map((t) => [t.id, t.label]),
        target.id,
      );
      fill(
        pickField,
        [...names].map((name) => [name, name]),
        target.field,
      );
      pickTarget.hidden = targets.length < 2;
      const isMap = resolved.isMap && target.kind !== 'opacity';
      mapRows.hidden = !isMap;
      buttons.knots.hidden = !isMap;
      buttons.map.hidden = resolved.isMap;
      buttons.point.hidden = resolved.isMap && !resolved.hasOpacity;
      buttons.whole.setAttribute('aria-pressed', String(isWhole));
      if (isMap) {
        swatches.show(describe.maps, resolved.name);
        strip.style.backgroundImage = gradient(resolved.colours);
        mapName.textContent = resolved.name;
        reverse.checked = transfer.reverse === true;
        scale.show(transfer.scale ?? 'linear');
      }
      extras.show(target, transfer);
      put(parts);
    },
  };
}
