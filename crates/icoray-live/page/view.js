// The canvas: fits pictures of any size into it and translates between its pixels and the picture's.
'use strict';

import { byId } from './dom.js';
import { drawLines } from './lines.js';
import { store } from './store.js';

const LARGEST = 2048;
const MOVING_PIXELS = 640 * 480;
/** Narrowest picture, width over height: the default camera then shows the whole planet on an upright phone. */
const NARROWEST = 0.86;

const canvas = byId('picture');
const context = canvas.getContext('2d');
let picture = null;
let labels = null;
let overlay = null;
let box = { left: 0, top: 0, width: 1, height: 1 };

/** The part of the stage, in CSS pixels, that a picture of this width over height takes; all of it within `rounding`. */
function fit(aspect, rounding = 0) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (Math.abs(width / height / aspect - 1) <= rounding) return { left: 0, top: 0, width, height };
  const fitted = Math.min(width, height * aspect);
  return { left: (width - fitted) / 2, top: (height - fitted / aspect) / 2, width: fitted, height: fitted / aspect };
}

const wantedAspect = () => Math.max(NARROWEST, canvas.clientWidth / Math.max(1, canvas.clientHeight));

/** Width and height in pixels to ask for. */
export function size(isMoving) {
  const { width, height } = fit(wantedAspect());
  let scale = Math.min(density(), LARGEST / Math.max(width, height));
  if (isMoving) scale = Math.min(scale, Math.sqrt(MOVING_PIXELS / (width * height)));
  return [Math.max(16, Math.round(width * scale)), Math.max(16, Math.round(height * scale))];
}

const density = () => window.devicePixelRatio || 1;

/** Width and height of the canvas, pixels of the screen. */
export const room = () => [canvas.clientWidth, canvas.clientHeight].map((side) => Math.round(side * density()));

/** Shows a picture, with the labels and lines that lie over it in pixels of the screen, and keeps them until the next. */
export function draw([bitmap, over = null], lines) {
  picture?.close();
  labels?.close();
  [picture, labels, overlay] = [bitmap, over, lines];
  paint();
}

/** Draws the last picture anew, as after a change of the window. */
export function paint() {
  const scale = density();
  const [width, height] = room();
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  context.clearRect(0, 0, width, height);
  // Drafts have sides of whole pixels.
  box = picture
    ? fit(picture.width / picture.height, 1 / Math.min(picture.width, picture.height))
    : fit(wantedAspect());
  if (!picture) return;
  context.imageSmoothingEnabled = true;
  context.imageSmoothingQuality = 'high';
  const place = [box.left, box.top, box.width, box.height].map((side) => side * scale);
  context.drawImage(picture, ...place);
  if (overlay) drawLines(context, place, overlay);
  if (labels) context.drawImage(labels, ...place.map(Math.round));
}

/** Where the picture lies on the canvas, CSS pixels. */
export const pictureBox = () => box;

/** The place of a pointer in the picture, as parts of its width and height; outside it below 0 or above 1. */
export function placeOf(event) {
  const rect = canvas.getBoundingClientRect();
  return {
    x: (event.clientX - rect.left - box.left) / box.width,
    y: (event.clientY - rect.top - box.top) / box.height,
  };
}

/** Puts an element of the stage at a place of the picture. */
export function put(element, place) {
  element.style.left = `${box.left + place.x * box.width}px`;
  element.style.top = `${box.top + place.y * box.height}px`;
}

/** Colours the stage around the picture as the scene's background. */
export function paintStage() {
  const background = store.scene?.values.background ?? 'black';
  const isTransparent = background === 'transparent';
  const stage = byId('stage');
  stage.classList.toggle('is-transparent', isTransparent);
  stage.style.backgroundColor = isTransparent ? '' : background;
}
