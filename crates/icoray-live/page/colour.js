// Colours and colour maps.
'use strict';

const context = document.createElement('canvas').getContext('2d', { willReadFrequently: true });

/** An opaque CSS colour as `#rrggbb`, or null where the text is none. */
export function hexOf(text) {
  if (typeof text !== 'string' || !CSS.supports('color', text)) return null;
  context.fillStyle = '#000000';
  context.fillStyle = text;
  return /^#[0-9a-f]{6}$/i.test(context.fillStyle) ? context.fillStyle : null;
}

const parts = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** Red, green and blue of `#rrggbb`, 0 to 255. */
export const rgbOf = parts;

/** The colour a part of the way from one to another. */
export function mixed(from, to, part) {
  const [a, b] = [parts(from), parts(to)];
  return `#${a
    .map((x, i) =>
      Math.round(x + (b[i] - x) * part)
        .toString(16)
        .padStart(2, '0'),
    )
    .join('')}`;
}

/** The colour at a part, 0 to 1, of evenly spaced colours. */
export function colourAt(colours, part) {
  const at = Math.min(1, Math.max(0, part)) * (colours.length - 1);
  const i = Math.min(colours.length - 2, Math.floor(at));
  return colours.length === 1 ? colours[0] : mixed(colours[i], colours[i + 1], at - i);
}

/** The colours of a map by its name in a scene, which may end in `_r`. */
export function mapColours(maps, name, reverse = false) {
  const lower = name.toLowerCase();
  const exact = maps.find((map) => map.name.toLowerCase() === lower);
  const base = exact ?? maps.find((map) => `${map.name.toLowerCase()}_r` === lower);
  if (!base) return ['#000000', '#ffffff'];
  const isTurned = !exact !== reverse;
  return isTurned ? [...base.colors].reverse() : base.colors;
}

/** A CSS gradient of colours. */
export const gradient = (colours) => `linear-gradient(to right, ${colours.join(', ')})`;
