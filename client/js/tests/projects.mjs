// A user's projects with the packed client, as others' tools build them: Vite, webpack 5, esbuild, an import map without any of them, and
// the one file for pages that have nothing.
import { execFile } from 'node:child_process';
import { copyFile, mkdir, symlink, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { promisify } from 'node:util';
import { build as buildByEsbuild } from 'esbuild';
import { build as buildByVite } from 'vite';
import webpack from 'webpack';
import { package_folder } from './support.mjs';

const run = promisify(execFile);

// Packs the package as it would be published.
export async function pack(folder) {
  const { stdout } = await run('npm', ['pack', '--json', '--pack-destination', folder], { cwd: package_folder });
  return join(folder, JSON.parse(stdout)[0].filename);
}

// Below `folder`, with `packed` and a version of three installed.
async function project({ folder, packed }, name, three = 'three') {
  const at = join(folder, name);
  await mkdir(join(at, 'node_modules/@foreland/client'), { recursive: true });
  await run('tar', ['xzf', packed, '-C', join(at, 'node_modules/@foreland/client'), '--strip-components=1']);
  await symlink(join(package_folder, 'node_modules', three), join(at, 'node_modules/three'));
  await copyFile(join(package_folder, 'tests/fixtures/main.js'), join(at, 'main.js'));
  await writeFile(join(at, 'package.json'), '{ "type": "module", "private": true }');
  return at;
}
const pageOf = (script, head = '') => `<!doctype html><meta charset="utf-8">${head}<script type="module" src="${script}"></script>`;
const importsOf = (client) => `<script type="importmap">${JSON.stringify({ imports: {
  'three': './node_modules/three/build/three.module.js', '@foreland/client': `./node_modules/@foreland/client/dist/${client}.js`,
  '@foreland/client/three': './node_modules/@foreland/client/dist/three.js',
} })}</script>`;

// Each gives the path of its page.
export const projects = {
  async esbuild(where) {
    const at = await project(where, 'by-esbuild');
    await buildByEsbuild({ entryPoints: [join(at, 'main.js')], bundle: true, format: 'esm', outfile: join(at, 'out/main.js'), logLevel: 'error' });
    for (const name of ['worker.js', 'foreland.wasm']) await copyFile(join(at, 'node_modules/@foreland/client/dist', name), join(at, 'out', name));
    await writeFile(join(at, 'out/index.html'), pageOf('./main.js'));
    return 'by-esbuild/out/index.html';
  },
  async vite(where) {
    const at = await project(where, 'by-vite');
    await writeFile(join(at, 'index.html'), pageOf('./main.js'));
    await buildByVite({ root: at, base: './', logLevel: 'error', build: { target: 'es2022', outDir: 'out' }, resolve: { preserveSymlinks: true } });
    return 'by-vite/out/index.html';
  },
  async webpack(where) {
    const at = await project(where, 'by-webpack');
    const stats = await new Promise((done, fail) => webpack({
      mode: 'production', context: at, entry: './main.js', devtool: false, output: { path: join(at, 'out'), publicPath: 'auto' }, resolve: { symlinks: false },
      performance: { hints: false },
    }, (error, made) => (error ? fail(error) : done(made))));
    const { errors, warnings } = stats.toJson({ all: false, errors: true, warnings: true });
    if (errors.length + warnings.length > 0) throw new Error(JSON.stringify([errors, warnings]));
    await writeFile(join(at, 'out/index.html'), '<!doctype html><meta charset="utf-8"><script defer src="./main.js"></script><body></body>');
    return 'by-webpack/out/index.html';
  },
  // Nothing is built, and the oldest three is drawn with.
  async map(where) {
    const at = await project(where, 'by-map', 'three-oldest');
    await writeFile(join(at, 'index.html'), pageOf('./main.js', importsOf('index')));
    return 'by-map/index.html';
  },
  async inline(where) {
    const at = await project(where, 'inline');
    await writeFile(join(at, 'index.html'), pageOf('./main.js', importsOf('inline')));
    for (const name of ['worker.js', 'foreland.wasm']) await writeFile(join(at, 'node_modules/@foreland/client/dist', name), 'gone');
    return 'inline/index.html';
  },
};
