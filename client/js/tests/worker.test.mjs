// A client's worker without a browser, in sessions with the real server: what it makes of a network that takes up nothing, of tiles
// that are damaged, and of a client core that fails. Every wait is for a condition.
import assert from 'node:assert/strict';
import { after, afterEach, before, test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { openSocket } from './socket.mjs';
import { loadModule, makeFolder, makeSceneWithPicture, openSources, startServer } from './support.mjs';

const kTest = { timeout: 180_000 };
const kRequest = {
  fov_rad: 1.05, width_px: 640, height_px: 360, tau_px: 1, strategy: 'predict', predictor: 'velocity', keyframe_ms: 100,
  occlusion: false, memory_bytes: 16 << 20, relief: true, imagery: true, tile_bytes: 64 << 20,
};
const kResume = 4, kTile = 7; // proto/message/kind.h
const real = { WebSocket: globalThis.WebSocket, self: globalThis.self, createImageBitmap: globalThis.createImageBitmap };
let folder, server, sources, module, Core, Screen;
let sockets = [];

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeSceneWithPicture(folder.folder));
  sources = await openSources();
  ({ Core } = await sources.load('core/core.ts'));
  ({ Screen } = await sources.load('core/screen.ts'));
  module = await loadModule();
}, kTest);
after(async () => {
  await sources?.close();
  await server?.stop();
  await folder?.remove();
});
afterEach(async () => {
  for (const socket of sockets.splice(0)) socket.close();
  Object.assign(globalThis, real);
});

// As a browser's. While `is_stuck` nothing goes up, and more than the page can want to send is unsent.
class Socket {
  static OPEN = 1;
  static alter = (message) => message; // what comes down
  readyState = 0;
  bufferedAmount = 0;
  sent = [];
  received = [];
  constructor(url) {
    sockets.push(this);
    this.opening = openSocket(url, (message) => this.receive(message)).then((socket) => {
      this.stream = socket;
      if (this.readyState === 0) this.readyState = 1, this.onopen();
      else void socket.close();
    });
  }
  receive(message) {
    if (this.readyState !== 1) return;
    this.received.push(Buffer.from(message));
    this.onmessage({ data: Socket.alter(message).buffer });
  }
  set is_stuck(is_stuck) {
    this.bufferedAmount = is_stuck ? 1 << 30 : 0;
  }
  send(message) {
    this.sent.push(message);
    this.stream.send(Buffer.from(message));
  }
  close() {
    if (this.readyState === 1) void this.stream.close();
    this.readyState = 3;
  }
}

// The worker, evaluated anew, as the drawing thread sees it.
async function startWorker(start = {}) {
  const listeners = { message: [] }, posted = [];
  globalThis.self = {
    addEventListener: (name, listener) => (listeners[name] ??= []).push(listener),
    postMessage: (message) => posted.push(message),
  };
  Object.assign(globalThis, { WebSocket: Socket });
  globalThis.createImageBitmap ??= async () => ({ close: () => {} });
  Socket.alter = (message) => message;
  await sources.fresh();
  await sources.load('worker/worker.ts');
  const tell = (name, event) => (globalThis.self[`on${name}`]?.(event), (listeners[name] ?? []).forEach((listener) => listener(event)));
  const say = (data) => tell('message', { data });
  const of = (kind) => posted.filter((message) => message.kind === kind);
  say({
    kind: 'start', module, server: new URL('fly', server.url).href, request: kRequest, blend: 'keyframe', wants_lines: false,
    texture_layers: { relief: 64, imagery: 256 }, clock_origin_ms: performance.timeOrigin, is_recorded: true, ...start,
  });
  return { say, tell, of, posted };
}

// Tells frames of a camera that looks down on the scene and moves, until `isDone`, a function of the last state.
async function fly(worker, isDone) {
  const screen = new Screen(await Core.of(module));
  const begun_ms = performance.now();
  let middle = null;
  for (;; await setImmediate()) {
    const state = worker.of('state').at(-1);
    if (isDone(state)) return state;
    const [welcome] = worker.of('welcome');
    if (welcome && !middle) {
      const { low, high } = screen.enter(welcome.message);
      middle = [0, 1, 2].map((i) => 0.5 * (low[i] + high[i]) + (i === 2 ? 3000 : 0));
    }
    const now_ms = performance.now();
    const eye = middle ? [middle[0] + 0.1 * (now_ms - begun_ms), middle[1], middle[2]] : [0, 0, 0];
    const staged_version = worker.of('mesh').at(-1)?.update.version ?? 0;
    worker.say({ kind: 'frame', now_ms, pose: { eye, orientation: [0, 0, 0, 1] }, eye, ground_reach: 1, staged_version });
  }
}
const hasEnded = (worker) => () => worker.of('failed').length > 0;
const imagesOf = (worker) => worker.of('mesh').flatMap(({ update }) => update.tiles.imagery?.uploads ?? []).filter(({ image }) => image);
const errorsOf = (said) => said.calls.map((call) => call.arguments[0]).filter((argument) => argument instanceof Error);

test('a program that draws no frames keeps its session, and a page that nobody sees does not', kTest, async (context) => {
  context.mock.timers.enable({ apis: ['setInterval'] });
  const worker = await startWorker();
  while (worker.of('welcome').length === 0) await setImmediate();
  context.mock.timers.tick(5000); // what was said at first
  const { length } = sockets[0].sent;
  for (let i = 1; i <= 4; ++i) {
    context.mock.timers.tick(5000);
    assert.equal(sockets[0].sent.length, length + i);
  }
  worker.say({ kind: 'hidden', is_hidden: true });
  context.mock.timers.tick(60_000);
  assert.equal(sockets[0].sent.length, length + 4);
  worker.say({ kind: 'hidden', is_hidden: false });
  worker.say({ kind: 'ground', id: 1, positions: new Float64Array([3, 4]) });
  while (worker.of('ground').length === 0) await setImmediate(); // the server took all that
  assert.equal(sockets.length, 1);
  worker.say({ kind: 'close' });
  const said = sockets[0].sent.length;
  context.mock.timers.tick(60_000);
  assert.equal(sockets[0].sent.length, said);
});

test('questions of what is seen are forgotten as they are answered', kTest, async () => {
  const { SightAsker, Sights } = await sources.load('core/sight.ts');
  const core = { exports: { foreland_cancel_request: (_, id) => cancelled.push(id), foreland_request_sight: () => ++made, foreland_request_viewshed: () => ++made,
    foreland_take_sight: () => 1, foreland_read_sight: () => 1, foreland_sight_error: () => 0 }, put: () => {}, view: () => new DataView(new ArrayBuffer(16)), copy: () => ({ buffer: reply.buffer }), textAt: () => '' };
  const cancelled = [];
  let made = 0, reply;
  const asker = new SightAsker(core, () => 1, (answer) => sights.receive(answer));
  const sights = new Sights(core, (message) => asker.handleMessage(message));
  for (let i = 0; i < 100; ++i) {
    const answer = sights.visible({ pairs: [[[0, 0, 0], [1, 1, 1]]] });
    reply = Float64Array.from([made, 0, 0, 0, 1, 1, 1, 0, 0, 0, -2]);
    asker.received(new Uint8Array());
    assert.equal((await answer)[0].hit, null);
  }
  const end = new AbortController(), viewshed = sights.viewshed({ observer: [0, 0], observer_m: 2, radius_m: 10, cell_m: 1 }, () => {}, end.signal);
  end.abort(new Error('enough'));
  await assert.rejects(viewshed, /enough/);
  assert.deepEqual(cancelled, [made]);
  assert.equal(asker.ids.size, 0);
});

test('where nothing goes up any more the session goes on over another connection', kTest, async () => {
  const worker = await startWorker();
  const { statistics: first } = await fly(worker, (state) => state?.statistics.keyframes > 5);
  sockets[0].is_stuck = true;
  await fly(worker, () => sockets[0].sent.length > 0 && worker.of('waiting').length > 0);
  sockets[0].is_stuck = false;
  const { length } = sockets[0].sent;
  const { statistics: then } = await fly(worker, (state) => state.statistics.keyframes > first.keyframes + 20);
  assert.equal(sockets[0].sent.length, length, 'the old connection is left alone');
  assert.equal(sockets.length, 2);
  assert.equal(sockets[1].sent.filter((message) => message[0] === kResume).length, 1, 'it resumes');
  assert.deepEqual([worker.of('refused'), worker.of('failed')], [[], []]);
  assert.ok(then.bytes_up > first.bytes_up);
  worker.say({ kind: 'close' });
});

// The mesh whole, and each tile in its layer, without a byte of the server's. The first mesh is of the version that was there.
test('what the drawing thread has lost is handed over again', kTest, async () => {
  const worker = await startWorker();
  globalThis.createImageBitmap = async () => ({ close: () => {} });
  const tilesOf = (meshes) => meshes.flatMap(({ update }) => ['relief', 'imagery'].flatMap((content) =>
    (update.tiles[content]?.uploads ?? []).map(({ layer }) => `${content} ${layer}`)));
  const shownBy = ({ update }) => ['relief', 'imagery'].map((content) => update.tiles[content]?.shown ?? 0);
  await fly(worker, () => worker.of('mesh').length > 15 && imagesOf(worker).length > 3);
  const before_ = worker.of('mesh').at(-1);
  worker.say({ kind: 'redraw', count: 3 });
  assert.deepEqual(worker.of('redrawn'), [{ kind: 'redrawn', count: 3 }]);
  const meshes = () => worker.posted.slice(worker.posted.findIndex(({ kind }) => kind === 'redrawn')).filter(({ kind }) => kind === 'mesh');
  assert.equal(meshes().length, 1, 'at once');
  const [{ update }] = meshes();
  assert.ok(update.terrain.is_whole && update.objects.is_whole);
  assert.equal(update.version, before_.update.version);
  assert.ok(update.terrain.channels.to_position.data.length === update.terrain.channels.to_position.size);
  await fly(worker, () => shownBy(meshes().at(-1)).every((n, i) => n >= shownBy(before_)[i]));
  assert.ok(tilesOf(meshes()).length >= Math.max(...shownBy(before_)), 'and the tiles');
  assert.ok(meshes().slice(1).every((mesh, i) => mesh.update.version > meshes()[i].update.version));
  const tiles = sockets[0].received.filter((message) => message[0] === kTile).map((message) => message.toString('base64'));
  assert.ok(tiles.length > 3);
  assert.equal(new Set(tiles).size, tiles.length, 'the server sends none of them again');
  assert.equal(sockets.length, 1);
  assert.deepEqual([worker.of('refused'), worker.of('failed')], [[], []]);
  worker.say({ kind: 'close' });
});

test('a client core that fails ends the session, and says so once', kTest, async (t) => {
  const said = t.mock.method(console, 'error', () => {}).mock;
  const worker = await startWorker({ texture_layers: { relief: 7, imagery: 7 } }); // too few: a check of the module fails
  await fly(worker, hasEnded(worker));
  const [{ failure }] = worker.of('failed');
  assert.equal(failure.part, 'core');
  assert.ok(failure.reason.length > 0);
  assert.equal(errorsOf(said).length, 1, 'it is logged once');
  assert.equal(sockets.length, 1);
  assert.equal(sockets[0].readyState, 3, 'the connection is closed');
  const { length } = worker.posted;
  let frames = 0;
  await fly(worker, () => ++frames > 50); // which are not handled
  assert.equal(worker.posted.length, length);
  worker.say({ kind: 'save recording' }); // of what led to it
  assert.ok(worker.of('recording')[0].file.size > 1000);
  assert.equal(worker.of('failed').length, 1);
});

test('a client core that does not start is told of, once', kTest, async (t) => {
  const said = t.mock.method(console, 'error', () => {}).mock;
  const empty = await WebAssembly.compile(Uint8Array.of(0, 0x61, 0x73, 0x6d, 1, 0, 0, 0)); // in place of memory that cannot be had
  const worker = await startWorker({ module: empty });
  await fly(worker, hasEnded(worker));
  assert.deepEqual(worker.of('failed').map(({ failure }) => failure.part), ['core start']);
  assert.equal(errorsOf(said).length, 1);
  assert.deepEqual(sockets, []);
});

test('a damaged image counts as missing, is said once, and the flight goes on', kTest, async (t) => {
  const said = t.mock.method(console, 'warn', () => {}).mock;
  let asked = 0;
  globalThis.createImageBitmap = async () => {
    ++asked;
    if (asked === 3 || asked === 5) throw new Error('The image is damaged.');
    return { close: () => {} };
  };
  const worker = await startWorker();
  const { statistics } = await fly(worker, (state) => asked > 8 && imagesOf(worker).length > 3 && state.statistics.keyframes > 10);
  assert.equal(statistics.damaged_tiles, 2);
  assert.equal(worker.of('damaged').length, 1);
  assert.match(worker.of('damaged')[0].what, /^imagery .*: The image is damaged\.$/);
  assert.equal(said.callCount(), 1);
  assert.deepEqual([worker.of('refused'), worker.of('failed')], [[], []]);
  worker.say({ kind: 'close' });
});

test('a browser that decodes no image flies without imagery', kTest, async (t) => {
  t.mock.method(console, 'warn', () => {});
  const worker = await startWorker();
  globalThis.createImageBitmap = undefined;
  const { statistics } = await fly(worker, (state) => state?.statistics.damaged_tiles > 4 && state.statistics.keyframes > 10);
  assert.equal(imagesOf(worker).length, 0);
  assert.ok(statistics.tiles > 4);
  assert.equal(worker.of('damaged').length, 1);
  assert.deepEqual(worker.of('failed'), []);
  worker.say({ kind: 'close' });
});

test('damaged relief counts as missing, and is said once', kTest, async (t) => {
  t.mock.method(console, 'warn', () => {});
  const worker = await startWorker();
  let damaged = 0;
  Socket.alter = (message) => {
    const is_relief = message[0] === kTile && message.length > 1000 && message[1] === 0; // of the finest level
    if (!is_relief || damaged === 2) return message;
    ++damaged;
    return message.slice(0, message.length / 2);
  };
  await fly(worker, (state) => state?.statistics.damaged_tiles === 2 && state.statistics.keyframes > 10);
  assert.equal(worker.of('damaged').length, 1);
  assert.deepEqual([worker.of('refused'), worker.of('failed')], [[], []]);
  worker.say({ kind: 'close' });
});

// Of code that no guard surrounds.
test('an error that nothing else has seen ends the session, and is said once', kTest, async (t) => {
  const said = t.mock.method(console, 'error', () => {}).mock;
  const worker = await startWorker();
  await fly(worker, (state) => state?.statistics.keyframes > 2);
  for (const reason of [new Error('first'), new Error('second')]) worker.tell('unhandledrejection', { reason, preventDefault: () => {} });
  assert.deepEqual(worker.of('failed').map(({ failure }) => failure), [{ part: 'page', reason: 'first' }]);
  assert.equal(errorsOf(said).length, 1);
  assert.equal(sockets[0].readyState, 3);
});
