// The client core as WebAssembly without a browser: the module of the package, through src/core and src/worker, in a session
// with the real server. Every wait is for a condition.
import assert from 'node:assert/strict';
import { randomInt } from 'node:crypto';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { gzipSync } from 'node:zlib';
import { openSocket } from './socket.mjs';
import { loadModule, makeFolder, makeScene, openSources, package_folder, startServer } from './support.mjs';

const kTest = { timeout: 120_000 };
const kRequest = { fov_rad: 1.05, width_px: 640, height_px: 360, tau_px: 1, strategy: 'current', predictor: 'hold', keyframe_ms: 50 };
let folder, server, sources, module, Core, Viewer;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeScene(folder.folder, { size: 257 }));
  module = await loadModule();
  sources = await openSources();
  ({ Core } = await sources.load('core/core.ts'));
  ({ Viewer } = await sources.load('worker/viewer.ts'));
}, kTest);

after(async () => {
  await sources?.close();
  await server?.stop();
  await folder?.remove();
});

// Joins the server, with the eye above the middle of the scene and looking down, until `isDone(viewer, frame)`.
async function fly(isDone, { blend = 'keyframe', request = () => null } = {}) {
  const viewer = new Viewer(await Core.load(module), kRequest);
  viewer.setBlend(blend);
  const begun = performance.now(), now = () => performance.now() - begun;
  const refusals = [];
  const socket = await openSocket(new URL('fly', server.url).href, (message) => {
    const refusal = viewer.receive(message, now());
    if (refusal !== null) refusals.push(refusal);
  });
  for (let is_done = false; !is_done; await setImmediate()) {
    const welcome = viewer.welcome();
    const middle = welcome ? [0, 1].map((i) => 0.5 * (welcome.low[i] + welcome.high[i])) : [0, 0];
    // Moves a little, so that sections change.
    const eye = [middle[0] + 0.05 * now(), middle[1], (welcome?.high[2] ?? 0) + 500];
    // At once: a mesh may be gone when messages have arrived.
    is_done = isDone(viewer, viewer.frame(now(), { eye, orientation: [0, 0, 0, 1] }));
    const wanted = request();
    if (wanted !== null) viewer.setRequest(wanted);
    for (let bytes = viewer.takeOutgoing(); bytes !== null; bytes = viewer.takeOutgoing()) socket.send(Buffer.from(bytes));
    assert.deepEqual(refusals, []);
  }
  await socket.close();
  return viewer;
}

// Edges that do not belong to exactly two triangles.
function openEdges(indices) {
  const uses = new Map();
  for (let i = 0; i < indices.length; i += 3) {
    for (const [a, b] of [[0, 1], [1, 2], [2, 0]].map(([k, l]) => [indices[i + k], indices[i + l]])) {
      const key = a < b ? a * 4294967296 + b : b * 4294967296 + a;
      uses.set(key, (uses.get(key) ?? 0) + 1);
    }
  }
  return [...uses].filter(([, n]) => n !== 2).map(([key, n]) => ({ ends: [Math.floor(key / 4294967296), key % 4294967296], n }));
}

test('the module asks for nothing but WASI', kTest, async () => {
  const imports = WebAssembly.Module.imports(module);
  assert.ok(imports.length <= 3, imports.map((i) => i.name).join(' '));
  assert.ok(imports.every((i) => i.module === 'wasi_snapshot_preview1' && i.kind === 'function'));
});

// What a viewer waits for. It takes 219 kB, and grows unnoticed: docs/decisions/0053-a-small-module.md tells what is in it.
const kMaxModuleBytes = 219_000;

test('the module is small', kTest, async () => {
  const { length } = gzipSync(await readFile(join(package_folder, 'dist/foreland.wasm')), { level: 9 });
  assert.ok(length <= kMaxModuleBytes, `${length} bytes compressed by gzip`);
});

test('a failed check of the module says what failed where', kTest, async (t) => {
  const said = t.mock.method(console, 'error', () => {}).mock;
  const viewer = await fly((_, frame) => frame.mesh_version > 0);
  viewer.setTextureLayers({ relief: 7, imagery: 7 }); // too few
  assert.throws(() => viewer.takeNewest(), WebAssembly.RuntimeError);
  assert.equal(said.callCount(), 1);
  assert.match(said.calls[0].arguments[0], /\bclient\/imagery\/residency\.cpp:\d+: CHECK failed: texture_layers >= 8u \(left 7, right 8\)$/);
});

test('a session gives meshes without cracks', kTest, async () => {
  const checked = new Set();
  const viewer = await fly((viewer, frame) => {
    if (frame.mesh_version === 0 || checked.has(frame.mesh_version)) return false;
    checked.add(frame.mesh_version);
    const mesh = viewer.mesh();
    const welcome = viewer.welcome();
    for (const positions of [mesh.from_positions, mesh.to_positions]) assert.ok(positions.every(Number.isFinite));
    assert.ok(mesh.indices.every((i) => i < mesh.vertices));
    const at = (v, axis) => mesh.origin[axis] + mesh.to_positions[4 * v + axis];
    const isOn = (v, axis, side) => Math.abs(at(v, axis) - welcome[side][axis]) < 0.5;
    for (const { ends: [a, b], n } of openEdges(mesh.indices)) {
      assert.equal(n, 1, `edge ${a} ${b} has ${n} triangles`);
      const is_border = [0, 1].some((axis) => ['low', 'high'].some((side) => isOn(a, axis, side) && isOn(b, axis, side)));
      assert.ok(is_border, `a crack from ${[at(a, 0), at(a, 1)]} to ${[at(b, 0), at(b, 1)]}`);
    }
    return checked.size >= 10 && mesh.triangles > 500;
  });
  const { keyframes, bytes_down } = viewer.statistics();
  assert.ok(keyframes >= 10 && bytes_down > 1000);
  viewer.destroy();
});

// The heights of what is drawn at either end, by place; only of vertices that the camera, which looks down, sees.
function heightsInView(mesh, eye, positions) {
  const heights = new Map();
  for (const v of new Set(mesh.indices)) { // not places that no triangle uses
    const [x, y, z] = [0, 1, 2].map((axis) => mesh.origin[axis] + positions[4 * v + axis]);
    const [right, up, depth] = [x - eye[0], y - eye[1], eye[2] - z];
    const tan_y = Math.tan(0.5 * kRequest.fov_rad), tan_x = (tan_y * kRequest.width_px) / kRequest.height_px;
    if (Math.abs(right) < depth * tan_x && Math.abs(up) < depth * tan_y) heights.set(`${x.toFixed(0)} ${y.toFixed(0)}`, z);
  }
  return heights;
}

test('geomorphs take their time, and do not jump where a mesh ends', kTest, async () => {
  let last = null, meshes = 0, compared = 0, between = 0, asked = 0;
  const isDone = (viewer, frame) => {
    if (frame.mesh_version === 0 || frame.mesh_version === last?.version) return false;
    const mesh = viewer.mesh();
    const begin = heightsInView(mesh, frame.pose.eye, mesh.from_positions);
    for (const [place, height] of last?.version === mesh.version - 1 ? begin : []) {
      if (!last.end.has(place)) continue;
      ++compared;
      assert.ok(Math.abs(last.end.get(place) - height) < 0.01, `${last.end.get(place)} m, then ${height} m at ${place}`);
    }
    const end = heightsInView(mesh, frame.pose.eye, mesh.to_positions);
    for (const [place, height] of end) {
      const [before, first] = [last?.begin.get(place), begin.get(place)];
      if (before !== undefined && (first - before) * (height - first) > 1e-4) ++between; // one way through two meshes
    }
    last = { version: mesh.version, begin, end };
    return ++meshes >= 30 && compared > 1000;
  };
  // Another tolerance now and then, so that much comes and goes.
  const request = () => (meshes >= asked + 6 ? ((asked = meshes), { ...kRequest, tau_px: asked % 4 < 2 ? 0.5 : 4 }) : null);
  const viewer = await fly(isDone, { blend: 'geomorph', request });
  assert.ok(between > 100, `${between} vertices took more than one mesh`);
  viewer.destroy();
});

test('messages that are none are refused with a reason and do no harm', kTest, async () => {
  const core = await Core.load(module);
  const seed = randomInt(2 ** 31);
  let state = seed;
  const next = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) >>> 8;
  for (let i = 0; i < 3000; ++i) {
    const viewer = new Viewer(core, kRequest);
    const message = Uint8Array.from({ length: next() % 300 }, () => next() & 255);
    if (message.length > 0) message[0] %= 8; // often a kind that exists
    const refusal = viewer.receive(message, i);
    assert.ok(refusal === null || refusal.length > 10, `seed ${seed}: '${refusal}'`);
    viewer.frame(i, { eye: [0, 0, 0], orientation: [0, 0, 0, 1] });
    viewer.destroy();
  }
  assert.ok(core.view().byteLength < 64 << 20, `seed ${seed}: ${core.view().byteLength} bytes are held`);
});
