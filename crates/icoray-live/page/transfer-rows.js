// Rows below the curve: the selected point, the scale, the range.
'use strict';

import { h, iconButton, newId } from './dom.js';
import { plain } from './format.js';
import { rangeModeOf } from './transfer-model.js';

/** A row of choices of which one holds. */
export function segmented(label, choices, choose) {
  const name = newId('choice');
  const inputs = choices.map((choice) =>
    h('input', { type: 'radio', name, value: choice, onchange: () => choose(choice) }),
  );
  const element = h(
    'fieldset',
    { class: 'segmented' },
    h('legend', {}, label),
    h('div', {}, ...choices.map((choice, i) => h('label', {}, inputs[i], h('span', {}, choice)))),
  );
  return {
    element,
    show(chosen) {
      for (const input of inputs) input.checked = input.value === chosen;
    },
  };
}

const numberInput = (label, onchange, attributes = {}) =>
  h('input', { type: 'text', inputmode: 'decimal', class: 'number', 'aria-label': label, onchange, ...attributes });

/** The number in an input, or null, which marks the input. */
function read(input) {
  const value = Number(input.value.replace('−', '-').replace(',', '.'));
  const isGood = input.value.trim() !== '' && Number.isFinite(value);
  input.toggleAttribute('aria-invalid', !isGood);
  return isGood ? value : null;
}

/** The range: fixed ends, percentiles or union. */
export function makeRangeRow({ mode, fixed, percents }) {
  const modes = segmented('Range', ['fixed', 'percentile', 'union'], mode);
  const send = () => {
    const ends = [low, high].map(read);
    if (ends.includes(null)) return;
    if (now === 'fixed') fixed(ends);
    else percents(now, ends);
  };
  const low = numberInput('Lower end of the range', send);
  const high = numberInput('Upper end of the range', send);
  const note = h('span', { class: 'hint' });
  const element = h(
    'div',
    { class: 'stack' },
    modes.element,
    h('div', { class: 'ends' }, low, h('span', {}, 'to'), high, note),
  );
  let now = 'fixed';
  return {
    element,
    show(transfer, range) {
      const found = rangeModeOf(transfer);
      now = found.mode;
      modes.show(now);
      const values = now === 'fixed' ? range : found.percents;
      if (document.activeElement !== low) low.value = plain(values[0]);
      if (document.activeElement !== high) high.value = plain(values[1]);
      note.textContent = now === 'fixed' ? '' : `percent, now ${plain(range[0], 4)} to ${plain(range[1], 4)}`;
    },
  };
}

/** Value, opacity and colour of the selected point. */
export function makePointRow({ set, remove }) {
  const value = numberInput('Value of the point', () => {
    const v = read(value);
    if (v !== null) set('value', v, false);
  });
  const opacity = h('input', {
    type: 'range',
    min: 0,
    max: 0.999,
    step: 0.001,
    'aria-label': 'Opacity of the point',
    oninput: () => set('opacity', Number(opacity.value), true),
  });
  const part = h('output', {});
  const colour = h('input', {
    type: 'color',
    'aria-label': 'Colour of the point',
    oninput: () => set('colour', colour.value, true),
  });
  const units = h('span', { class: 'units' });
  const bin = iconButton('bin', 'Delete the point', remove);
  const row = h('div', { class: 'point-row' }, colour, value, units, opacity, part, bin);
  const hint = h('p', { class: 'hint' }, 'Select a point to edit it; a double click adds one.');
  const element = h('div', { class: 'point-box' }, row, hint);
  row.hidden = true;
  return {
    element,
    show(point) {
      row.hidden = !point;
      hint.hidden = Boolean(point);
      if (!point) return;
      const hasOpacity = point.kind === 'point' && point.opacity !== undefined;
      colour.hidden = !point.hasColour;
      opacity.hidden = !hasOpacity;
      part.hidden = !hasOpacity;
      units.textContent = point.units ?? '';
      if (document.activeElement !== value) value.value = plain(point.value);
      if (hasOpacity) {
        opacity.value = point.opacity;
        part.textContent = point.opacity.toFixed(2);
      }
      if (point.hasColour && document.activeElement !== colour) colour.value = point.colour;
    },
  };
}
