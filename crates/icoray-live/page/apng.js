// Animated PNG from PNG pictures of one size and kind: their data stay as they are. (W3C PNG, third edition, 11.3.6.)
'use strict';

const SIGNATURE = [137, 80, 78, 71, 13, 10, 26, 10];

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

function crc(bytes) {
  let value = 0xffffffff;
  for (const byte of bytes) value = TABLE[(value ^ byte) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}

/** The chunks of a PNG: name and data of each. */
function chunks(png) {
  const view = new DataView(png.buffer, png.byteOffset, png.byteLength);
  const found = [];
  for (let at = SIGNATURE.length; at < png.length; ) {
    const length = view.getUint32(at);
    const name = String.fromCharCode(...png.subarray(at + 4, at + 8));
    found.push({ name, data: png.subarray(at + 8, at + 8 + length) });
    at += 12 + length;
  }
  return found;
}

function chunk(name, data) {
  const bytes = new Uint8Array(12 + data.length);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, data.length);
  bytes.set([...name].map((letter) => letter.charCodeAt(0)), 4);
  bytes.set(data, 8);
  view.setUint32(8 + data.length, crc(bytes.subarray(4, 8 + data.length)));
  return bytes;
}

/** Bytes of big-endian numbers: `[[number, length], ...]`. */
function packed(numbers) {
  const bytes = [];
  for (const [number, length] of numbers) {
    for (let k = length - 1; k >= 0; k--) bytes.push(Math.floor(number / 256 ** k) & 255);
  }
  return Uint8Array.from(bytes);
}

const isSame = (a, b) => a.length === b.length && a.every((byte, k) => byte === b[k]);

/** The animation of pictures (Uint8Array of a PNG each) at `fps` pictures per second, for ever; a list of parts. */
export function animation(pictures, fps) {
  const first = chunks(pictures[0]);
  const header = first.find(({ name }) => name === 'IHDR').data;
  const size = new DataView(header.buffer, header.byteOffset);
  const [width, height] = [size.getUint32(0), size.getUint32(4)];
  const parts = [Uint8Array.from(SIGNATURE), chunk('IHDR', header)];
  // The text chunks of the first picture do not describe all pictures; its colour chunks do.
  const kept = first.filter(({ name }) => ['sRGB', 'gAMA', 'cHRM', 'iCCP', 'pHYs', 'PLTE', 'tRNS'].includes(name));
  parts.push(...kept.map(({ name, data }) => chunk(name, data)));
  parts.push(chunk('acTL', packed([[pictures.length, 4], [0, 4]])));
  let sequence = 0;
  pictures.forEach((picture, number) => {
    const own = number === 0 ? first : chunks(picture);
    if (!isSame(own.find(({ name }) => name === 'IHDR').data, header)) {
      throw new Error('The pictures differ in size or kind.');
    }
    const control = [[sequence++, 4], [width, 4], [height, 4], [0, 4], [0, 4], [100, 2], [Math.round(100 * fps), 2]];
    parts.push(chunk('fcTL', packed([...control, [0, 1], [0, 1]])));
    for (const { data } of own.filter(({ name }) => name === 'IDAT')) {
      if (number === 0) {
        parts.push(chunk('IDAT', data));
      } else {
        const numbered = new Uint8Array(4 + data.length);
        numbered.set(packed([[sequence++, 4]]));
        numbered.set(data, 4);
        parts.push(chunk('fdAT', numbered));
      }
    }
  });
  parts.push(chunk('IEND', new Uint8Array()));
  return parts;
}
