// A control for a key, by the key's type. Each control is { element, input, show(value) }; `value` undefined shows the
// default. `send(value, isMoving)` is called with a new value, null for the default.
'use strict';

import { hexOf } from './colour.js';
import { h, iconButton } from './dom.js';
import { plain } from './format.js';
import { sliderOf } from './hints.js';
import { emit, store } from './store.js';
import { defaultOf, formatValue, parseValue } from './toml.js';

const parse = (text) => Number(text.replace('−', '-'));
const idle = (input) => document.activeElement !== input;

function flag(key, send) {
  const input = h('input', {
    type: 'checkbox',
    class: 'switch',
    role: 'switch',
    onchange: () => send(input.checked, false),
  });
  return {
    element: input,
    input,
    show: (value) => {
      input.checked = value ?? defaultOf(key.default) ?? false;
    },
  };
}

function choice(options, key, send) {
  const input = h('select', { onchange: () => send(input.value === '' ? null : input.value, false) });
  const show = (value) => {
    const names = [...options()];
    if (value !== undefined && !names.includes(value)) names.push(value);
    const first = defaultOf(key.default);
    const label = typeof first === 'string' ? `${first} (default)` : 'default';
    input.replaceChildren(
      h('option', { value: '', selected: value === undefined }, label),
      ...names
        .filter((name) => name !== first || value === first)
        .map((name) => h('option', { value: name, selected: name === value }, String(name))),
    );
  };
  return { element: input, input, show };
}

const fieldNames = () => [
  ...(store.describe?.fields ?? []).map((f) => f.name),
  ...(store.scene?.values.derive ?? []).map((d) => d.name),
];

/** A free text; `read` turns it into a value or throws a sentence, `write` shows a value. */
function text(key, send, read, write, attributes = {}) {
  const input = h('input', {
    type: 'text',
    class: 'text',
    autocomplete: 'off',
    spellcheck: 'false',
    ...attributes,
    onchange: () => {
      const typed = input.value.trim();
      try {
        const value = typed === '' ? null : read(typed);
        input.removeAttribute('aria-invalid');
        input.setCustomValidity('');
        send(value, false);
      } catch (error) {
        input.setAttribute('aria-invalid', 'true');
        input.setCustomValidity(error.message);
        input.reportValidity();
      }
    },
  });
  const known = (key.default ?? '').replace(/`/g, '');
  input.placeholder = !known || known === 'none' ? '' : attributes.inputmode && known.length > 8 ? 'default' : known;
  return {
    element: input,
    input,
    show: (value) => {
      if (idle(input)) input.value = value === undefined ? '' : write(value);
    },
  };
}

function number(section, key, send) {
  const isInteger = key.type.startsWith('integer');
  const read = (typed) => {
    const value = parse(typed);
    if (!Number.isFinite(value) || (isInteger && !Number.isInteger(value)))
      throw new Error(`Expected ${isInteger ? 'an integer' : 'a number'}.`);
    return value;
  };
  const box = text(key, send, read, (value) => plain(value, 7), {
    inputmode: isInteger ? 'numeric' : 'decimal',
    class: 'number',
  });
  const slider = sliderOf(section, key);
  if (!slider) return box;
  const { low, high, isLog } = slider;
  const steps = 1000;
  const to = (v) =>
    (isLog ? Math.log(Math.max(v, low) / low) / Math.log(high / low) : (v - low) / (high - low)) * steps;
  const from = (p) => (isLog ? low * (high / low) ** (p / steps) : low + ((high - low) * p) / steps);
  const neat = (v) => {
    if (isInteger) return Math.round(v);
    const grain = isLog ? v / 50 : (high - low) / 1000;
    const power = 10 ** Math.floor(Math.log10(grain) + 1e-9);
    return Number((Math.round(v / power) * power).toPrecision(8));
  };
  const start = typeof defaultOf(key.default) === 'number' ? defaultOf(key.default) : undefined;
  const input = h('input', {
    type: 'range',
    min: 0,
    max: steps,
    step: 'any',
    tabindex: 0,
    oninput: () => {
      const value = neat(from(Number(input.value)));
      box.input.value = plain(value, 7);
      input.setAttribute('aria-valuetext', plain(value));
      send(value, true);
    },
  });
  // The browser's own steps of a slider are too fine with step = any.
  input.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const place = Number(input.value);
    const least = isInteger ? Math.abs(to(neat(from(place)) + 1) - to(neat(from(place)))) : steps / 100;
    input.value = Math.min(steps, Math.max(0, place + step * Math.max(least, steps / 100)));
    input.dispatchEvent(new Event('input'));
  });
  box.input.setAttribute('aria-label', `${key.name}, number`);
  const show = (value) => {
    box.show(value);
    const seen = value ?? start;
    input.classList.toggle('is-unset', value === undefined);
    if (!input.matches(':active')) input.value = seen === undefined ? steps / 2 : to(seen);
    input.setAttribute('aria-valuetext', seen === undefined ? 'default' : plain(seen));
  };
  return { element: h('span', { class: 'slide' }, input, box.input), input, show };
}

function colour(key, send) {
  const words = key.choices ?? [];
  const read = (typed) => {
    if (words.includes(typed) || hexOf(typed)) return typed;
    throw new Error('Expected a colour such as #ff8800 or steelblue.');
  };
  const box = text(key, send, read, String);
  const well = h('input', {
    type: 'color',
    oninput: () => {
      box.input.value = well.value;
      send(well.value, true);
    },
  });
  box.input.setAttribute('aria-label', `${key.name}, as text`);
  const toggles = words.map((word) => {
    const button = h(
      'button',
      {
        type: 'button',
        class: 'word',
        onclick: () => send(button.getAttribute('aria-pressed') === 'true' ? null : word, false),
      },
      word,
    );
    return button;
  });
  const show = (value) => {
    box.show(value);
    const hex = hexOf(value ?? (key.default ?? '').replace(/[`"]/g, ''));
    if (hex && idle(well)) well.value = hex;
    well.classList.toggle('is-unset', !hexOf(value));
    toggles.forEach((button, i) => button.setAttribute('aria-pressed', String(value === words[i])));
  };
  return { element: h('span', { class: 'colour' }, well, box.input, ...toggles), input: well, show };
}

/** A list of a known number of numbers, one input each. */
function vector(names, key, send) {
  const inputs = names.map((name) =>
    h('input', {
      type: 'text',
      inputmode: 'decimal',
      class: 'number',
      placeholder: name,
      'aria-label': `${key.name}, ${name}`,
      onchange: () => {
        const values = inputs.map((input) => (input.value.trim() === '' ? NaN : parse(input.value)));
        if (values.every(Number.isNaN)) send(null, false);
        else if (values.every(Number.isFinite)) send(values, false);
      },
    }),
  );
  const show = (value) =>
    inputs.forEach((input, i) => {
      if (idle(input)) input.value = Array.isArray(value) ? plain(value[i], 7) : '';
    });
  return { element: h('span', { class: 'vector' }, ...inputs), input: inputs[0], show };
}

function list(key, send, isText) {
  const read = (typed) => {
    const items = typed
      .replace(/^\[|\]$/g, '')
      .split(',')
      .map((item) => item.trim().replace(/^["']|["']$/g, ''))
      .filter(Boolean);
    const values = isText ? items : items.map(parse);
    if (!isText && !values.every(Number.isFinite)) throw new Error('Expected numbers with commas between them.');
    return values;
  };
  return text(key, send, read, (value) =>
    [value]
      .flat()
      .map((item) => (isText ? item : plain(item, 7)))
      .join(', '),
  );
}

/** A text or an integer: numbers are sent as numbers. */
function mixed(key, send) {
  const isWords = key.choices?.length > 0;
  const id = `choices-${key.name}-${Math.random().toString(36).slice(2)}`;
  const box = text(
    key,
    send,
    (typed) => (/^-?\d+$/.test(typed) ? Number(typed) : typed),
    String,
    isWords ? { list: id } : {},
  );
  if (!isWords) return box;
  return {
    ...box,
    element: h(
      'span',
      { class: 'mixed' },
      box.input,
      h('datalist', { id }, ...key.choices.map((word) => h('option', { value: word }))),
    ),
  };
}

function transferLink(path) {
  const input = h(
    'button',
    { type: 'button', onclick: () => emit('open-transfer', path().join('.')) },
    'Edit in Colour',
  );
  return { element: input, input, show: () => {} };
}

/** The control of a key of a section; `path()` is the key's path in the scene. */
export function makeWidget(section, key, path, send) {
  const type = (key.type ?? '').replace(/`/g, '');
  const last = key.name.split('.').at(-1);
  if (type === 'table' && last === 'transfer') return transferLink(path);
  if (type === 'boolean') return flag(key, send);
  if (/^list of colours/.test(type) || /^(list of strings|string or list)/.test(type)) return list(key, send, true);
  if (/^colour/.test(type)) return colour(key, send);
  if (type === 'string' && /^(field|color_by|anomaly)$/.test(last)) return choice(fieldNames, key, send);
  if (/^(number|integer)$/.test(type)) return number(section, key, send);
  if (/integer/.test(type)) return mixed(key, send);
  if (key.choices?.length > 0 && !/table|list/.test(type)) return choice(() => key.choices, key, send);
  if (type === 'string') return text(key, send, (typed) => typed, String);
  const named = /^\[([\w ]+(?:, [\w ]+)*)\]$/.exec(type);
  if (named) return vector(named[1].split(', '), key, send);
  if (/^list of numbers/.test(type)) return list(key, send, false);
  return text(key, send, parseValue, formatValue);
}

/** A button that sets a key back to its default. */
export const resetButton = (name, onclick) =>
  iconButton('reset', `Set ${name} back to its default`, onclick, { class: 'icon-button reset' });
