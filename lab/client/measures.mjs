// What the page measures, beside the rasters that scenes are built of: heights along random lines over Mount St. Helens and N46E008, areas of
// random rings, and what the crater gained from 2004 to 2007.
//
//   node lab/client/measures.mjs [--profiles N] [--rings N] [--seed N] [--data FOLDER]
//
// The page's own functions (client/web/src/measure) ask a real server; lab/client/raster_truth.py judges with NumPy on what GDAL reads, and with
// PROJ's geod, which share no code with them. Heights of Helens are built in steps of 1 cm, for those of 10 cm that the scene would have are off by
// 5 cm. Prints JSON; exits 1 where heights are off by more than 1 cm, areas by more than 1e-6 or the volume by more than 0.1 %. Programs are those of
// FORELAND_BIN (default build/release/bin), data those of FORELAND_DATA (default ../shared/data); python3 is to have NumPy and GDAL (PYTHON).
import { execFile } from 'node:child_process';
import { existsSync } from 'node:fs';
import { writeFile } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs, promisify } from 'node:util';

const here = dirname(fileURLToPath(import.meta.url)), root = resolve(here, '../..'), web = resolve(root, 'client/web');
if (!existsSync(join(root, 'client/js/dist'))) throw new Error('The client is not built: run ./check --stage wasm --stage page.');
const { makeFolder, openSources, runForeland, startServer } = await import(join(web, 'tests/support.mjs'));
const { Terrain } = await import(join(root, 'client/js/dist/node.js'));
const run = promisify(execFile);

const { values } = parseArgs({
  options: {
    profiles: { type: 'string', default: '1000' }, rings: { type: 'string', default: '200' }, seed: { type: 'string', default: '1' },
    data: { type: 'string', default: process.env.FORELAND_DATA ?? resolve(root, '../shared/data') },
  },
});
const dem = join(values.data, 'dem'), python = process.env.PYTHON ?? '/usr/bin/python3';

let state = Number(values.seed) >>> 0;
const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;

const { folder, remove } = await makeFolder();
const sources = await openSources(), measurement = await sources.load('measure/measurement.ts');

// Numbers for the judge: one file of doubles, and what it prints.
async function judge(kind, numbers, ...more) {
  const file = join(folder, `${kind}.f64`);
  await writeFile(file, Buffer.from(Float64Array.from(numbers).buffer));
  return JSON.parse((await run(python, [join(here, 'raster_truth.py'), kind, file, ...more], { maxBuffer: 1 << 24 })).stdout);
}

// `x`, `y`: from the raster's first to its last sample; a ring about a place, or the ends of a line, anywhere within.
const between = ([low, high]) => low + (high - low) * random();
function ringIn([x, y], pointOf) {
  const count = 3 + Math.floor(6 * random()), size = [x, y].map(([low, high]) => (high - low) * (0.01 + 0.15 * random()));
  const middle = [x, y].map(([low, high], k) => between([low + size[k], high - size[k]]));
  return Array.from({ length: count }, (_, i) => {
    const angle = (2 * Math.PI * (i + 0.7 * random())) / count, radius = 0.3 + 0.7 * random();
    return pointOf(middle[0] + radius * size[0] * Math.cos(angle), middle[1] + radius * size[1] * Math.sin(angle));
  });
}

async function measured(raster, more, is_geographic) {
  const scene = join(folder, 'scene.fls');
  await runForeland('build', raster, '-o', scene, ...more);
  const server = await startServer(scene), terrain = await Terrain.open(server.url.href.replace('http', 'ws'), { lens: { fovY: 1, width: 320, height: 200 } });
  try {
    const { x, y } = await judge('extent', [], raster);
    const pointOf = (u, v) => (is_geographic ? { lon: u, lat: v } : { easting: u, northing: v }), numbersOf = (place) => (is_geographic ? [place.lon, place.lat] : [place.easting, place.northing]);
    const along = [], of_rings = [];
    for (let i = 0; i < Number(values.profiles); ++i) {
      const { profile } = await measurement.measure(terrain, [0, 1].map(() => pointOf(between(x), between(y))));
      profile.places.forEach((place, k) => along.push(...numbersOf(place), profile.heights[k]));
    }
    for (let i = 0; i < Number(values.rings); ++i) {
      const ring = ringIn([x, y], pointOf), { area } = await measurement.measure(terrain, ring);
      of_rings.push(area.plane_m2, ring.length, ...ring.flatMap(numbersOf));
    }
    return { profiles: await judge('profiles', along, raster), areas: await judge('areas', of_rings, is_geographic ? 'geographic' : 'planar') };
  } finally {
    terrain.close();
    await server.stop();
  }
}

// By cells of the page's own grid over a box in the crater, of which the surveys know all.
async function crater() {
  const [before, after] = ['02_2004-10-04', '27_2007-07-05'].map((name) => join(dem, 'msh/epochs', `${name}.tif`)), scene = join(folder, 'dome.fls');
  await runForeland('build', join(dem, 'msh/msh_base_utm10_10m.tif'), '--vertical-step', '0.01', '--epoch', `2004-10-04=${before}`, '--epoch', `2007-07-05=${after}`, '-o', scene);
  const { x, y } = await judge('extent', [], after), inset = ([low, high]) => [low + 0.1 * (high - low), high - 0.1 * (high - low)], [[west, east], [south, north]] = [inset(x), inset(y)];
  const ring = [[west, south], [east, south], [east, north], [west, north]].map(([easting, northing]) => ({ easting, northing }));
  const server = await startServer(scene), terrain = await Terrain.open(server.url.href.replace('http', 'ws'), { lens: { fovY: 1, width: 320, height: 200 } });
  try {
    const { change } = await measurement.measure(terrain, ring, { since_ms: Date.UTC(2004, 9, 4), until_ms: Date.UTC(2007, 6, 5) });
    return await judge('volume', [west, east, south, north, change.gained_m3 - change.lost_m3], before, after);
  } finally {
    terrain.close();
    await server.stop();
  }
}

let figures;
try {
  figures = {
    seed: Number(values.seed),
    helens: await measured(join(dem, 'msh/msh_base_utm10_10m.tif'), ['--vertical-step', '0.01'], false),
    n46e008: await measured(join(dem, 'srtm/N46E008.tif'), [], true),
    crater: await crater(),
  };
} finally {
  await sources.close();
  await remove();
}
const { helens, n46e008, crater: gained } = figures;
figures.is_right = [helens, n46e008].every(({ profiles, areas: of }) => profiles.largest_m <= 0.01 && of.largest_share <= 1e-6) && Math.abs(gained.share) <= 1e-3;
console.log(JSON.stringify(figures, null, 2));
process.exitCode = figures.is_right ? 0 : 1;
