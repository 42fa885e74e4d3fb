// Measurements against the raster that a scene was built of, and against PROJ's geod, which shares no code with the page's geodesics.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Terrain } from '@foreland/client';
import { makeFolder, makeSceneOnEarth, on_earth, openSources, runForeland, startServer } from './support.mjs';

const kTest = { timeout: 180_000 };
let folder, sources, earth, profile, area, files, measurement;

before(async () => {
  folder = await makeFolder();
  sources = await openSources();
  [earth, profile, area, files, measurement] = await Promise.all(
    ['earth', 'profile', 'area', 'measurement_files', 'measurement'].map((name) => sources.load(`measure/${name}.ts`)));
}, kTest);
after(async () => {
  await sources?.close();
  await folder?.remove();
});

// Numbers from 0 to 1, of a seed.
function random(seed) {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}

const geod = (args, lines) => execFileSync('geod', args, { input: `${lines.join('\n')}\n` }).toString().trim().split('\n').map((line) => line.trim().split(/\s+/).map(Number));

test('distances on the ellipsoid are those of PROJ to a part in 10^9, and lines go where they say', kTest, () => {
  const next = random(7), globe = earth.earthOf({ frame: 'geographic' });
  const pairs = Array.from({ length: 1000 }, () => [0, 1].map(() => ({ lat: 178 * next() - 89, lon: 360 * next() - 180 })));
  const theirs = geod(['+ellps=WGS84', '-I', '-F', '%.6f', '-f', '%.9f'], pairs.map(([a, b]) => `${a.lat} ${a.lon} ${b.lat} ${b.lon}`));
  pairs.forEach(([a, b], i) => {
    const metres = globe.distance(a, b);
    assert.ok(Math.abs(metres - theirs[i][2]) <= 1e-9 * metres + 1e-6, `${JSON.stringify([a, b])}: ${metres}, ${theirs[i][2]}`);
    const line = globe.along(a, b, 5);
    line.slice(1).forEach((place, k) => assert.ok(Math.abs(globe.distance(line[k], place) - metres / 4) < 1e-6));
    assert.ok(globe.distance(line[4], b) < 1e-6);
  });
});

test('what is offset is as far away as asked, in its direction; areas of small squares are those of the plane', () => {
  const next = random(11);
  for (const frame of ['geographic', 'planar']) {
    const on = earth.earthOf({ frame });
    for (let i = 0; i < 200; ++i) {
      const at = frame === 'planar' ? { easting: 1e6 * next(), northing: 1e6 * next() } : { lat: 160 * next() - 80, lon: 360 * next() - 180 };
      const [east, north] = [2000 * next() - 1000, 2000 * next() - 1000];
      const [e, n] = on.towards(at, on.offset(at, east, north));
      assert.ok(Math.hypot(e - east, n - north) < 1e-6, `${e}, ${n}`);
      const square = [[0, 0], [100, 0], [100, 100], [0, 100]].map(([x, y]) => on.offset(at, x, y));
      for (const ring of [square, [...square].reverse()]) assert.ok(Math.abs(on.area(ring) / 1e4 - 1) < 2e-6, `${on.area(ring)}`);
    }
  }
});

// Exact answers of a session whose scene is a function of where one is.
function fakeTerrain(frame, heightAt) {
  return {
    scene: { frame, bounds: { low: [0, 0, 0], high: [1000, 1000, 100] }, samples: [100, 100], vertical: { above: 'unstated' } },
    heights: async (places) => Float64Array.from(places, heightAt),
    bothHeights: async (places) => places.map((place) => ({ height: heightAt(place), aboveSea: null, aboveEllipsoid: null })),
    toScene: (place) => [place.easting, place.northing, place.height],
  };
}

test('slope, aspect, area on the slope and volume of ground whose figures are known', async () => {
  const tilted = fakeTerrain('planar', ({ easting }) => 0.75 * easting);
  const at = (easting, northing) => ({ easting, northing });
  const { slope } = await measurement.measure(tilted, [at(500, 500)]);
  assert.ok(Math.abs(slope.slope_rad - Math.atan(0.75)) < 1e-9);
  assert.ok(Math.abs(slope.aspect_rad - 1.5 * Math.PI) < 1e-9, 'it falls to the west');
  const square = [at(100, 100), at(500, 100), at(500, 500), at(100, 500)];
  const flat = (await measurement.measure(tilted, square)).area;
  assert.ok(Math.abs(flat.plane_m2 - 160_000) < 1e-6 && Math.abs(flat.slope_m2 - 200_000) < 1e-3, JSON.stringify(flat));
  assert.ok(flat.above_m3 + flat.below_m3 < 1e-3, 'nothing lies above the plane of what is one');

  // A pyramid of 400 x 400 x 100 metres has a third of its box.
  const pyramid = fakeTerrain('planar', ({ easting, northing }) => Math.max(0, 100 - Math.max(Math.abs(easting - 300), Math.abs(northing - 300)) / 2));
  const { area: heap, profile: line, straight_m } = await measurement.measure(pyramid, square);
  assert.ok(Math.abs(heap.above_m3 / ((160_000 * 100) / 3) - 1) < 0.01 && heap.below_m3 === 0, JSON.stringify(heap));
  assert.ok(Math.abs(line.length_m - 1200) < 1e-9 && line.rise_m === 0 && straight_m === 400);
  const over = (await measurement.measure(pyramid, [at(100, 300), at(500, 300)])).profile;
  assert.ok(Math.abs(over.rise_m - 100) < 1e-9 && Math.abs(over.fall_m - 100) < 1e-9 && Math.abs(over.surface_m - 2 * Math.hypot(200, 100)) < 1e-9, JSON.stringify([over.rise_m, over.surface_m]));
});

test('profiles are the ground of the raster to a centimetre', kTest, async () => {
  const { size, west, south, step, heightOf } = on_earth;
  const server = await startServer(await makeSceneOnEarth(folder.folder));
  const terrain = Terrain.connect(`ws://127.0.0.1:${server.port}/fly`, { lens: { fovY: 1, width: 320, height: 200 } });
  const sampleAt = (i, j) => Math.round(10 * heightOf(i, j)) / 10; // as the raster has it
  const between = (x, y) => {
    const [i, j] = [x, y].map((v) => Math.min(Math.max(Math.floor(v), 0), size - 2)), [u, v] = [x - i, y - j];
    return (1 - v) * ((1 - u) * sampleAt(i, j) + u * sampleAt(i + 1, j)) + v * ((1 - u) * sampleAt(i, j + 1) + u * sampleAt(i + 1, j + 1));
  };
  try {
    await new Promise((resolve, reject) => (terrain.on('scene', resolve), terrain.on('refused', reject)));
    const next = random(23), inside = () => 0.5 + (size - 2) * next();
    let [largest, count] = [0, 0];
    for (let i = 0; i < 200; ++i) {
      const corners = [0, 1].map(() => ({ lat: south + inside() * step, lon: west + inside() * step }));
      const { profile: line } = await measurement.measure(terrain, corners);
      line.places.forEach(({ lon, lat }, k) => (largest = Math.max(largest, Math.abs(line.heights[k] - between((lon - west) / step, (lat - south) / step)))));
      count += line.places.length;
    }
    assert.ok(count > 10_000 && largest < 0.01, `${largest} m off, of ${count}`);
  } finally {
    terrain.close();
    await server.stop();
  }
});

test('what an area gained and lost between two dates is what rose and sank there', kTest, async () => {
  const size = 65, spacing_m = 10, [first, last] = [Date.UTC(2000, 0, 1), Date.UTC(2002, 0, 1)];
  const write = async (name, heightOf) => {
    const rows = Array.from({ length: size }, (_, j) => Array.from({ length: size }, (_, i) => heightOf(i, size - 1 - j).toFixed(2)).join(' ')), path = join(folder.folder, name);
    await writeFile(path, [`ncols ${size}`, `nrows ${size}`, 'xllcenter 0', 'yllcenter 0', `cellsize ${spacing_m}`, ...rows].join('\n') + '\n');
    return path;
  };
  // A heap of 20 x 20 samples and 30 m rises in the west, and one of 10 m sinks in the east; the ground below them is rough.
  const heap = (i, j, middle) => Math.max(0, 1 - Math.max(Math.abs(i - middle), Math.abs(j - 32)) / 10), rough = (i, j) => 100 + 5 * Math.sin(i) * Math.cos(j / 2);
  const before = await write('before.asc', (i, j) => rough(i, j) + 10 * heap(i, j, 48)), after = await write('after.asc', (i, j) => rough(i, j) + 30 * heap(i, j, 16));
  const scene = join(folder.folder, 'heaps.fls'), pyramid_m3 = (200 * 200) / 3;
  await runForeland('build', before, '--vertical-step', '0.01', '--epoch', `2000-01-01=${before}`, '--epoch', `2002-01-01=${after}`, '-o', scene);
  const server = await startServer(scene), terrain = Terrain.connect(`ws://127.0.0.1:${server.port}/fly`, { lens: { fovY: 1, width: 320, height: 200 } });
  try {
    await new Promise((resolve, reject) => (terrain.on('scene', resolve), terrain.on('refused', reject)));
    const ring = [[40, 40], [600, 40], [600, 600], [40, 600]].map(([easting, northing]) => ({ easting, northing }));
    const between = async (since_ms, until_ms) => (await measurement.measure(terrain, ring, { since_ms, until_ms })).change;
    const near = (value, truth) => assert.ok(Math.abs(value / truth - 1) < 0.01, `${value}, ${truth}`);
    const change = await between(first, last), back = await between(last, first), half = await between(first, (first + last) / 2);
    near(change.gained_m3, 30 * pyramid_m3);
    near(change.lost_m3, 10 * pyramid_m3);
    near(back.gained_m3, change.lost_m3);
    near(back.lost_m3, change.gained_m3);
    near(half.gained_m3, change.gained_m3 / 2);
    assert.deepEqual(await between(last, last), { since_ms: last, until_ms: last, gained_m3: 0, lost_m3: 0 });
  } finally {
    terrain.close();
    await server.stop();
  }
});

test('files have what was measured', () => {
  const line = profile.profileOf({ places: [{ lat: 46, lon: 8 }, { lat: 46.5, lon: 8 }], distances: [0, 10] }, [3, NaN]);
  assert.equal(files.csvOf(line), 'longitude,latitude,distance_m,height_m\n8.000000000,46.000000000,0.000,3.000\n8.000000000,46.500000000,10.000,\n');
  const ring = [[0, 0], [1, 0], [1, 1]].map(([easting, northing]) => ({ easting, northing }));
  const { crs, features: [{ geometry, properties }] } = JSON.parse(files.geoJsonOf(ring, [1, 2, 3], 'EPSG:26910', { plane_m2: 0.5 }, true));
  assert.equal(crs.properties.name, 'EPSG:26910');
  assert.deepEqual(geometry, { type: 'Polygon', coordinates: [[[0, 0, 1], [1, 0, 2], [1, 1, 3], [0, 0, 1]]] });
  assert.deepEqual(properties, { plane_m2: 0.5 });
});
