// Decodes a recorded flight in WebAssembly for `foreland bench wire` and prints how long that took.
//
//   node decode_stream.mjs MODULE STREAM
//
// MODULE: build/wasm/bin/foreland-decoder.wasm. STREAM: for each message its size as uint32, little-endian, and its bytes; the
// welcome first. Prints JSON: processor seconds of the process while applying the first keyframe and the others (median of five
// passes, after one that is not counted), the digest of the last section, and node's version.
import { readFileSync } from 'node:fs';

const kWarmUps = 1, kPasses = 5;

const [module_path, stream_path] = process.argv.slice(2);
const module = await WebAssembly.compile(readFileSync(module_path));
const wasi = Object.fromEntries(WebAssembly.Module.imports(module).map(({ name }) => [name, () => 52])); // not supported
wasi.proc_exit = (code) => {
  throw new Error(`the decoder stopped (code ${code})`);
};
const { exports } = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi });
exports._initialize?.();

const stream = readFileSync(stream_path);
const address = exports.decoder_buffer(stream.length) >>> 0;
new Uint8Array(exports.memory.buffer).set(stream, address);
const messages = [];
for (let at = 0; at < stream.length; at = messages.at(-1).begin + messages.at(-1).size) {
  messages.push({ begin: at + 4, size: stream.readUInt32LE(at) });
}

function processorSeconds() {
  const { user, system } = process.cpuUsage();
  return 1e-6 * (user + system);
}

// Seconds of each message after the welcome.
function decode() {
  const seconds = [];
  messages.forEach(({ begin, size }, i) => {
    if (!exports.decoder_read(begin, size)) throw new Error(`message ${i} is none`);
    if (i === 0) return;
    const started = processorSeconds();
    if (!exports.decoder_apply()) throw new Error(`keyframe ${i} is refused`);
    seconds.push(processorSeconds() - started);
  });
  return { first_s: seconds[0], rest_s: seconds.slice(1).reduce((sum, s) => sum + s, 0) };
}

const passes = Array.from({ length: kWarmUps + kPasses }, decode).slice(kWarmUps);
const median = (key) => passes.map((pass) => pass[key]).sort((a, b) => a - b)[kPasses >> 1];
const digest = exports.decoder_digest() >>> 0;
console.log(JSON.stringify({ first_s: median('first_s'), rest_s: median('rest_s'), digest, node: process.versions.node }));
