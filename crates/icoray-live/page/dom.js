// Creation of elements, without templates and without inline styles.
'use strict';

const SVG = 'http://www.w3.org/2000/svg';
let last = 0;

/** A new id, unique in the page. */
export const newId = (prefix) => `${prefix}-${++last}`;

/** The element with an id. */
export const byId = (id) => document.getElementById(id);

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** An HTML element: `h('button', { class: 'x', onclick: f }, 'text')`. */
export const h = (tag, attributes = {}, ...children) => fill(document.createElement(tag), attributes, children);

/** An SVG element. */
export const s = (tag, attributes = {}, ...children) => fill(document.createElementNS(SVG, tag), attributes, children);

/** Sets attributes of an element; null removes one. */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) element.removeAttribute(name);
    else element.setAttribute(name, value === true ? '' : value);
  }
  return element;
}

/** An icon from the sprite in index.html. */
export function icon(name) {
  const use = s('use', { href: `#i-${name}` });
  return s('svg', { class: 'icon', 'aria-hidden': 'true', viewBox: '0 0 16 16' }, use);
}

/** A button with an icon, and a name for screen readers and the tooltip. */
export const iconButton = (name, label, onclick, attributes = {}) =>
  h(
    'button',
    { type: 'button', class: 'icon-button', 'aria-label': label, title: label, onclick, ...attributes },
    icon(name),
  );

/** Whether keys belong to this element itself, so that shortcuts of the page must not take them. */
export function takesKeys(element) {
  return element.matches?.('input, select, textarea, [role="slider"], [role="radio"], [role="tab"], [contenteditable]');
}
