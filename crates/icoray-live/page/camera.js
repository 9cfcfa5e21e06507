// The camera's geometry: turning, zooming, centring, and where rays and places are. Without state and without DOM.
//
// A camera is { kind: 'globe', lon, lat, distance, keys } or { kind: 'free', eye, target, up }, with fov in degrees.
// The x axis goes through 0°E 0°N, the z axis through the north pole; lengths are planet radii.
'use strict';

const RAD = Math.PI / 180;
const NEAREST = 1.01;
const FARTHEST = 1000;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const plus = (a, b, factor = 1) => a.map((x, i) => x + b[i] * factor);
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((x) => x / (length(a) || 1));
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

/** A vector turned by an angle in radians about a unit axis. */
function turnedAbout(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const along = dot(axis, v) * (1 - c);
  const side = cross(axis, v);
  return v.map((x, i) => x * c + side[i] * s + axis[i] * along);
}

/** The unit vector towards a place. */
export const towards = (lon, lat) => [
  Math.cos(lat * RAD) * Math.cos(lon * RAD),
  Math.cos(lat * RAD) * Math.sin(lon * RAD),
  Math.sin(lat * RAD),
];

/** Longitude and latitude of a point, degrees. */
export function lonLat(point) {
  return { lon: Math.atan2(point[1], point[0]) / RAD, lat: Math.asin(clamp(point[2] / length(point), -1, 1)) / RAD };
}

/** The camera of a scene as the server gives it. */
export function cameraOf(scene) {
  const given = scene.values.camera;
  const fov = given?.fov ?? scene.camera?.fov ?? 30;
  if (given?.eye) {
    return { kind: 'free', eye: given.eye, target: given.target ?? [0, 0, 0], up: given.up ?? [0, 0, 1], fov };
  }
  const seen = scene.camera?.eye;
  if ((!given || given.path) && seen) {
    const keys = { distance: 'distance', drops: given?.path ? ['path'] : [], isWhole: true };
    return { kind: 'globe', ...lonLat(seen), distance: length(seen), fov, keys };
  }
  const own = given?.altitude !== undefined ? given.altitude + 1 : given?.distance;
  const distance = own ?? 1.1 / Math.sin(0.43 * fov * RAD);
  const keys = { distance: given?.altitude !== undefined ? 'altitude' : 'distance', drops: [] };
  return { kind: 'globe', lon: given?.lon ?? 0, lat: given?.lat ?? 25, distance, fov, keys };
}

/** Eye, target and up of a camera. */
export function frameOf(camera) {
  if (camera.kind === 'free') return camera;
  return { eye: towards(camera.lon, camera.lat).map((x) => x * camera.distance), target: [0, 0, 0], up: [0, 0, 1] };
}

function axesOf(camera) {
  const { eye, target, up } = frameOf(camera);
  const forward = unit(plus(target, eye, -1));
  let side = cross(forward, up);
  if (length(side) < 1e-9) side = cross(forward, [1, 0, 0]);
  const right = unit(side);
  return { eye, forward, right, above: cross(right, forward) };
}

/** Degrees on the planet that a pixel at the picture's middle covers, for a picture of `height` pixels. */
export function degreesPerPixel(camera, height) {
  const distance = camera.kind === 'globe' ? camera.distance : length(camera.eye);
  const room = Math.max(0.02, distance - 1);
  return Math.min(0.7, (2 * Math.tan((camera.fov * RAD) / 2) * room) / height / RAD);
}

/** A longitude from -180 to 180 degrees. */
const wrapped = (lon) => lon - 360 * Math.round(lon / 360);

/** The camera turned so that a point under the hand follows it by `east` and `north` degrees on the ground. */
export function turned(camera, east, north) {
  if (camera.kind === 'globe') {
    const stretch = Math.max(0.25, Math.cos(camera.lat * RAD));
    return { ...camera, lon: wrapped(camera.lon - east / stretch), lat: clamp(camera.lat - north, -89.9, 89.9) };
  }
  const { right } = axesOf(camera);
  const isUpright = length(cross(camera.up, [0, 0, 1])) < 1e-9;
  const turn = (v) => turnedAbout(v, [0, 0, 1], -east * RAD);
  const tilt = (v) => turn(turnedAbout(v, right, north * RAD));
  for (const move of [tilt, turn]) {
    const found = { ...camera, eye: move(camera.eye), target: move(camera.target) };
    if (!isUpright) found.up = move(camera.up);
    const view = unit(plus(found.target, found.eye, -1));
    const steep = length(cross(view, unit(found.up)));
    // Not over the pole, where up would be along the view.
    if (steep > 0.03 && Math.abs(lonLat(found.eye).lat) < 89.5) return found;
  }
  return camera;
}

/** The camera nearer by a factor below 1, or farther by one above 1. */
export function zoomed(camera, factor) {
  if (camera.kind === 'globe') {
    return { ...camera, distance: clamp(1 + (camera.distance - 1) * factor, NEAREST, FARTHEST) };
  }
  const view = plus(camera.eye, camera.target, -1);
  const far = clamp(length(view) * factor, 1e-3, FARTHEST);
  const eye = plus(camera.target, unit(view), far);
  return length(eye) < NEAREST && far < length(view) ? camera : { ...camera, eye };
}

/** The camera with a place at the picture's middle. */
export function centred(camera, lon, lat) {
  if (camera.kind === 'globe') return { ...camera, lon, lat: clamp(lat, -89.9, 89.9) };
  const { forward, eye } = axesOf(camera);
  const middle = unit(sphereHit(eye, forward, 1) ?? camera.target);
  const goal = towards(lon, lat);
  const axis = cross(middle, goal);
  if (length(middle) < 0.5 || length(axis) < 1e-9) return camera;
  const turn = (v) => turnedAbout(v, unit(axis), Math.atan2(length(axis), dot(middle, goal)));
  const isUpright = length(cross(camera.up, [0, 0, 1])) < 1e-9;
  const found = { ...camera, eye: turn(camera.eye), target: turn(camera.target) };
  return isUpright ? found : { ...found, up: turn(camera.up) };
}

const neat = (x, digits) => Number(x.toFixed(digits));

/** The changes of a scene that lead from one camera to another. */
export function changesOf(camera, before) {
  const at = (key, value) => ({ path: ['camera', key], value });
  if (camera.kind === 'free') {
    const vector = (v) => v.map((x) => neat(x, 6));
    const changes = [at('eye', vector(camera.eye)), at('target', vector(camera.target))];
    return camera.up === before.up ? changes : [...changes, at('up', vector(camera.up))];
  }
  const digits = camera.distance < 1.2 ? 4 : 2;
  const changes = camera.keys.drops.map((key) => at(key, null));
  const { isWhole } = camera.keys;
  if (isWhole || camera.lon !== before.lon) changes.push(at('lon', neat(camera.lon, digits)));
  if (isWhole || camera.lat !== before.lat) changes.push(at('lat', neat(camera.lat, digits)));
  if (isWhole || camera.distance !== before.distance) {
    const far = camera.keys.distance === 'altitude' ? camera.distance - 1 : camera.distance;
    changes.push(at(camera.keys.distance, neat(far, 4)));
  }
  return changes;
}

/** The nearest point at which a ray from `eye` along the unit vector `ray` meets a sphere, or null. */
function sphereHit(eye, ray, radius) {
  const half = dot(eye, ray);
  const root = half * half - dot(eye, eye) + radius * radius;
  const far = -half - Math.sqrt(root);
  return root > 0 && far > 0 ? plus(eye, ray, far) : null;
}

/** Longitude and latitude on the planet's surface at a place of the picture, or null beside the planet. */
export function placeOnGround(camera, { x, y }, aspect) {
  const { eye, forward, right, above } = axesOf(camera);
  const half = Math.tan((camera.fov * RAD) / 2);
  const ray = unit(plus(plus(forward, right, (2 * x - 1) * half * aspect), above, (1 - 2 * y) * half));
  const hit = sphereHit(eye, ray, 1);
  return hit && lonLat(hit);
}
