// The package as it is published: its names, types, sizes and words.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { gzipSync } from 'node:zlib';
import { package_folder } from './support.mjs';

const run = promisify(execFile);
const kTest = { timeout: 120_000 };
const here = { cwd: package_folder };
const tool = (name, ...args) => run(join(package_folder, 'node_modules/.bin', name), args, here);

test('publint and arethetypeswrong find nothing', kTest, async () => {
  const { stdout } = await tool('publint', '--strict');
  assert.match(stdout, /All good/);
  await tool('attw', '--pack', '.', '--profile', 'esm-only', '--exclude-entrypoints', 'foreland.wasm', '--no-emoji');
});

test('what is published is what is built, and nothing else', kTest, async () => {
  const [{ files }] = JSON.parse((await run('npm', ['pack', '--dry-run', '--json'], here)).stdout);
  const names = files.map(({ path }) => path).filter((path) => !path.startsWith('dist/types/') && !/^dist\/chunk-\w+\.js$/.test(path));
  assert.deepEqual(names.sort(), [...['API', 'README'].map((name) => `${name}.md`), 'dist/foreland.wasm', 'dist/index.js', 'dist/inline.js', 'dist/maplibre.js', 'dist/node-worker.js', 'dist/node.js', 'dist/three.js',
    'dist/worker.js', 'package.json']);
});

// What a page waits for beside the module.
test('the client and its worker are small', kTest, async () => {
  const sizeOf = async (name) => gzipSync(await readFile(join(package_folder, 'dist', name)), { level: 9 }).length;
  const chunks = [...(await readFile(join(package_folder, 'dist/index.js'), 'utf8')).matchAll(/"\.\/(chunk-\w+\.js)"/g)].map(([, name]) => name);
  assert.ok(chunks.length > 0);
  const sizes = await Promise.all(['index.js', 'worker.js', ...chunks].map(sizeOf));
  const bytes = sizes.reduce((sum, size) => sum + size, 0);
  assert.ok(bytes <= 40_000, `${bytes} bytes compressed by gzip`);
});

test('the list of the interface is that of the types, and every snippet compiles', kTest, async () => {
  await run('node', ['make_api.mjs', '--check'], here);
  await run('node', ['make_snippets.mjs'], here);
});

test('no example is longer than 60 lines', async () => {
  const folder = join(package_folder, 'examples');
  for (const name of await readdir(folder)) {
    const lines = (await readFile(join(folder, name), 'utf8')).trimEnd().split('\n').length;
    assert.ok(lines <= 60, `${name} has ${lines} lines`);
  }
});
