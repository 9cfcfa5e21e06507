// Numbers and dates as text.
'use strict';

const SUPERSCRIPT = '⁰¹²³⁴⁵⁶⁷⁸⁹';

/** A number with few digits, for a person: `3.1 × 10⁻⁴`, `287.35`. */
export function shown(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (!Number.isFinite(value)) return value < 0 ? '−∞' : '∞';
  if (value === 0) return '0';
  const exponent = Math.floor(Math.log10(Math.abs(value)));
  if (exponent >= -3 && exponent < 6) {
    return String(Number(value.toPrecision(Math.max(digits, exponent + 1)))).replace('-', '−');
  }
  const [mantissa, power] = value.toExponential(digits - 1).split('e');
  const high = [...String(Math.abs(Number(power)))].map((digit) => SUPERSCRIPT[digit]).join('');
  return `${Number(mantissa)} × 10${Number(power) < 0 ? '⁻' : ''}${high}`.replace(/^-/, '−');
}

/** A number as it is typed and stands in a scene: `3.1e-4`. */
export function plain(value, digits = 6) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '';
  const short = Number(value.toPrecision(digits));
  const text = String(short);
  if (short !== 0 && (Math.abs(short) < 1e-3 || text.length > digits + 4)) {
    const compact = short.toExponential().replace('e+', 'e');
    return compact.length < text.length ? compact : text;
  }
  return text;
}

/** A number with as many digits as a step of `step` needs. */
export function rounded(value, step) {
  if (!(step > 0) || !Number.isFinite(value)) return value;
  const digits = Math.min(100, Math.max(1, Math.ceil(Math.log10(Math.abs(value) / step + 1)) + 1));
  return Number(value.toPrecision(Math.min(17, digits)));
}

/** Degrees with a letter: `12.50° W`. */
export function degrees(value, positive, negative) {
  const text = Math.abs(value).toFixed(2);
  return `${text}° ${value < 0 ? negative : positive}`;
}

/** The label of a time, `2003-01-01_06:00:00` as `2003-01-01 06:00`. */
export function timeText(label, index) {
  if (!label) return `time ${index}`;
  return label.replace('_', ' ').replace(/(\d\d:\d\d):00$/, '$1');
}

/** Markdown as plain text: inline code and links lose their signs. */
export const unmarked = (text) => (text ?? '').replace(/\[([^\]]*)\]\([^)]*\)/g, '$1').replace(/`/g, '');

/** Text saved as a file of this name. */
export function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
