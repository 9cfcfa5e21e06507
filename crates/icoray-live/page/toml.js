// Values of a scene as the text of a TOML value, and back: for the keys that have no control of their own.
'use strict';

/** A value as TOML on one line. */
export function formatValue(value) {
  if (Array.isArray(value)) return `[${value.map(formatValue).join(', ')}]`;
  if (value && typeof value === 'object') {
    const pairs = Object.entries(value).map(([key, inner]) => `${formatKey(key)} = ${formatValue(inner)}`);
    return pairs.length > 0 ? `{ ${pairs.join(', ')} }` : '{}';
  }
  return typeof value === 'string' ? JSON.stringify(value) : String(value);
}

const formatKey = (key) => (/^[\w-]+$/.test(key) ? key : JSON.stringify(key));

/** The value of a TOML text; throws an `Error` with a sentence where it is none. */
export function parseValue(text) {
  let at = 0;
  const space = () => {
    while (/\s/.test(text[at] ?? '')) at += 1;
  };
  const bad = () => new Error(`character ${at + 1}: expected a TOML value such as 1.5, "text", [1, 2] or { key = 1 }`);
  const take = (sign) => {
    space();
    if (text[at] !== sign) return false;
    at += 1;
    return true;
  };
  const string = () => {
    const found = /^"(?:[^"\\]|\\.)*"|^'[^']*'/.exec(text.slice(at));
    if (!found) throw bad();
    at += found[0].length;
    return found[0][0] === '"' ? JSON.parse(found[0]) : found[0].slice(1, -1);
  };
  const list = (end, item) => {
    while (!take(end)) {
      item();
      if (!take(',')) {
        if (take(end)) return;
        throw bad();
      }
    }
  };
  const value = () => {
    space();
    if (take('[')) {
      const items = [];
      list(']', () => items.push(value()));
      return items;
    }
    if (take('{')) {
      const table = {};
      list('}', () => {
        space();
        const bare = /^[\w-]+/.exec(text.slice(at))?.[0];
        if (bare) at += bare.length;
        const key = bare ?? string();
        if (!take('=')) throw bad();
        table[key] = value();
      });
      return table;
    }
    if (text[at] === '"' || text[at] === "'") return string();
    const word = /^[^\s,\]}]+/.exec(text.slice(at))?.[0] ?? '';
    at += word.length;
    if (word === 'true' || word === 'false') return word === 'true';
    const number = Number(word.replace(/(?<=\d)_(?=\d)/g, ''));
    if (word === '' || Number.isNaN(number)) throw bad();
    return number;
  };
  const found = value();
  space();
  if (at < text.length) throw bad();
  return found;
}

/** The value in a text like a reference's default, or undefined where it is prose. */
export function defaultOf(text) {
  try {
    return parseValue((text ?? '').replace(/`/g, '').trim());
  } catch {
    return undefined;
  }
}
