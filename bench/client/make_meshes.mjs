// Makes the meshes of a recorded flight in WebAssembly for `foreland bench client` and prints how long that took.
//
//   node make_meshes.mjs MODULE STREAM
//
// MODULE: build/wasm/bin/foreland-mesher.wasm. STREAM: for each message its size as uint32, little-endian, and its bytes; the
// welcome first. Prints JSON: milliseconds for each keyframe (median of three passes, after one that is not counted) of decoding,
// of the mesh by change and of the mesh made anew, the module's memory in bytes, and node's version.
import { readFileSync } from 'node:fs';
import { performance } from 'node:perf_hooks';

const kWarmUps = 1, kPasses = 3;

const [module_path, stream_path] = process.argv.slice(2);
const module = await WebAssembly.compile(readFileSync(module_path));
const wasi = Object.fromEntries(WebAssembly.Module.imports(module).map(({ name }) => [name, () => 52])); // not supported
wasi.proc_exit = (code) => {
  throw new Error(`the client stopped (code ${code})`);
};
const { exports } = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi });
exports._initialize?.();

const stream = readFileSync(stream_path);
const address = exports.mesher_buffer(stream.length) >>> 0;
new Uint8Array(exports.memory.buffer).set(stream, address);
const messages = [];
for (let at = 0; at < stream.length; at = messages.at(-1).begin + messages.at(-1).size) {
  messages.push({ begin: at + 4, size: stream.readUInt32LE(at) });
}

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
    const [mesh_ms] = timed(make);
    return { decode_ms, mesh_ms };
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
  memory_bytes: exports.memory.buffer.byteLength,
  node: process.versions.node,
}));
