// Stands up what a test of a client needs: a small scene, `foreland serve` on a free loopback port, headless Chromium with an empty
// profile. The programs are those of FORELAND_BIN (default build/release/bin).
import { execFile, spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { mkdtemp, readdir, readFile, rm, writeFile } from 'node:fs/promises';
import { createConnection, createServer as createServerOfSockets } from 'node:net';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { createInterface } from 'node:readline';
import { setImmediate } from 'node:timers/promises';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { promisify } from 'node:util';
import { chromium } from 'playwright-core';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
export const root = resolve(here, '../../..');
export const bin = resolve(process.env.FORELAND_BIN ?? join(root, 'build/release/bin'));
export const package_folder = resolve(here, '..');
const run = promisify(execFile);

// ./check --soak: as many repetitions and cameras as were ever asked for.
export const is_soak = process.env.FORELAND_SOAK === '1';

const chromium_flags = [
  '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage',
];

function need(path, how) {
  if (!existsSync(path)) throw new Error(`${path} is missing: ${how}`);
}

// Makes modules of the package's sources that can be loaded without a browser, each by its path. `fresh()` makes them be evaluated anew.
export async function openSources() {
  const folder = await mkdtemp(join(tmpdir(), 'foreland-sources-'));
  const names = (await readdir(join(package_folder, 'src'), { recursive: true })).filter((name) => /^[^.]*\.ts$/.test(name) && !/inline|texts/.test(name));
  let made = 0;
  const make = () => build({ entryPoints: names.map((name) => join(package_folder, 'src', name)), outbase: join(package_folder, 'src'), outdir: join(folder, `${++made}`),
    format: 'esm', target: 'es2022', logLevel: 'error' });
  await writeFile(join(folder, 'package.json'), '{"type":"module"}');
  await make();
  return { load: (path) => import(pathToFileURL(join(folder, `${made}`, path.replace(/\.ts$/, '.js')))), fresh: make, close: () => rm(folder, { recursive: true, force: true }) };
}

// The client core, as it was built.
export async function loadModule() {
  return WebAssembly.compile(await readFile(join(package_folder, 'dist/foreland.wasm')));
}

// What a command prints.
export async function runForeland(...args) {
  return (await run(join(bin, 'foreland'), args)).stdout;
}

export async function makeFolder() {
  const folder = await mkdtemp(join(tmpdir(), 'foreland-web-'));
  return { folder, remove: () => rm(folder, { recursive: true, force: true }) };
}

// A landscape of `size` samples a side. FORELAND_SCENE names another scene to use instead, for a look by hand.
export async function makeScene(folder, { size = 513, spacing_m = 30, seed = 7 } = {}) {
  if (process.env.FORELAND_SCENE) return resolve(process.env.FORELAND_SCENE);
  need(join(bin, 'foreland'), 'build it: cmake --preset release && cmake --build --preset release');
  const raster = join(folder, 'Example mountains.tif');
  const scene = join(folder, 'example.fls');
  const foreland = join(bin, 'foreland');
  await run(foreland, ['synth', '-o', raster, '--size', `${size}`, '--spacing', `${spacing_m}`, '--seed', `${seed}`]);
  await run(foreland, ['build', raster, '-o', scene]);
  return scene;
}

// A small landscape under a picture of two mottled colours: red in the west, green in the east.
export async function makeSceneWithPicture(folder) {
  const foreland = join(bin, 'foreland');
  const [raster, picture, scene] = ['Ground below.tif', 'picture.ppm', 'picture.fls'].map((name) => join(folder, name));
  const [width, height] = [2048, 2048];
  const texels = Buffer.alloc(3 * width * height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const shade = 0.4 + 0.6 * ((((x >> 2) * 73856093) ^ ((y >> 2) * 19349663)) % 1009 / 1009) ** 2;
      texels.set((x < width / 2 ? [200, 30, 20] : [20, 160, 30]).map((v) => v * shade), 3 * (y * width + x));
    }
  }
  await writeFile(picture, Buffer.concat([Buffer.from(`P6 ${width} ${height} 255\n`), texels]));
  await run(foreland, ['synth', '-o', raster, '--size', '257', '--spacing', '30', '--seed', '5']);
  await run(foreland, ['build', raster, '-o', scene, '--imagery', picture, '--attribution', 'Painted by a test']);
  return scene;
}

// Ground on the ellipsoid, in degrees: `heightOf(i, j)` metres at sample i eastward and j northward.
export const on_earth = {
  size: 301, west: 8, south: 46, step: 1 / 1200,
  heightOf: (i, j) => 900 + 600 * Math.sin(i / 23) * Math.cos(j / 31) + 250 * Math.sin((i + j) / 9),
};
export async function makeSceneOnEarth(folder) {
  const { size, west, south, step, heightOf } = on_earth;
  const lines = [`ncols ${size}`, `nrows ${size}`, `xllcenter ${west}`, `yllcenter ${south}`, `cellsize ${step}`];
  for (let j = size - 1; j >= 0; --j) lines.push(Array.from({ length: size }, (_, i) => heightOf(i, j).toFixed(1)).join(' '));
  const [raster, scene] = ['On the earth.asc', 'on_earth.fls'].map((name) => join(folder, name));
  await writeFile(raster, lines.join('\n') + '\n');
  const picture = join(folder, 'on_earth.ppm');
  await writeFile(picture, Buffer.concat([Buffer.from('P6 512 512 255\n'), Buffer.alloc(3 * 512 * 512, 150)]));
  await run(join(bin, 'foreland'), ['build', raster, '--frame', 'geographic', '--imagery', picture, '--attribution', 'Painted by a test', '-o', scene]);
  return scene;
}

// A globe of sea and islands: one stands around each of `places`, 5 degrees across.
export const islands = { places: [[46, 10], [0, 0], [-35, 100], [89.99, 0]], depth: 3000, top: 2500 };
export async function makeGlobe(folder, more = []) {
  const { places, depth, top } = islands, radians = Math.PI / 180;
  const axes = places.map(([lat, lon]) => [Math.cos(lat * radians) * Math.cos(lon * radians), Math.cos(lat * radians) * Math.sin(lon * radians), Math.sin(lat * radians)]);
  const lines = ['ncols 721', 'nrows 361', 'xllcenter -180', 'yllcenter -90', 'cellsize 0.5'];
  for (let lat = 90; lat >= -90; lat -= 0.5)
    lines.push(Array.from({ length: 721 }, (_, i) => {
      const lon = -180 + i / 2, at = [Math.cos(lat * radians) * Math.cos(lon * radians), Math.cos(lat * radians) * Math.sin(lon * radians), Math.sin(lat * radians)];
      const near = Math.max(...axes.map((axis) => Math.min(axis.reduce((sum, v, k) => sum + v * at[k], 0), 1))), away = Math.acos(near) / (2.5 * radians);
      return ((depth + top) * Math.exp(-(away ** 2) * Math.log((depth + top) / depth)) - depth).toFixed(1);
    }).join(' '));
  const [raster, scene] = ['Islands.asc', 'islands.fls'].map((name) => join(folder, name));
  await writeFile(raster, lines.join('\n') + '\n');
  await run(join(bin, 'foreland'), ['build', raster, '--globe', ...more, '-o', scene]);
  return scene;
}

// A landscape that becomes another one from 2000 to 2002, by way of a third.
export async function makeMovingScene(folder) {
  const foreland = join(bin, 'foreland');
  const epochs = [];
  for (const year of [2000, 2001, 2002]) {
    const raster = join(folder, `Ground of ${year}.tif`);
    await run(foreland, ['synth', '-o', raster, '--size', '257', '--spacing', '30', '--seed', `${year}`]);
    epochs.push(raster, '--epoch', `${year}-01-01=${raster}`);
  }
  const scene = join(folder, 'moving.fls');
  const [first] = epochs;
  await run(foreland, ['build', first, ...epochs.filter((_, i) => i % 3 !== 0), '-o', scene]);
  return scene;
}

// A scene with `count` rings on its ground, of many colours or of none.
export async function makeSceneWithObjects(folder, count, colours = true) {
  const foreland = join(bin, 'foreland');
  const raster = join(folder, 'Ground.tif');
  const model = join(folder, 'ring.obj');
  const surface = join(folder, 'ring.fls');
  const scene = join(folder, 'objects.fls');
  await writeFile(model, ringObj(48, 24, colours));
  await run(foreland, ['remesh', model, '-o', surface, '--levels', '4', '--base-triangles', '96']);
  await run(foreland, ['synth', '-o', raster, '--size', '257', '--spacing', '30', '--seed', '9']);
  const about = JSON.parse((await run(foreland, ['build', raster, '-o', scene]).then(() => run(foreland, ['info', scene, '--json']))).stdout);
  const [x0, y0] = about.frame.origin.map_m.map((v, i) => v - about.frame.origin.lattice[i] * 30);
  const objects = [];
  for (let i = 0; i < count; ++i) {
    const [column, row] = [i % 10, Math.floor(i / 10)];
    const place = [x0 + (column + 0.5) * 768, y0 + (row + 0.5) * 768 * (10 / Math.ceil(count / 10))];
    objects.push('--object', `${surface}@${place.map((v) => v.toFixed(1)).join(',')},20,${37 * i},120`);
  }
  await run(foreland, ['build', raster, '-o', scene, ...objects]);
  return scene;
}

// A torus of radius 1, as OBJ, standing upright; with a colour for each vertex, or without.
function ringObj(around, across, colours) {
  const lines = [];
  for (let i = 0; i < around; ++i) {
    for (let j = 0; j < across; ++j) {
      const [a, b] = [(2 * Math.PI * i) / around, (2 * Math.PI * j) / across];
      const r = 1 + 0.35 * Math.cos(b);
      const colour = (colours ? [0, 2, 4] : []).map((shift) => (0.5 + 0.5 * Math.cos(a + shift)).toFixed(3));
      lines.push(`v ${(r * Math.cos(a)).toFixed(6)} ${(0.35 * Math.sin(b)).toFixed(6)} ${(r * Math.sin(a)).toFixed(6)} ${colour.join(' ')}`);
    }
  }
  const at = (i, j) => (i % around) * across + (j % across) + 1;
  for (let i = 0; i < around; ++i) {
    for (let j = 0; j < across; ++j) lines.push(`f ${at(i, j)} ${at(i, j + 1)} ${at(i + 1, j + 1)} ${at(i + 1, j)}`);
  }
  return lines.join('\n') + '\n';
}

// Resolves when the server says where it listens. Port 0 takes a free one.
export async function startServer(scene, port = 0, more = [], web = null) {
  const args = ['serve', scene, '--listen', `127.0.0.1:${port}`, ...(web === null ? [] : ['--web', web]), '--log-level', 'warning', ...more];
  const child = spawn(join(bin, 'foreland'), args, { stdio: ['ignore', 'pipe', 'inherit'] });
  const ended = new Promise((done) => child.once('exit', (code, signal) => done({ code, signal })));
  const url = await new Promise((found, fail) => {
    ended.then(({ code, signal }) => fail(new Error(`foreland serve ended before it listened: ${code ?? signal}`)));
    createInterface({ input: child.stdout }).on('line', (line) => {
      const match = line.match(/https?:\/\/\S+/);
      if (match) found(new URL(match[0]));
    });
  });
  const stop = (signal = 'SIGTERM') => {
    if (child.exitCode === null && child.signalCode === null) child.kill(signal);
    return ended;
  };
  return { url, port: Number(url.port), stop };
}

// nginx with the content of its block `http`, which listens on `ports`.
export async function startNginx(folder, http, ports) {
  const nginx = '/usr/sbin/nginx';
  need(nginx, 'install Debian\'s nginx-light');
  const paths = ['client_body', 'proxy', 'fastcgi', 'uwsgi', 'scgi'].map((kind) => `${kind}_temp_path ${join(folder, kind)};`).join(' ');
  const config = join(folder, 'nginx.conf');
  await writeFile(config, `daemon off; master_process off; pid ${join(folder, 'nginx.pid')};\nevents {}\nhttp { access_log off; ${paths}\n${http} }\n`);
  const child = spawn(nginx, ['-p', folder, '-c', config, '-e', join(folder, 'error.log')], { stdio: 'inherit' });
  const ended = new Promise((done) => child.once('exit', done));
  for (const port of ports) {
    while (!(await new Promise((done) => createConnection(port, '127.0.0.1').once('connect', function () { done(this.end()); }).once('error', () => done(null))))) {
      if (child.exitCode !== null) throw new Error(`nginx ended: ${child.exitCode}`);
      await setImmediate();
    }
  }
  return { stop: () => (child.kill(), ended) };
}

// A port that was free a moment ago.
export async function freePort() {
  const server = createServerOfSockets();
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address();
  await new Promise((done) => server.close(done));
  return port;
}

// A processor draws: four samples a pixel are two fifths of its work, and what most tests ask is the same with one.
export async function openBrowser({ has_antialias = is_soak || process.env.FORELAND_SCREENSHOT === '1' } = {}) {
  need('/usr/bin/chromium', 'install Debian\'s chromium');
  return chromium.launch({ executablePath: '/usr/bin/chromium', args: [...chromium_flags, ...(has_antialias ? [] : ['--webgl-antialiasing-mode=none'])] });
}

// A page with everything that went wrong in it: errors on the console, exceptions, failed requests.
export async function openPage(browser, { width = 960, height = 540, mobile = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, isMobile: mobile, hasTouch: mobile, ignoreHTTPSErrors: true });
  const page = await context.newPage();
  const complaints = [];
  page.on('console', (m) => m.type() === 'error' && complaints.push(m.text()));
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('response', (r) => r.status() >= 400 && complaints.push(`${r.status()} ${r.url()}`));
  return { page, complaints, close: () => context.close() };
}

// Warnings are complaints, too, but for what a driver or a browser says of its own speed, which depends on the machine.
export function complainOfWarnings(page, complaints) {
  const of_speed = /GL Driver Message \(OpenGL, Performance|performance warning:|willReadFrequently/;
  page.on('console', (m) => m.type() === 'warning' && !of_speed.test(m.text()) && complaints.push(m.text()));
}

