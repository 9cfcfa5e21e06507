// Controls for all keys of the scene, generated from the description.
'use strict';

import { byId, h, iconButton, newId } from './dom.js';
import { unmarked } from './format.js';
import { additionOf, isAdvanced, keepVolume, newEntry } from './hints.js';
import { change, move } from './sender.js';
import { emit, on, store, valueAt } from './store.js';
import { makeWidget, resetButton } from './widgets.js';

const spoken = (name) => name.replace(/_/g, ' ').replace(/\./g, ', ');
const title = (name) => (name === '' ? 'general' : spoken(name));

/** What a key means, for the note below the list and for screen readers. */
function meaningOf(key) {
  const parts = [unmarked(key.meaning)];
  if (key.default && key.default !== 'none') parts.push(`Default: ${unmarked(key.default)}.`);
  if (key.range) parts.push(`Range: ${unmarked(key.range)}.`);
  return parts.join(' ');
}

function makeRow(section, key, base) {
  const id = newId('key');
  const path = [...base, ...key.name.split('.')];
  const send = (value, isMoving) => {
    const changes = [{ path, value }];
    if (isMoving) move(changes);
    else change(changes).then((isTaken) => element.classList.toggle('is-refused', !isTaken));
  };
  const widget = makeWidget(section, key, () => path, send);
  const note = h('span', { id: `${id}-note`, hidden: true }, meaningOf(key));
  widget.input.id = id;
  widget.input.setAttribute('aria-describedby', note.id);
  const reset = resetButton(spoken(key.name), () => {
    send(null, false);
    widget.input.focus();
  });
  const describe = () => emit('key', { name: [section, key.name].filter(Boolean).join('.'), text: meaningOf(key) });
  const element = h(
    'div',
    {
      class: 'row',
      onfocusin: describe,
      onpointerenter: describe,
      'data-find': `${section} ${key.name} ${unmarked(key.meaning)}`.toLowerCase(),
    },
    h('label', { for: id }, spoken(key.name)),
    h('div', { class: 'control' }, widget.element),
    reset,
    note,
  );
  return {
    element,
    update(values) {
      const value = valueAt(key.name.split('.'), values);
      element.classList.toggle('is-set', value !== undefined);
      reset.style.visibility = value === undefined ? 'hidden' : '';
      widget.show(value);
    },
  };
}

/** Rows for keys of the table at `base`; a key whose parts are keys of their own is shown by its parts. */
export function makeKeys(keys, base, section = base.filter((part) => typeof part === 'string').join('.')) {
  const isGroup = (key) => keys.some((other) => other.name.startsWith(`${key.name}.`)) && /^table/.test(key.type);
  const made = keys.filter((key) => !isGroup(key)).map((key) => ({ key, row: makeRow(section, key, base) }));
  const rows = made.map(({ row }) => row);
  const elements = (wanted) => made.filter(({ key }) => isAdvanced(section, key) === wanted).map(({ row }) => row.element);
  const advanced = elements(true);
  const group =
    advanced.length > 0 &&
    h(
      'details',
      { class: 'section advanced' },
      h('summary', {}, h('span', { class: 'name' }, 'advanced')),
      h('div', { class: 'rows' }, ...advanced),
    );
  return {
    element: h('div', { class: 'rows' }, ...elements(false), group),
    update: (values) => rows.forEach((row) => row.update(values ?? {})),
  };
}

/** A table that a scene has or has not. */
function makeTable(section) {
  const isTop = section.name === '';
  const path = section.name.split('.');
  const keys = makeKeys(section.keys, isTop ? [] : path, section.name);
  const inScene = h('input', {
    type: 'checkbox',
    class: 'switch',
    role: 'switch',
    'aria-label': `${title(section.name)} in the scene`,
    onchange: () =>
      change(
        inScene.checked ? [...keepVolume(section.name), { path, value: newEntry(section) }] : [{ path, value: null }],
      ),
  });
  const about = section.about ? h('p', { class: 'hint' }, unmarked(section.about)) : null;
  const body = h('div', { class: 'body' }, about, keys.element);
  const head = h('summary', {}, h('span', { class: 'name' }, title(section.name)));
  const element = h('details', { class: 'section', open: isTop }, head, body);
  const box = h('div', { class: 'section-box' }, element, isTop ? null : inScene);
  return {
    element: box,
    update(values) {
      const own = isTop ? values : valueAt(path, values);
      inScene.checked = own !== undefined;
      box.classList.toggle('is-set', own !== undefined && !isTop);
      keys.update(own);
    },
  };
}

/** A list of tables, such as surfaces. */
function makeList(section) {
  const path = section.name.split('.');
  const entries = h('div', { class: 'entries' });
  const count = h('span', { class: 'count' });
  const add = iconButton('plus', `Add to ${title(section.name)}`, async () => {
    element.open = true;
    if (await change(await additionOf(section))) entries.lastElementChild?.querySelector('input, select')?.focus();
  });
  const about = section.about ? h('p', { class: 'hint' }, unmarked(section.about)) : null;
  const element = h(
    'details',
    { class: 'section' },
    h('summary', {}, h('span', { class: 'name' }, title(section.name)), count),
    h('div', { class: 'body' }, about, entries),
  );
  const box = h('div', { class: 'section-box' }, element, add);
  let shown = [];
  const makeEntry = (i) => {
    const keys = makeKeys(section.keys, [...path, i], section.name);
    const name = h('h4', {});
    const bin = iconButton('bin', `Remove entry ${i + 1} of ${title(section.name)}`, () =>
      change([{ path: [...path, i], value: null }]),
    );
    const update = (values) => {
      const word = ['name', 'pattern', 'field', 'layer', 'cut']
        .map((key) => values[key])
        .find((value) => value !== undefined);
      name.textContent = `${i + 1}${word === undefined ? '' : ` · ${word}`}`;
      keys.update(values);
    };
    return { element: h('div', { class: 'entry' }, h('div', { class: 'head-row' }, name, bin), keys.element), update };
  };
  return {
    element: box,
    update(values) {
      const list = valueAt(path, values) ?? [];
      if (shown.length !== list.length) {
        shown = list.map((_, i) => makeEntry(i));
        entries.replaceChildren(...shown.map((entry) => entry.element));
      }
      count.textContent = list.length > 0 ? String(list.length) : '';
      box.classList.toggle('is-set', list.length > 0);
      shown.forEach((entry, i) => entry.update(list[i]));
    },
  };
}

/** Buttons that switch parts of a scene: each pattern of lines, and tables without required keys. */
function makeChips(sections) {
  const chips = [];
  const lines = sections.find((section) => section.name === 'lines' && section.is_list);
  const pattern = lines?.keys.find((key) => key.name === 'pattern');
  const chip = (label, isOn, toggle) => {
    const button = h(
      'button',
      { type: 'button', class: 'chip', onclick: () => toggle(isOn(store.scene.values)) },
      label,
    );
    chips.push({ button, isOn });
    return button;
  };
  const buttons = (pattern?.choices ?? []).map((name) => {
    const find = (values) => (values.lines ?? []).findIndex((line) => (line.pattern ?? 'graticule') === name);
    return chip(
      name,
      (values) => find(values) >= 0,
      (isOn) =>
        change(
          isOn
            ? [{ path: ['lines', find(store.scene.values)], value: null }]
            : [
                ...keepVolume('lines'),
                {
                  path: ['lines', (store.scene.values.lines ?? []).length],
                  value: { pattern: name, ...(name !== 'coast' && { opacity: 0.4 }) },
                },
              ],
        ),
    );
  });
  for (const section of sections.filter((found) => ['light', 'labels', 'ground'].includes(found.name))) {
    const isOn = (values) =>
      values[section.name] !== undefined && values[section.name].on !== false && values[section.name].kind !== 'none';
    buttons.push(
      chip(title(section.name), isOn, (isNow) =>
        change(
          isNow
            ? [{ path: [section.name], value: null }]
            : [...keepVolume(section.name), { path: [section.name], value: newEntry(section) }],
        ),
      ),
    );
  }
  return {
    element: h('div', { class: 'chips', role: 'group', 'aria-label': 'Shown' }, ...buttons),
    update: (values) => chips.forEach(({ button, isOn }) => button.setAttribute('aria-pressed', String(isOn(values)))),
  };
}

let parts = [];
let openBefore = null;

/** Shows the settings whose name or meaning has the text; sections fold again when it is empty. */
function filter(text) {
  const wanted = text.trim().toLowerCase();
  const all = [...byId('keys').querySelectorAll('details')];
  if (wanted !== '') openBefore ??= all.filter((details) => details.open);
  else if (openBefore) {
    for (const details of all) details.open = openBefore.includes(details);
    openBefore = null;
  }
  for (const box of byId('keys').querySelectorAll('.section-box')) {
    const rows = [...box.querySelectorAll('.row')];
    const isNamed = box.querySelector('.name').textContent.includes(wanted);
    for (const row of rows) row.hidden = wanted !== '' && !isNamed && !row.dataset.find.includes(wanted);
    const hasFound = isNamed || rows.some((row) => !row.hidden);
    box.hidden = wanted !== '' && !hasFound;
    if (wanted !== '' && hasFound) for (const details of box.querySelectorAll('details')) details.open = true;
  }
}

let built = '';

function build(describe) {
  // A model that runs sends its description again for new times.
  const sections = describe.sections.filter((section) => section.keys.length > 0);
  const text = JSON.stringify(sections);
  if (text === built) return;
  built = text;
  const open = new Set(
    [...byId('keys').querySelectorAll('details[open] > summary .name')].map((name) => name.textContent),
  );
  parts = [
    makeChips(sections),
    ...sections.map((section) => (section.is_list ? makeList(section) : makeTable(section))),
  ];
  byId('keys').replaceChildren(...parts.map((part) => part.element));
  for (const details of byId('keys').querySelectorAll('details')) {
    if (open.has(details.querySelector('.name').textContent)) details.open = true;
  }
  if (store.scene) update(store.scene);
}

function update(scene) {
  if (!store.isMoving) for (const part of parts) part.update(scene.values);
}

/** Builds the controls when the description comes. */
export function start() {
  on('describe', build);
  on('scene', update);
  on('moving', (isMoving) => {
    if (!isMoving && store.scene) update(store.scene);
  });
  on('key', ({ name, text }) => byId('about-key').replaceChildren(h('strong', {}, name), ` ${text}`));
  byId('find-key').addEventListener('input', (event) => filter(event.target.value));
}
