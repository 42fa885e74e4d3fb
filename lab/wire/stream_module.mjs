// A WebAssembly module that reads a recorded flight from its own memory, under node; its exports' names begin with `prefix`.
// `stream_path`: for each message its size as uint32, little-endian, and its bytes; the welcome first. Returns the module's exports
// and where in its memory each message begins and how long it is.
import { readFileSync } from 'node:fs';

export async function loadStream(module_path, stream_path, prefix) {
  const module = await WebAssembly.compile(readFileSync(module_path));
  const wasi = Object.fromEntries(WebAssembly.Module.imports(module).map(({ name }) => [name, () => 52])); // not supported
  wasi.proc_exit = (code) => {
    throw new Error(`the ${prefix} stopped (code ${code})`);
  };
  const { exports } = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi });
  exports._initialize?.();
  const stream = readFileSync(stream_path);
  const address = exports[`${prefix}_buffer`](stream.length) >>> 0;
  new Uint8Array(exports.memory.buffer).set(stream, address);
  const messages = [];
  for (let at = 0; at < stream.length; at = messages.at(-1).begin + messages.at(-1).size) {
    messages.push({ begin: at + 4, size: stream.readUInt32LE(at) });
  }
  return { exports, messages };
}
