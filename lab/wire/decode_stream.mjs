// Decodes a recorded flight in WebAssembly for `foreland bench wire` and prints how long that took.
//
//   node decode_stream.mjs MODULE STREAM
//
// MODULE: build/wasm/bin/foreland-decoder.wasm. STREAM: for each message its size as uint32, little-endian, and its bytes; the
// welcome first. Prints JSON: processor seconds of the process while applying the first keyframe and the others (median of five
// passes, after one that is not counted), the digest of the last section, and node's version.
import { loadStream } from './stream_module.mjs';

const kWarmUps = 1, kPasses = 5;

const [module_path, stream_path] = process.argv.slice(2);
const { exports, messages } = await loadStream(module_path, stream_path, 'decoder');

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
