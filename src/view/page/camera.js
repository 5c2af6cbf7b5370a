'use strict';

// Views, and what gestures do to them; nothing here knows the document. A view is {eye, center, up, fovy,
// ortho} as in the protocol: `fovy` in degrees, `ortho` the visible height of a parallel projection, or null.
// `aspect` is width / height, `extent` the diagonal of the scene's bounds.

const POLE = (89.5 / 180) * Math.PI;
const clamp = (x, lo, hi) => Math.min(Math.max(x, lo), hi);
const add = (a, b) => a.map((x, k) => x + b[k]);
const sub = (a, b) => a.map((x, k) => x - b[k]);
const scaled = (a, factor) => a.map((x) => x * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [1, 2, 0].map((j, i) => a[j] * b[3 - i - j] - a[3 - i - j] * b[j]);
const norm = (a) => Math.hypot(...a);
const unit = (a) => scaled(a, 1 / norm(a));
const sameVector = (a, b) => norm(sub(a, b)) < 1e-6;
const sameView = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const diagonal = ([lo, hi]) => norm(sub(hi, lo));
const distance = (view) => norm(sub(view.eye, view.center));
const slope = (view) => Math.tan((view.fovy * Math.PI) / 360);
const visibleHeight = (view) => view.ortho ?? 2 * distance(view) * slope(view);

function axes(view) {
  const back = unit(sub(view.eye, view.center));
  const right = unit(cross(view.up, back));
  return { right, up: cross(back, right), back };
}
// `offset` turned about `axis` by `turn` and raised by `tilt` (radians), short of the poles.
function turned(offset, axis, turn, tilt) {
  const up = unit(axis);
  const height = dot(offset, up);
  let level = sub(offset, scaled(up, height));
  const elevation = clamp(Math.atan2(height, norm(level)) + tilt, -POLE, POLE);
  if (norm(level) < 1e-9 * norm(offset)) level = cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  level = unit(level);
  const ahead = add(scaled(level, Math.cos(turn)), scaled(cross(up, level), Math.sin(turn)));
  return scaled(add(scaled(ahead, Math.cos(elevation)), scaled(up, Math.sin(elevation))), norm(offset));
}
function orbited(view, turn, tilt) {
  return { ...view, eye: add(view.center, turned(sub(view.eye, view.center), view.up, turn, tilt)) };
}
function looked(view, turn, tilt) {
  return { ...view, center: add(view.eye, turned(sub(view.center, view.eye), view.up, turn, tilt)) };
}
const withUp = (view, up) => orbited({ ...view, up }, 0, 0);
const shifted = (view, by) => ({ ...view, eye: add(view.eye, by), center: add(view.center, by) });
const atDistance = (view, center, d) => ({ ...view, center, eye: add(center, scaled(axes(view).back, d)) });
// The scene follows the pointer: dx and dy are shares of the picture's height.
function panned(view, dx, dy) {
  const { right, up } = axes(view);
  return shifted(view, scaled(sub(scaled(up, dy), scaled(right, dx)), visibleHeight(view)));
}
// Multiplies the distance, or the height of a parallel view.
function dollied(view, factor, extent) {
  const limited = (x) => clamp(x * factor, Math.min(x, extent * 1e-5), Math.max(x, extent * 1e3));
  if (view.ortho !== null) return { ...view, ortho: limited(view.ortho) };
  return atDistance(view, view.center, limited(distance(view)));
}
// Moves by [right, up, ahead], in units of the distance of eye and centre. Ahead magnifies a parallel view.
function flown(view, [x, y, z], extent) {
  if (view.ortho !== null && z) return dollied(flown(view, [x, y, 0], extent), Math.exp(-z), extent);
  const { right, back } = axes(view);
  const by = sub(add(scaled(right, x), scaled(unit(view.up), y)), scaled(back, z));
  return shifted(view, scaled(by, view.ortho ?? distance(view)));
}
// Looks at `center` in the same direction from where all of `bounds` is visible.
function framed(view, bounds, aspect, center = scaled(add(...bounds), 0.5)) {
  const { right, up, back } = axes(view);
  let [far, height, depth] = [0, 0, 0];
  for (let corner = 0; corner < 8; corner++) {
    const offset = center.map((x, k) => bounds[(corner >> k) & 1][k] - x);
    const half = Math.max(Math.abs(dot(offset, up)), Math.abs(dot(offset, right)) / aspect) * 1.04;
    depth = Math.max(depth, dot(offset, back));
    height = Math.max(height, 2 * half);
    far = Math.max(far, half / slope(view) + dot(offset, back));
  }
  if (view.ortho === null) return atDistance(view, center, far || distance(view));
  return { ...atDistance(view, center, depth + height || distance(view)), ortho: height || view.ortho };
}
// Centres on a point that was hit, and goes near the geometry it belongs to. Half way is near enough where
// that is most of the scene, or fills the picture already.
function framedPoint(view, point, bounds, scene, aspect) {
  const depth = dot(sub(view.eye, point), axes(view).back);
  const near = framed(view, bounds, aspect, point);
  const height = view.ortho ?? 2 * depth * slope(view);
  if (diagonal(bounds) < diagonal(scene) / 2 && visibleHeight(near) < height) return near;
  return { ...atDistance(view, point, view.ortho ? depth : depth / 2), ortho: view.ortho && view.ortho / 2 };
}
// Takes `axis` as the up vector if the picture stays the same: cameras of files are often tilted, but level.
function straightened(view, axis) {
  const { right, up, back } = axes(view);
  const level = Math.abs(dot(right, axis)) < 1e-4 && dot(up, axis) > 0 && Math.abs(dot(back, axis)) < 0.9999;
  return level ? { ...view, up: axis } : view;
}
// Changes the projection; sizes at the centre stay.
function withProjection(view, parallel) {
  if (parallel) return { ...view, ortho: visibleHeight(view) };
  return { ...atDistance(view, view.center, visibleHeight(view) / 2 / slope(view)), ortho: null };
}
// Pixel of a point in a picture of `size`, or null behind the eye.
function projected(view, point, [width, height]) {
  const { right, up, back } = axes(view);
  const offset = sub(point, view.eye);
  const depth = -dot(offset, back);
  const pixels = height / (view.ortho ?? 2 * depth * slope(view));
  return depth > 0 ? [width / 2 + dot(offset, right) * pixels, height / 2 - dot(offset, up) * pixels] : null;
}
// Seven digits of the distance (or height) are enough for a pixel, and a command of them can be read.
function rounded(view) {
  const to = (digits) => (x) => Number(x.toFixed(clamp(digits, 0, 100))) + 0;
  const digits = 6 - Math.floor(Math.log10(Math.min(distance(view), view.ortho ?? Infinity)));
  const [eye, center] = [view.eye, view.center].map((point) => point.map(to(digits)));
  const ortho = view.ortho && Number(view.ortho.toPrecision(7));
  return { eye, center, up: unit(view.up).map(to(7)), fovy: to(4)(view.fovy), ortho };
}

function toFragment(view, mode) {
  const fields = Object.entries({ mode, ...view }).filter(([, value]) => value !== null);
  return `#${fields.map(([name, value]) => `${name}=${value}`).join('&')}`;
}
// {view, mode} of a fragment; the view is null unless it is complete and has axes.
function fromFragment(fragment) {
  const fields = new URLSearchParams(fragment.slice(1));
  const [eye, center, up, [fovy], [ortho]] = ['eye', 'center', 'up', 'fovy', 'ortho'].map((name) =>
    (fields.get(name) || 'NaN').split(',').map(Number),
  );
  const view = { eye, center, up, fovy, ortho: ortho > 0 ? ortho : null };
  const complete = [eye, center, up].every((vector) => vector.length === 3) && fovy > 0 && fovy < 180;
  return { view: complete && axes(view).up.every(Number.isFinite) ? view : null, mode: fields.get('mode') };
}
function keyframeText(keyframes) {
  const line = ({ frame, view }) => [frame, ...view.eye, ...view.center, ...view.up, view.fovy].join(' ');
  return ['# frame, eye, center, up, fovy', ...keyframes.map(line), ''].join('\n');
}
