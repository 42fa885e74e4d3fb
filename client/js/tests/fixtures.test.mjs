// The package as it is packed, in pages that others' tools have built: Vite, webpack 5, esbuild, an import map without any of them, and the
// one file for pages that have nothing; with this version of three and with the oldest one that is supported.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { copyFile, mkdir, readFile, symlink, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { promisify } from 'node:util';
import { build as buildByEsbuild } from 'esbuild';
import { build as buildByVite } from 'vite';
import webpack from 'webpack';
import { complainOfWarnings, makeFolder, makeScene, openBrowser, openPage, package_folder, startServer } from './support.mjs';
import { serveFolder } from './static_server.mjs';

const run = promisify(execFile);
const kTest = { timeout: 300_000 };
let folder, server, files, browser, packed;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeScene(folder.folder, { size: 257 }));
  files = await serveFolder(folder.folder);
  browser = await openBrowser();
  const { stdout } = await run('npm', ['pack', '--json', '--pack-destination', folder.folder], { cwd: package_folder });
  packed = join(folder.folder, JSON.parse(stdout)[0].filename);
}, kTest);
after(async () => {
  await browser?.close();
  for (const one of [server, files]) await one?.stop();
  await folder?.remove();
});

// A user's project with the packed client and a version of three installed.
async function project(name, three = 'three') {
  const at = join(folder.folder, name);
  await mkdir(join(at, 'node_modules/@foreland/client'), { recursive: true });
  await run('tar', ['xzf', packed, '-C', join(at, 'node_modules/@foreland/client'), '--strip-components=1']);
  await symlink(join(package_folder, 'node_modules', three), join(at, 'node_modules/three'));
  await copyFile(join(package_folder, 'tests/fixtures/main.js'), join(at, 'main.js'));
  await writeFile(join(at, 'package.json'), '{ "type": "module", "private": true }');
  return at;
}
const pageOf = (script, head = '') => `<!doctype html><meta charset="utf-8">${head}<script type="module" src="${script}"></script>`;

// The page at `path` flies; nothing goes wrong in it.
async function flies(path, { complains = [] } = {}) {
  const { page, complaints, close } = await openPage(browser, { width: 160, height: 90 });
  complainOfWarnings(page, complaints);
  page.setDefaultTimeout(120_000);
  try {
    await page.goto(new URL(`${path}?server=${encodeURIComponent(server.url.href)}`, files.url).href);
    await page.waitForFunction(() => globalThis.flown, null, { polling: 50 }).catch((error) => assert.fail(`${error.message}\n${complaints.join('\n')}`));
    const flown = await page.evaluate(() => globalThis.flown);
    assert.deepEqual(complaints, complains);
    assert.ok(flown.worst <= 1, `${flown.worst} px`);
    assert.ok(flown.ground > 0.3, `ground on ${flown.ground} of the picture`);
    return flown;
  } finally {
    await close();
  }
}

test('esbuild, with the worker and the module copied beside the bundle', kTest, async () => {
  const at = await project('by-esbuild');
  await buildByEsbuild({ entryPoints: [join(at, 'main.js')], bundle: true, format: 'esm', outfile: join(at, 'out/main.js'), logLevel: 'error' });
  for (const name of ['worker.js', 'foreland.wasm']) await copyFile(join(at, 'node_modules/@foreland/client/dist', name), join(at, 'out', name));
  await writeFile(join(at, 'out/index.html'), pageOf('./main.js'));
  await flies('by-esbuild/out/index.html');
});

test('Vite finds the worker and the module', kTest, async () => {
  const at = await project('by-vite');
  await writeFile(join(at, 'index.html'), pageOf('./main.js'));
  await buildByVite({ root: at, base: './', logLevel: 'error', build: { target: 'es2022', outDir: 'out' }, resolve: { preserveSymlinks: true } });
  await flies('by-vite/out/index.html');
});

test('webpack finds the worker and the module', kTest, async () => {
  const at = await project('by-webpack');
  const stats = await new Promise((done, fail) => webpack({
    mode: 'production', context: at, entry: './main.js', devtool: false, output: { path: join(at, 'out'), publicPath: 'auto' }, resolve: { symlinks: false },
    performance: { hints: false },
  }, (error, made) => (error ? fail(error) : done(made))));
  const { errors, warnings } = stats.toJson({ all: false, errors: true, warnings: true });
  assert.deepEqual([errors, warnings], [[], []]);
  await writeFile(join(at, 'out/index.html'), '<!doctype html><meta charset="utf-8"><script defer src="./main.js"></script><body></body>');
  await flies('by-webpack/out/index.html');
});

// Nothing is built, and the oldest three is drawn with.
const importsOf = (client) => `<script type="importmap">${JSON.stringify({ imports: {
  'three': './node_modules/three/build/three.module.js', '@foreland/client': `./node_modules/@foreland/client/dist/${client}.js`,
  '@foreland/client/three': './node_modules/@foreland/client/dist/three.js',
} })}</script>`;

test('an import map is enough, and the oldest three draws the same', kTest, async () => {
  const at = await project('by-map', 'three-oldest');
  await writeFile(join(at, 'index.html'), pageOf('./main.js', importsOf('index')));
  assert.equal((await flies('by-map/index.html')).revision, '167');
});

test('the one file asks for nothing else', kTest, async () => {
  const at = await project('inline');
  await writeFile(join(at, 'index.html'), pageOf('./main.js', importsOf('inline')));
  for (const name of ['worker.js', 'foreland.wasm']) await writeFile(join(at, 'node_modules/@foreland/client/dist', name), 'gone');
  await flies('inline/index.html');
  assert.match(await readFile(join(at, 'node_modules/@foreland/client/dist/worker.js'), 'utf8'), /^gone$/);
});
