// Builds the package into dist/: ES modules for browsers, bundlers and Node, the worker, the module, and types. The client core,
// foreland.wasm, comes from the `wasm` preset's build folder, or from where FORELAND_WASM says.
import { execFile } from 'node:child_process';
import { copyFile, readFile, rm } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { build } from 'esbuild';
import { writeRecords } from './make_records.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const dist = join(here, 'dist');
const wasm = resolve(process.env.FORELAND_WASM ?? join(here, '../../build/wasm/bin/foreland.wasm'));
const run = promisify(execFile);

// Shaders without their comments.
const shaders = {
  name: 'shaders',
  setup({ onLoad }) {
    onLoad({ filter: /\.glsl$/ }, async ({ path }) => ({ loader: 'text', contents: (await readFile(path, 'utf8')).replace(/[ \t]*\/\/.*$/gm, '').replace(/\n{2,}/g, '\n') }));
  },
};
// What inline.ts has in itself: the worker and the module, as they were built.
const parts = {
  name: 'parts',
  setup({ onResolve, onLoad }) {
    onResolve({ filter: /^foreland:/ }, ({ path }) => ({ path, namespace: 'foreland' }));
    onLoad({ filter: /worker$/, namespace: 'foreland' }, async () => ({ loader: 'text', contents: await readFile(join(dist, 'worker.js'), 'utf8') }));
    onLoad({ filter: /wasm$/, namespace: 'foreland' }, async () => ({ loader: 'binary', contents: await readFile(wasm) }));
  },
};

const common = { bundle: true, format: 'esm', target: 'es2022', minify: true, legalComments: 'none', outdir: dist, plugins: [shaders, parts] };
const source = (name) => join(here, 'src', name);

await rm(dist, { recursive: true, force: true });
await writeRecords(wasm);
await Promise.all([
  build({ ...common, entryPoints: { index: source('index.ts'), three: source('three/index.ts'), maplibre: source('maplibre/index.ts') }, splitting: true, external: ['three', 'maplibre-gl'] }),
  build({ ...common, entryPoints: { worker: source('worker/worker.ts') } }),
  build({ ...common, entryPoints: { node: source('node.ts'), 'node-worker': source('worker/node_worker.ts') }, platform: 'node', external: ['ws', './worker.js'] }),
  run(join(here, 'node_modules/.bin/tsc'), ['-p', here]),
]);
await build({ ...common, entryPoints: { inline: source('inline.ts') } });
await copyFile(wasm, join(dist, 'foreland.wasm'));
