// The page: what is shown, how it changes, and the start.

const UP = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
for (const [name, axis] of Object.entries(UP)) UP[`-${name}`] = axis.map((x) => 0 - x);
const STAGES = { reading: 'Reading the scene', building: 'Building the BVH', failed: 'No scene to show' };
const UNDO_STEPS = 500;
const timers = {};
// `size` is that of the resting picture, once there is a scene; `views` and `ups` have the names of options;
// `pin` is the view and the place of the pinned pixel; `gesture` is what moved the view last.
const app = { scene: null, view: null, mode: 'shaded', size: null, views: {}, ups: {}, axis: null };
Object.assign(app, { pin: null, past: [], future: [], gesture: null });
function later(name, ms, action) {
  clearTimeout(timers[name]);
  timers[name] = setTimeout(action, ms);
}
// A note that anybody may miss, for four seconds.
function say(text) {
  $('say').textContent = text;
  later('say', 4000, () => ($('say').textContent = ''));
}
// A note for screen readers, once nothing has changed for a second.
const announce = (text) => later('announce', 1000, () => ($('live').textContent = text));
// A problem, until a picture comes.
const warn = (text) => ($('warning').textContent = text);
// The answer to a request, or nothing after saying why.
const ask = (request) =>
  request.catch((error) => say(error.status ? error.message : 'The program does not answer.'));

function show(view, cause = null, afresh = false) {
  app.view = view;
  outdate(cause, afresh);
  showControls();
  showMarker();
  keepLink();
}
// Goes to a view as it is. A gesture, however many moves it has, is one entry to undo.
function jump(view, gesture = {}, cause = null) {
  if (sameView(view, app.view)) return;
  if (gesture !== app.gesture) app.past = [...app.past.slice(-UNDO_STEPS), app.view];
  Object.assign(app, { gesture, future: [] });
  show(view, cause);
}
const move = (view, gesture, cause) => jump(rounded(view), gesture, cause);
function undo(from, to) {
  if (!from.length) return;
  to.push(app.view);
  app.gesture = null;
  show(from.pop());
}
function setMode(mode) {
  if (mode === app.mode) return;
  app.mode = mode;
  show(app.view, null, true);
  announce(MODES[mode]);
}
// Changes what comes after the light: the samples stay.
function expose(exposure, tone = app.tone) {
  Object.assign(app, { exposure, tone });
  show(app.view);
  announce(`Exposure ${short(exposure)}, tone ${tone}`);
}
// What the buttons do.
const ACTIONS = {
  all: () => move(framed(app.view, app.scene.bounds, aspect())),
  fly: () => setFlying(!fly.on),
  undo: () => undo(app.past, app.future),
  redo: () => undo(app.future, app.past),
  keys: () => $('help').showModal(),
  close: () => $('help').close(),
  toggle: () => ($('toggle').ariaExpanded = !($('panel').hidden = !$('panel').hidden)),
  async meter() {
    const stops = await ask(server.exposure(job(false)));
    if (stops !== undefined) expose(stops);
  },
  copy: () => copyCommand(false),
  save,
  link: () => copy(link(), 'Link'),
  add: () => setKeyframes([...keyframes, { frame: nextFrame(), view: app.view }]),
  download: () => download('views.txt', new Blob([keyframeText(keyframes)], { type: 'text/plain' })),
  'copy-sequence': () => copyCommand(true),
  'copy-pixel': () => copy(JSON.stringify(phalanx.pinned, null, 2), 'Pixel'),
  unpin() {
    app.pin = phalanx.pinned = null;
    $('pixel').hidden = true;
    showMarker();
  },
};
for (const [id, action] of Object.entries(ACTIONS)) $(id).onclick = () => app.size && action();
$('fov').oninput = () => move({ ...app.view, fovy: $('fov').valueAsNumber }, 'slider');
$('fov').onchange = () => (app.gesture = null);
$('degrees').onchange = ({ target }) => {
  if (target.value && target.validity.valid) move({ ...app.view, fovy: target.valueAsNumber });
};
$('stops').onchange = ({ target }) => {
  if (target.value && target.validity.valid) expose(target.valueAsNumber);
};
$('neutral').onchange = ({ target }) => expose(app.exposure, target.checked ? 'neutral' : 'linear');
$('modes').onchange = (event) => setMode(event.target.value);
$('axis').onchange = () => move(withUp(app.view, (app.axis = app.ups[$('axis').value])));
$('camera').onchange = () => jump(app.views[$('camera').value]);
$('parallel').onchange = () => move(withProjection(app.view, $('parallel').checked));
document.onchange = ({ target }) => {
  // Keys work on the picture again after a choice with the pointer.
  if (target.matches('select, [type=radio]') && !target.matches(':focus-visible')) stage.focus();
};
// Takes the mode of the address, and returns its view.
function readLink() {
  const { view, mode } = fromFragment(location.hash);
  if (Object.hasOwn(MODES, mode)) app.mode = mode;
  return view;
}

function begin(scene) {
  app.ups = { file: unit(scene.up), ...UP };
  app.views = { start: scene.view, ...scene.cameras.map(({ view }) => view) };
  Object.assign(app, { exposure: scene.exposure, tone: scene.tone });
  Object.assign(app, { scene, axis: app.ups.file, view: readLink() ?? scene.view });
  buildPanels();
  [$('overlay').hidden, $('panel').hidden] = [true, false];
  showControls();
  resize();
  window.onhashchange = () => jump(readLink() ?? app.view);
  stage.focus({ preventScroll: true });
}

async function start() {
  const state = await server.state().catch(({ message, status }) => ({ refused: status ? message : GONE }));
  warn(state.refused ?? '');
  if (state.stage === 'ready') return begin(state.scene);
  if (state.refused) return setTimeout(start, 2000);
  const count = state.primitives ? ` · ${state.primitives.toLocaleString('en')} primitives` : '';
  $('stage-name').textContent = STAGES[state.stage];
  $('stage-time').textContent = state.error ? '' : `${state.seconds.toFixed(1)} s${count}`;
  $('stage-error').textContent = state.error ?? '';
  if (state.stage !== 'failed') setTimeout(start, 200);
}
window.onpagehide = () => server.leave();
// For tests: also `frame`, information of the frame drawn last.
window.phalanx = { view: () => app.view, set: (view) => jump(view), mode: () => app.mode, frame: null };
Object.assign(phalanx, { pinned: null, fps: null, latency: latency() });
phalanx.idle = () => new Promise((resolve) => (picture.settled ? resolve() : waiting.push(resolve)));
start();
