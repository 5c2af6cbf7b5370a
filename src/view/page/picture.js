// The picture: asks for frames, draws them, and keeps count. A change of view, mode or size is followed by
// frames as fast as they come, and after a rest by better and better pictures of the full size.

const $ = (id) => document.getElementById(id);
const MAX_PIXELS = 4e6;
const GONE = 'The program does not answer: it has ended, or the connection is cut. Trying again…';
const REST_MS = 120;
const [stage, canvas] = [$('stage'), $('picture')];
const context = canvas.getContext('2d', { alpha: false });
// `version` counts changes of what is to be seen: `sent` is the one last asked for, `drawn` the one last
// drawn, `changed` the time of the last. `cause` is the time of the input that the next request answers,
// `refining` the AbortController of one at rest. `settled`: it was the last one; `lost`: the program is gone.
const picture = { version: 0, sent: 0, drawn: 0, changed: 0, cause: null, lost: false };
Object.assign(picture, { refining: null, samples: 0, settled: false });
const flights = new Set(); // AbortControllers of requests while moving
const times = []; // when recent frames were drawn while moving
const latencies = []; // ms from recent inputs to their frames
const waiting = []; // resolved when settled
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const target = () => (['shaded', 'ao'].includes(app.mode) ? app.scene.samples : 1);
const subject = () => ({ view: app.view, size: app.size, mode: app.mode, exposure: app.exposure, tone: app.tone });
const aspect = () => app.size[0] / app.size[1];
const isResting = () => !flights.size && picture.version === picture.sent && !pointers.size;
// The picture must change. `cause` is the time of the input; `afresh` drops what is on its way.
function outdate(cause = null, afresh = false) {
  picture.refining?.abort();
  Object.assign(picture, { refining: null, samples: 0, settled: false, changed: performance.now() });
  picture.version++;
  picture.cause = cause ?? picture.cause;
  hideReadout();
  if (afresh) flights.forEach((flight) => flight.abort() ?? flights.delete(flight));
  pump();
}
// Asks for what is due now, or waits until something is.
function pump() {
  clearTimeout(picture.timer);
  if (!app.size || document.hidden || picture.lost) return;
  if (picture.version !== picture.sent && flights.size < server.plan().flights) advance();
  const rest = picture.changed + REST_MS - performance.now();
  if (rest > 0) picture.timer = setTimeout(pump, rest);
  else if (!flights.size && !picture.refining && !picture.settled) refine();
}
// One frame while moving.
async function advance() {
  const flight = new AbortController();
  const { version, cause } = picture;
  const { jpeg, pixels } = server.plan();
  Object.assign(picture, { sent: version, cause: null });
  flights.add(flight);
  const request = { ...subject(), moving: true, pixels, have: 0, samples: 1, jpeg };
  const answer = await server.frame(request, flight.signal).catch(failed);
  if (answer && flights.has(flight) && version >= picture.drawn) draw(answer, version, cause);
  flights.delete(flight);
  pump();
}
// Draws better pictures until the samples are complete. The last one is exact: not a JPEG.
async function refine() {
  const refining = (picture.refining = new AbortController());
  const { version } = picture;
  for (let exact = false, misses = 0; picture.samples < target() || !exact; ) {
    const jpeg = picture.samples < target() && server.plan().jpeg;
    const have = Math.min(picture.samples, target() - 1);
    const request = { ...subject(), moving: false, pixels: MAX_PIXELS, have, samples: target(), jpeg };
    const answer = await server.frame(request, refining.signal).catch(failed);
    if (picture.refining !== refining) return;
    if (!answer && ++misses > 5) break;
    if (!answer) await pause(200);
    else [picture.samples, exact] = [draw(answer, version, null).samples, !jpeg];
  }
  Object.assign(picture, { refining: null, settled: true });
  announce(`${MODES[app.mode]}, ${picture.samples} of ${target()} samples`);
  waiting.splice(0).forEach((resolve) => resolve());
}
// A busy program is asked again; one that refuses, after the next change; one that is gone, until it is back.
function failed({ name, status, message }) {
  if (name === 'AbortError') return;
  picture.refining = null;
  if (status === 429 || status === 503) setTimeout(pump, 1000);
  else if (status !== undefined) picture.settled = true;
  warn(status === undefined ? GONE : (app.scene.warning ?? message));
  if (status !== undefined || picture.lost) return;
  picture.lost = true;
  setTimeout(retry, 2000);
}
async function retry() {
  const state = document.hidden ? null : await server.state().catch(({ status, message }) => status && warn(message));
  if (!state) return setTimeout(retry, 2000);
  Object.assign(picture, { lost: false, sent: -1, settled: false });
  pump();
}

function draw({ info, image }, version, cause) {
  if (canvas.width !== info.width) canvas.width = info.width;
  if (canvas.height !== info.height) canvas.height = info.height;
  if (image instanceof ImageData) context.putImageData(image, 0, 0);
  else context.drawImage(image, 0, 0);
  image.close?.();
  const now = performance.now();
  if (info.moving) times.splice(0, Infinity, ...times.filter((time) => now - time < 1000), now);
  if (cause !== null) latencies.push(now - cause);
  if (latencies.length > 500) latencies.shift();
  picture.drawn = version;
  phalanx.frame = info;
  warn('');
  showFigures();
  return info;
}

const fps = () => (times.length > 1 ? ((times.length - 1) * 1000) / (times.at(-1) - times[0]) : null);
function latency() {
  const sorted = [...latencies].sort((a, b) => a - b);
  const [median, p99] = [0.5, 0.99].map((share) => sorted[Math.ceil(share * sorted.length) - 1] ?? null);
  return { median, p99, count: sorted.length };
}
// The size is the element's in the screen's pixels, or the scene's own between margins.
function resize() {
  const { width, height } = stage.getBoundingClientRect();
  if (!app.scene || !width || !height) return;
  const most = Math.min(MAX_PIXELS, app.scene.most_pixels);
  const ratio = Math.min(window.devicePixelRatio, Math.sqrt(most / (width * height)));
  const fixed = app.scene.size;
  const size = fixed ?? [width, height].map((x) => Math.max(1, Math.floor(x * ratio)));
  const fit = Math.min(width / size[0], height / size[1]);
  const box = fixed ? scaled(fixed, fit) : [width, height];
  Object.assign(canvas.style, { width: `${box[0]}px`, height: `${box[1]}px` });
  if (String(size) !== String(app.size)) {
    app.size = size;
    outdate(null, true);
  }
  showMarker();
}
new ResizeObserver(resize).observe(stage);
window.addEventListener('resize', resize);
document.onvisibilitychange = () => (document.hidden && !picture.settled ? outdate(null, true) : pump());
