// Files of features and the grids that lay them on the ground: what is refused, and that each cell of each level has all that is near it.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { zipSync } from 'fflate';
import { openSources } from './support.mjs';

let sources, read, grids, slices;
before(async () => {
  sources = await openSources();
  [read, grids, slices] = await Promise.all(['read_overlay', 'ground_grid', 'slices'].map((name) => sources.load(`overlay/${name}.ts`)));
});
after(() => sources?.close());

const on_earth = { is_geographic: true, crs: 'EPSG:4326' }, on_map = { is_geographic: false, crs: 'EPSG:26910' };
const bytesOf = (json) => new TextEncoder().encode(typeof json === 'string' ? json : JSON.stringify(json));
const readAs = (json, map = on_earth, name = 'a.geojson') => slices.runInSlices(read.readOverlay(name, bytesOf(json), map));
const lineAt = (coordinates, properties = {}) => ({ type: 'Feature', properties, geometry: { type: 'LineString', coordinates } });

test('GeoJSON is read with simplestyle, whatever its nesting', async () => {
  const { features } = await readAs({
    type: 'FeatureCollection',
    features: [
      lineAt([[8, 46], [8.1, 46.1, 500]], { stroke: '#f00', 'stroke-width': 7, name: 'A way', length: 12 }),
      { type: 'Feature', properties: null, geometry: { type: 'GeometryCollection', geometries: [{ type: 'Point', coordinates: [8, 46] }] } },
      { type: 'Feature', properties: { fill: '#00ff00', 'fill-opacity': 2 }, geometry: { type: 'MultiPolygon', coordinates: [[[[8, 46], [9, 46], [9, 47], [8, 46]]]] } },
    ],
  });
  assert.deepEqual(features.map(({ kind }) => kind), ['line', 'point', 'area']);
  assert.deepEqual(features[0].style.stroke, [1, 0, 0]);
  assert.equal(features[0].style.stroke_px, 7);
  assert.equal(features[0].name, 'A way');
  assert.deepEqual(features[0].properties, { stroke: '#f00', 'stroke-width': '7', name: 'A way', length: '12' });
  assert.deepEqual(features[0].parts, [[{ lon: 8, lat: 46 }, { lon: 8.1, lat: 46.1 }]]);
  assert.equal(features[2].style.fill_opacity, 1);
});

test('what is wrong with a file is said', async () => {
  const refusals = [
    ['hello', /neither GeoJSON, KML, KMZ nor GPX/],
    ['{"type": "Feat', /is no JSON/],
    [lineAt([[46, 100], [46.1, 101]]), /axes seem to be exchanged/],
    [lineAt([[500000, 5200000], [500001, 5200000]]), /not on the earth/],
    [lineAt([[8, 'x'], [8, 46]]), /no pair of numbers/],
    [{ type: 'Topology' }, /type "Topology"/],
    [{ type: 'FeatureCollection', features: 7 }, /something else where a list should be/],
    [{ type: 'FeatureCollection', features: [] }, /no points, lines or areas/],
    [{ ...lineAt([[8, 46], [9, 46]]), crs: { properties: { name: 'EPSG:3857' } } }, /is in EPSG:3857/],
    [nested(40), /in one another/],
  ];
  for (const [json, reason] of refusals) await assert.rejects(readAs(json), reason, JSON.stringify(json).slice(0, 80));
  await assert.rejects(readAs(lineAt([[8, 46], [9, 46]]), on_map), /not in the scene's map \(EPSG:26910\)/);
  const { features } = await readAs({ ...lineAt([[5, 6], [7, 8]]), crs: { properties: { name: 'urn:ogc:def:crs:EPSG::26910' } } }, on_map);
  assert.deepEqual(features[0].parts[0][0], { easting: 5, northing: 6 });
});
function nested(depth) {
  return depth === 0 ? { type: 'Point', coordinates: [8, 46] } : { type: 'GeometryCollection', geometries: [nested(depth - 1)] };
}

test('a packed file that would fill the memory is refused before it is unpacked', async () => {
  const bomb = zipSync({ 'doc.kml': new Uint8Array(80 << 20) }, { level: 9 });
  assert.ok(bomb.length < 1 << 20);
  await assert.rejects(slices.runInSlices(read.readOverlay('bomb.kmz', bomb, on_earth)), /doc\.kml in it has more than 64 MB/);
  await assert.rejects(slices.runInSlices(read.readOverlay('none.kmz', zipSync({ 'a.txt': new Uint8Array(3) }), on_earth)), /has no \.kml in it/);
  await assert.rejects(slices.runInSlices(read.readOverlay('torn.kmz', zipSync({ 'doc.kml': new Uint8Array(999) }).subarray(0, 40), on_earth)), /torn\.kmz/);
});

// Numbers from 0 to 1, of a seed.
function random(seed) {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}
const isInside = (rings, [x, y]) => rings.reduce((odd, ring) => ring.reduce((is, [ax, ay], i) => {
  const [bx, by] = ring[(i + 1) % ring.length];
  return ay > y !== by > y && x < ax + ((bx - ax) * (y - ay)) / (by - ay) ? !is : is;
}, odd), false);
function distanceTo([x, y], [ax, ay, bx, by]) {
  const [dx, dy] = [bx - ax, by - ay], length2 = dx * dx + dy * dy;
  const t = length2 > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / length2, 0), 1) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}

// What a cell says, taken apart.
function itemsOf(grid, cell) {
  const [begin, count] = grid.cells.subarray(2 * cell, 2 * cell + 2), shapes = new Map();
  let shape = null;
  for (const item of grid.items.subarray(begin, begin + count)) {
    const [kind, index] = [item >>> 30, item & 0x3fffffff];
    if (kind === 0) shapes.set(index, (shape = { covers: false, segments: [] }));
    else if (kind === 1) shape.covers = !shape.covers;
    else shape.segments.push(grid.segments.subarray(4 * index, 4 * index + 4));
  }
  return shapes;
}

test('a cell of any level has all lines within its reach, and is inside of what surrounds its middle', async () => {
  const next = random(5);
  const walk = (count, step) => {
    let at = [1000 * next(), 700 * next()];
    return Array.from({ length: count }, () => (at = at.map((v) => v + step * (next() - 0.5))));
  };
  const closed = (line) => [...line, line[0]];
  const style = { stroke: [1, 0, 0], stroke_opacity: 1, stroke_px: 3, fill: [0, 1, 0], fill_opacity: 0.5 };
  const shapes = Array.from({ length: 30 }, (_, feature) => (feature % 3 === 0
    ? { kind: 'area', style, feature, parts: [closed(walk(12, 200)), closed(walk(5, 60))] }
    : { kind: 'line', style, feature, parts: [walk(feature === 1 ? 2 : 60, 30)] }));
  const grid = await slices.runInSlices(grids.buildGroundGrid(shapes));
  const [x0, y0] = grid.origin;
  grid.levels.forEach(({ columns, rows, begin }, level) => {
    const side = grid.cell * 2 ** level;
    for (let tries = 0; tries < 300; ++tries) {
      const [i, j] = [Math.floor(columns * next()), Math.floor(rows * next())];
      const items = itemsOf(grid, begin + j * columns + i);
      // Any place within half a cell of the cell.
      const at = [(i - 0.5 + 2 * next()) * side, (j - 0.5 + 2 * next()) * side], middle = [(i + 0.5) * side, (j + 0.5) * side];
      shapes.forEach(({ kind, parts }, index) => {
        const found = items.get(index) ?? { covers: false, segments: [] };
        const local = parts.map((part) => part.map(([x, y]) => [x - x0, y - y0]));
        const all = local.flatMap((part) => part.slice(1).map((b, k) => [...part[k], ...b]));
        const nearest = Math.min(...all.map((segment) => distanceTo(at, segment)));
        const here = Math.min(...found.segments.map((segment) => distanceTo(at, segment)), Infinity);
        const off = level === 0 ? 1e-3 : side / 16 + 1e-3; // floats; what is simplified
        const inside_of_cell = at[0] >= i * side && at[0] < (i + 1) * side && at[1] >= j * side && at[1] < (j + 1) * side;
        if (inside_of_cell && nearest < 0.5 * side - off) assert.ok(Math.abs(here - nearest) < off, `level ${level}, shape ${index}: ${here}, not ${nearest}`);
        if (kind === 'area' && Math.min(...all.map((segment) => distanceTo(middle, segment))) > off)
          assert.equal(found.covers, isInside(local, middle), `level ${level}, shape ${index}`);
      });
    }
  });
});

test('simplified lines stay within the tolerance of the whole ones', () => {
  const next = random(9);
  for (let tries = 0; tries < 100; ++tries) {
    const line = Array.from({ length: 50 }, (_, i) => [i, 10 * next()]);
    const few = grids.simplified(line, 2);
    assert.ok(few.length < line.length && few[0] === line[0] && few.at(-1) === line.at(-1));
    for (const point of line) assert.ok(Math.min(...few.slice(1).map((b, k) => distanceTo(point, [...few[k], ...b]))) <= 2);
  }
});
