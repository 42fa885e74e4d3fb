// Makes the meshes of a recorded flight in WebAssembly for `foreland bench client` and prints how long that took.
//
//   node make_meshes.mjs MODULE STREAM
//
// MODULE: build/wasm/bin/foreland-mesher.wasm. STREAM: for each message its size as uint32, little-endian, and its bytes; the
// welcome first. Prints JSON: milliseconds for each keyframe (median of three passes, after one that is not counted) of decoding,
// of the mesh by change and of the mesh made anew; its triangles; the module's memory in bytes, and node's version.
import { performance } from 'node:perf_hooks';
import { loadStream } from '../wire/stream_module.mjs';

const kWarmUps = 1, kPasses = 3;

const [module_path, stream_path] = process.argv.slice(2);
const { exports, messages } = await loadStream(module_path, stream_path, 'mesher');

function timed(work) {
  const started = performance.now();
  const result = work();
  return [performance.now() - started, result];
}

// Of each keyframe: milliseconds of decoding and of the mesh, by change or anew.
function pass(make) {
  const [welcome, ...keyframes] = messages;
  if (!exports.mesher_welcome(welcome.begin, welcome.size)) throw new Error('the first message is no welcome');
  return keyframes.map(({ begin, size }, i) => {
    if (!exports.mesher_read(begin, size)) throw new Error(`message ${i + 1} is no keyframe`);
    const [decode_ms, is_good] = timed(exports.mesher_decode);
    if (!is_good) throw new Error(`keyframe ${i + 1} is refused`);
    const [mesh_ms, triangles] = timed(make);
    return { decode_ms, mesh_ms, triangles };
  });
}

const passes = [];
for (let i = 0; i < kWarmUps + kPasses; ++i) passes.push({ patch: pass(exports.mesher_patch), build: pass(exports.mesher_build) });
passes.splice(0, kWarmUps);
const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
const medians = (kind, key) => messages.slice(1).map((_, i) => median(passes.map((p) => p[kind][i][key])));
console.log(JSON.stringify({
  decode_ms: medians('patch', 'decode_ms'),
  mesh_ms: medians('patch', 'mesh_ms'),
  full_mesh_ms: medians('build', 'mesh_ms'),
  triangles: passes[0].patch.map((p) => p.triangles),
  memory_bytes: exports.memory.buffer.byteLength,
  node: process.versions.node,
}));
