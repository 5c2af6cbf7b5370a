// The program's answers. No other file knows that they come over a network.

const server = (() => {
  const TRANSFER_MS = 40; // of a frame while moving, at most
  const DECODE_MS = 1e-5; // of a pixel of a JPEG
  const RESTARTED = 'The program was started again: open its new address.';
  const page = crypto.getRandomValues(new BigUint64Array(1))[0].toString(16).padStart(16, '0');
  let open = 0; // frames in flight
  let roundTrips = [0]; // recent ones, in ms, without the work
  let work = 20; // ms of a frame while moving
  let throughput = 20e3; // bytes per ms
  const jpeg = { bytes: 0.4, ms: 1e-5 }; // per pixel

  const smoothed = (old, now) => old + 0.3 * (now - old);
  const json = (body) => JSON.stringify({ page, ...body });
  async function post(path, body, signal) {
    const headers = { 'Content-Type': 'application/json' };
    const response = await fetch(path, { method: 'POST', headers, body: json(body), signal });
    if (response.ok) return response;
    const { error } = await response.json().catch(() => ({}));
    const reason = response.status === 404 ? RESTARTED : (error ?? 'The request failed.');
    throw Object.assign(new Error(reason), { status: response.status });
  }
  async function frame(request, signal, alone) {
    const begin = performance.now();
    const response = await post('frame', request, signal);
    if (response.status === 204) return null;
    const first = performance.now();
    const info = JSON.parse(response.headers.get('Frame'));
    const raw = !response.headers.get('Content-Type').includes('jpeg');
    const body = await (raw ? response.arrayBuffer() : response.blob());
    const [bytes, pixels] = [body.byteLength ?? body.size, info.width * info.height];
    const busy = info.ms + info.encode_ms;
    // Only a frame that did not wait behind others tells how long the way is.
    if (alone && info.moving) roundTrips = [...roundTrips.slice(-7), Math.max(0, first - begin - busy)];
    if (info.moving) work = smoothed(work, busy);
    if (bytes >= 64e3) throughput = smoothed(throughput, bytes / Math.max(performance.now() - first, 0.1));
    if (raw) return { info, image: new ImageData(new Uint8ClampedArray(body), info.width, info.height) };
    jpeg.bytes = smoothed(jpeg.bytes, bytes / pixels);
    jpeg.ms = smoothed(jpeg.ms, info.encode_ms / pixels);
    return { info, image: await createImageBitmap(body) };
  }

  return {
    // How to ask for frames while moving: how many at once, in which format, and of how many pixels at most.
    plan() {
      const raw = 4 / throughput <= jpeg.bytes / throughput + jpeg.ms + DECODE_MS;
      const pixels = Math.round((throughput * TRANSFER_MS) / (raw ? 4 : jpeg.bytes));
      const flights = Math.round(1 + Math.min(...roundTrips) / Math.max(work, 1));
      return { flights: clamp(flights, 1, 4), jpeg: !raw, pixels: clamp(pixels, 3e4, 4e6) };
    },
    // {info, image} of the next picture, or null if there is none.
    frame: (request, signal) => frame(request, signal, open++ === 0).finally(() => open--),
    state: async () => (await post('state')).json(),
    pixel: async (request) => (await post('pixel', request)).json(),
    command: async (request) => (await (await post('command', request)).json()).command,
    exposure: async (request) => (await (await post('exposure', request)).json()).exposure,
    async save(request) {
      const response = await post('save', request);
      const name = /filename="([^"]+)"/.exec(response.headers.get('Content-Disposition') ?? '');
      return { name: name?.[1] ?? 'picture.png', blob: await response.blob() };
    },
    leave: () => navigator.sendBeacon('leave', new Blob([json()], { type: 'application/json' })),
  };
})();
