// Gestures on the picture, and the keys.

const FLY = { KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0] };
Object.assign(FLY, { KeyQ: [0, -1, 0], ArrowUp: FLY.KeyW, ArrowDown: FLY.KeyS });
Object.assign(FLY, { ArrowLeft: FLY.KeyA, ArrowRight: FLY.KeyD });
const KEYS = { f: 'all', h: 'toggle', '?': 'keys' };
const CLICK_PIXELS = 4;
const DOUBLE_CLICK_MS = 400;
const pointers = new Map();
const fly = { on: false, held: new Set(), fast: false, last: 0, gesture: null };
let drag = { moved: 0, pan: false };
let wheel = { last: 0 };
// Middle of the pointers, and the distance between two.
function spread() {
  const [a, b = a] = pointers.values();
  return { x: (a[0] + b[0]) / 2, y: (a[1] + b[1]) / 2, gap: Math.hypot(a[0] - b[0], a[1] - b[1]) };
}
// Pixel of the picture below an event, or null.
function pixelAt(event) {
  const box = canvas.getBoundingClientRect();
  const share = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  const inside = app.size && !event.target.closest('button') && share.every((x) => x >= 0 && x < 1);
  return inside ? share.map((x, k) => Math.floor(x * app.size[k])) : null;
}

function turn(dx, dy, gesture, cause) {
  const [x, y] = [dx, dy].map((pixels) => (pixels * Math.PI) / stage.clientHeight);
  const view = straightened(app.view, app.axis);
  move(fly.on ? looked(view, -x / 2, -y / 2) : orbited(view, -x, y), gesture, cause);
}
function dolly(factor, gesture, cause) {
  move(dollied(app.view, factor, diagonal(app.scene.bounds)), gesture, cause);
}

stage.onpointerdown = (event) => {
  if (!app.size || event.target.closest('button')) return;
  stage.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  drag = { moved: pointers.size > 1 ? CLICK_PIXELS : 0, pan: event.shiftKey || event.button > 0 };
};
stage.onpointermove = (event) => {
  if (!pointers.has(event.pointerId)) return hover(event);
  const before = spread();
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  const after = spread();
  const [dx, dy] = [after.x - before.x, after.y - before.y];
  drag.moved += Math.hypot(dx, dy) + Math.abs(after.gap - before.gap);
  if (drag.moved < CLICK_PIXELS) return;
  if (pointers.size === 1 && !drag.pan) return turn(dx, dy, drag, event.timeStamp);
  move(panned(app.view, dx / canvas.clientHeight, dy / canvas.clientHeight), drag, event.timeStamp);
  if (before.gap && after.gap) dolly(before.gap / after.gap, drag, event.timeStamp);
};
// A click pins its pixel, once it cannot become a double click.
stage.onpointerup = stage.onpointercancel = (event) => {
  const down = pointers.delete(event.pointerId);
  const [pixel, { version }] = [pixelAt(event), picture];
  if (!down || !pixel || event.type !== 'pointerup' || drag.moved >= CLICK_PIXELS || drag.pan) return;
  later('click', DOUBLE_CLICK_MS, () => version === picture.version && pin(pixel));
};

stage.ondblclick = async (event) => {
  clearTimeout(timers.click);
  const pixel = pixelAt(event);
  const answer = pixel && (await ask(server.pixel(atPixel(pixel, true))));
  if (!answer?.hit) return;
  move(framedPoint(app.view, answer.hit.position, answer.bounds, app.scene.bounds, aspect()));
};
stage.onpointerleave = hideReadout;
stage.oncontextmenu = (event) => event.preventDefault();
stage.onmousedown = (event) => event.button !== 1; // the middle button does not scroll
const onWheel = (event) => {
  event.preventDefault();
  if (!app.size) return;
  if (event.timeStamp - wheel.last > 500) wheel = {};
  wheel.last = event.timeStamp;
  const pixels = clamp(event.deltaY * [1, 30, 300][event.deltaMode], -300, 300);
  dolly(Math.exp(pixels * (event.ctrlKey ? 0.01 : 0.0015)), wheel, event.timeStamp);
};
stage.addEventListener('wheel', onWheel, { passive: false });

function setFlying(on) {
  fly.on = on;
  fly.held.clear();
  showControls();
}
function hold(code) {
  if (!fly.on) setFlying(true);
  if (!fly.held.size) requestAnimationFrame(flyOn);
  if (!fly.held.size) Object.assign(fly, { last: performance.now(), gesture: {} });
  fly.held.add(code);
}
function flyOn(now) {
  if (!fly.held.size) return;
  const step = 0.0006 * clamp(now - fly.last, 0, 100) * (fly.fast ? 4 : 1);
  const direction = [...fly.held].map((code) => FLY[code]).reduce(add);
  fly.last = now;
  move(flown(app.view, scaled(direction, step), diagonal(app.scene.bounds)), fly.gesture);
  requestAnimationFrame(flyOn);
}

document.onkeydown = (event) => {
  const { code, target, shiftKey, timeStamp } = event;
  const key = event.key.toLowerCase();
  const mode = MODE_NAMES[Number(key) - 1];
  const writes = target.matches('select, textarea, [type=number]') && key !== 'escape';
  const arrows = code.startsWith('Arrow');
  const [x, , z] = FLY[code] ?? [];
  fly.fast = shiftKey;
  if (!app.size || $('help').open || writes || (arrows && ![stage, document.body].includes(target)) || event.altKey) return;
  if (event.ctrlKey || event.metaKey) {
    if (key !== 'z') return;
    ACTIONS[shiftKey ? 'redo' : 'undo']();
  } else if (FLY[code] && (fly.on || !arrows)) hold(code);
  else if (arrows && shiftKey) move(panned(app.view, -x * 0.05, z * 0.05), 'keys', timeStamp);
  else if (arrows) turn(x * 24, -z * 24, 'keys', timeStamp);
  else if (key === 'enter' && target === stage) pin(app.size.map((x) => Math.floor(x / 2)));
  else if (mode) setMode(mode);
  else if (key === 'escape') phalanx.pinned ? ACTIONS.unpin() : setFlying(false);
  else if (key === '+' || key === '-') dolly(key === '+' ? 0.9 : 1 / 0.9, 'keys');
  else if (KEYS[key]) ACTIONS[KEYS[key]]();
  else return;
  event.preventDefault();
};
document.onkeyup = (event) => {
  fly.fast = event.shiftKey;
  event.metaKey ? fly.held.clear() : fly.held.delete(event.code);
  if (app.gesture === 'keys') app.gesture = null;
};
window.onblur = () => fly.held.clear();
