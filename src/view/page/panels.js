// The controls, the figures below the picture, and the pixels that are looked at.

const MODES = { shaded: 'Shaded', ao: 'Ambient occlusion', normals: 'Normals', depth: 'Depth' };
Object.assign(MODES, { albedo: 'Albedo', primitives: 'Primitives', materials: 'Materials', cost: 'Cost' });
const MODE_NAMES = Object.keys(MODES);
const LEGENDS = { depth: 'Depth: distance along the ray', cost: 'Cost: BVH nodes visited' };
const KINDS = ['primary', 'shadow', 'reflection', 'refraction'];
const FACTS = 'object material primitive geometry material_id t u v position normal face_normal albedo'.split(' ');
const PLACES = ['position', 'origin', 'bounds'];
const READOUT_MS = 80;
const FIGURES_MS = 120; // what changes faster cannot be read
const decimal = (x, digits = 1) => (Number.isFinite(x) ? x.toFixed(digits) : '–');
const short = (x) => String(Number(x.toPrecision(6)));
const rate = (count, { ms }) => decimal(count / ms / 1000);
// Name, meaning and value of each figure.
const FIGURES = [
  ['frames/s', 'Frames per second, while moving', () => decimal(fps(), 0)],
  ['Mrays/s', 'Million rays per second', (f) => rate(Object.values(f.rays).reduce((a, b) => a + b, 0), f)],
  ...KINDS.map((kind) => [kind, `Million ${kind} rays per second`, (f) => rate(f.rays[kind] || NaN, f)]),
  ['trace ms', 'Traversal and intersection, per thread', (f) => decimal(f.trace_ms)],
  ['shade ms', 'Shading, per thread', (f) => decimal(f.shade_ms)],
  ['latency ms', 'From an input to its picture, median', () => decimal(latency().median, 0)],
  ['size', 'Pixels of the picture shown', (f) => `${f.width}×${f.height}`],
  ['samples', 'Samples per pixel, and where refinement stops', (f) => `${f.samples}/${target()}`],
  ['bounces', 'Bounces traced', (f) => f.max_depth],
  ['threads', 'Threads of the program', () => app.scene.threads],
  ['kernel', 'Intersection kernel', (f) => f.kernel],
];
// An element with properties and children; text only ever gets in as text.
function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}
const term = ([name, text, title = '']) =>
  element('div', { title }, element('dt', {}, name), element('dd', {}, text));
function buildPanels() {
  const { scene } = app;
  $('name').textContent = document.title = scene.name;
  const count = scene.primitives.toLocaleString('en');
  $('facts').textContent = `${count} primitives · ${scene.engine}, ${scene.isa} · phalanx ${scene.version}`;
  const option = (value, text = value) => element('option', { value }, text);
  const cameras = scene.cameras.map(({ name }, k) => option(k, name ?? `Camera ${k + 1}`));
  $('camera').append(option('start', 'first view'), ...cameras);
  const own = Object.keys(UP).find((name) => sameVector(UP[name], app.ups.file)) ?? 'other';
  $('axis').append(option('file', `file: ${own}`), ...Object.keys(UP).map((name) => option(name)));
  const radio = (value) => element('input', { type: 'radio', name: 'mode', value, id: `mode-${value}` });
  const key = (k) => element('span', { ariaHidden: 'true' }, String(k + 1));
  $('modes').append(...MODE_NAMES.map((mode, k) => element('label', {}, radio(mode), MODES[mode], key(k))));
  $('figures').append(...FIGURES.map(([name, meaning]) => term([name, '–', meaning])));
}
// Makes the controls say what is shown.
function showControls() {
  const { view, views, ups } = app;
  $('camera').value = Object.keys(views).find((name) => sameView(views[name], view)) ?? '';
  $('axis').value = Object.keys(ups).find((name) => sameVector(ups[name], unit(view.up))) ?? '';
  $('parallel').checked = view.ortho !== null;
  $('fov').value = $('degrees').value = Number(view.fovy.toFixed(2));
  for (const id of ['fov', 'degrees', 'add']) $(id).disabled = view.ortho !== null;
  $('stops').value = app.exposure;
  $('neutral').checked = app.tone === 'neutral';
  $(`mode-${app.mode}`).checked = true;
  $('undo').disabled = !app.past.length;
  $('redo').disabled = !app.future.length;
  $('fly').ariaPressed = fly.on;
}

function showFigures() {
  timers.figures ||= setTimeout(() => {
    timers.figures = 0;
    const fields = $('figures').querySelectorAll('dd');
    FIGURES.forEach(([, , value], k) => (fields[k].textContent = value(phalanx.frame)));
    Object.assign(phalanx, { fps: fps(), latency: latency() });
    const { scale } = phalanx.frame;
    $('legend').hidden = !LEGENDS[app.mode] || scale === null;
    if ($('legend').hidden) return;
    $('legend-title').textContent = LEGENDS[app.mode];
    $('legend-middle').textContent = short(scale / 2);
    $('legend-most').textContent = `≥ ${short(scale)}`;
  }, FIGURES_MS);
}

const atPixel = ([x, y], bounds = false) => ({ view: app.view, size: app.size, x, y, bounds });
// One question at a time, about the pixel pointed at last.
const readout = { busy: false, at: null };
async function hover(event) {
  readout.event = event;
  readout.at = isResting() && event.pointerType !== 'touch' ? pixelAt(event) : null;
  if (!readout.at) return hideReadout();
  if (readout.busy) return;
  readout.busy = true;
  await pause(READOUT_MS);
  const [{ at }, { version }] = [readout, picture];
  const answer = at && (await server.pixel(atPixel(at)).catch(() => null));
  readout.busy = false;
  if (!answer || !readout.at || version !== picture.version) return;
  const { hit } = answer;
  const names = hit && [hit.object, hit.material].filter((name) => name !== null).join(' · ');
  const where = hit && `\nprimitive ${hit.primitive}   t ${short(hit.t)}\n${valueText(hit.position, coordinate)}`;
  $('readout').textContent = hit ? (names || 'unnamed') + where : 'background';
  $('readout').hidden = false;
  if (String(at) !== String(readout.at)) hover(readout.event);
}
function hideReadout() {
  readout.at = null;
  $('readout').hidden = true;
}
// Six digits of a coordinate, or to a millionth of the scene where it lies far from its origin.
function coordinate(x) {
  const beyond = Math.ceil(Math.log10(Math.abs(x) / diagonal(app.scene.bounds)));
  return String(Number(x.toPrecision(clamp(6 + beyond, 6, 17))));
}
// Text of a value of an answer: a number, a vector, bounds, or a name.
function valueText(value, text = short) {
  const parts = (between) => value.map((part) => valueText(part, text)).join(between);
  if (Array.isArray(value)) return parts(Array.isArray(value[0]) ? '\n' : '  ');
  return typeof value === 'number' && !Number.isInteger(value) ? text(value) : String(value ?? '–');
}

async function pin(pixel) {
  const { view } = app;
  const answer = await ask(server.pixel(atPixel(pixel, true)));
  if (!answer) return;
  phalanx.pinned = answer;
  app.pin = { view, share: pixel.map((x, k) => (x + 0.5) / app.size[k]) };
  const { hit, passed, ...rest } = answer;
  const textOf = (name) => (PLACES.includes(name) ? coordinate : short);
  const field = ([name, value]) => term([name.replace('_', ' '), valueText(value, textOf(name))]);
  const place = ([name]) => (FACTS.includes(name) ? FACTS.indexOf(name) : FACTS.length);
  const sorted = (fields) => Object.entries(fields).sort((a, b) => place(a) - place(b));
  const list = (fields) => element('dl', {}, ...sorted(fields).map(field));
  const surface = (fields, k) => [element('h3', {}, `Passed surface ${k + 1}`), list(fields)];
  const all = { ...(hit ?? { hit: 'background' }), ...rest };
  $('pixel-facts').replaceChildren(list(all), ...passed.flatMap(surface));
  $('pixel').hidden = false;
  if ($('panel').hidden) ACTIONS.toggle();
  $('panel').scrollTop = 0;
  showMarker();
  announce(`Pixel ${pixel.join(', ')} pinned`);
}
// The marker stays at the point that was hit when the view changes.
function showMarker() {
  const { hit } = phalanx.pinned ?? {};
  const box = [canvas.clientWidth, canvas.clientHeight];
  let at = app.pin && sameView(app.pin.view, app.view) ? app.pin.share.map((x, k) => x * box[k]) : null;
  if (hit) at ??= projected(app.view, hit.position, box);
  $('marker').toggleAttribute('hidden', !at);
  const corner = [canvas.offsetLeft, canvas.offsetTop];
  if (at) $('marker').style.translate = at.map((x, k) => `${corner[k] + x}px`).join(' ');
}
