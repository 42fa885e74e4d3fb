// A million positions on a globe are the same bits in WebAssembly as in native code, which has a test of its own against
// the same number (tests/proto/space/globe_positions.h).
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';

const module_file = new URL('../../../build/wasm/bin/foreland-positions.wasm', import.meta.url);

test('positions on a globe are those of native code, to the bit', async () => {
  const module = await WebAssembly.compile(await readFile(module_file));
  const nothing = new Proxy({}, { get: () => () => 0 });
  const imports = Object.fromEntries(WebAssembly.Module.imports(module).map((i) => [i.module, nothing]));
  const { exports } = await WebAssembly.instantiate(module, imports);
  exports._initialize?.();
  assert.equal(exports.hash_of_positions(), exports.native_hash());
});
