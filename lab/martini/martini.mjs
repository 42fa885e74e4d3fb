// Measures MARTINI for `foreland bench refine`.
//
//   node martini.mjs HEIGHTS SIZE REQUESTS
//
// HEIGHTS: SIZE x SIZE floats, metres. REQUESTS: JSON list of {triangles, max_error_m}; the mesh is that whose triangle count comes
// nearest to `triangles`, or that of `max_error_m` if `triangles` is 0. Prints a report as JSON (the fields: rival.h). Times are
// processor time of this process, which runs one thread (--single-threaded), medians.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const kEnoughTotal_ms = 1500, kFewest = 5, kMax = 41; // repetitions of a measurement

// The ES module that the package has for bundlers is faster than what node takes by itself, and MARTINI shall show its best; node
// does not know it for a module, so it is handed over as text.
const require = createRequire(import.meta.url);
const source = readFileSync(require.resolve('@mapbox/martini/index.js'), 'utf8');
const { default: Martini } = await import(`data:text/javascript,${encodeURIComponent(source)}`);
const { version } = require('@mapbox/martini/package.json');

const processorTime_ms = () => {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1000;
};

function timed(work) {
  const begin = processorTime_ms();
  const result = work();
  return { ms: processorTime_ms() - begin, result };
}

function median(values) {
  return values.slice().sort((a, b) => a - b)[values.length >> 1];
}

function medianTime_ms(work) {
  const times = [];
  let total = 0;
  while (times.length < kFewest || (times.length < kMax && total < kEnoughTotal_ms)) {
    times.push(timed(work).ms);
    total += times[times.length - 1];
  }
  return median(times);
}

const triangleCount = (mesh) => mesh.triangles.length / 3;

// Bisection: the count falls as the error grows. Ends within half a percent, or as near as the heights' quanta allow.
function errorForTriangles(tile, wanted) {
  let low = 0, high = tile.errors.reduce((a, b) => Math.max(a, b), 0);
  let best = { error: high, distance: Infinity };
  for (let i = 0; i < 30 && best.distance > 0.005 * wanted; i++) {
    const error = (low + high) / 2;
    const count = triangleCount(tile.getMesh(error));
    if (Math.abs(count - wanted) < best.distance) best = { error, distance: Math.abs(count - wanted) };
    if (count > wanted) low = error;
    else high = error;
  }
  return best.error;
}

// Largest difference in height between the mesh and the samples: each sample in each triangle's box, by barycentric coordinates.
function trueError(mesh, heights, size) {
  const { vertices: v, triangles: t } = mesh;
  let largest = 0;
  for (let i = 0; i < t.length; i += 3) {
    const ax = v[2 * t[i]], ay = v[2 * t[i] + 1];
    const bx = v[2 * t[i + 1]], by = v[2 * t[i + 1] + 1];
    const cx = v[2 * t[i + 2]], cy = v[2 * t[i + 2] + 1];
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    const ha = heights[ay * size + ax], hb = heights[by * size + bx], hc = heights[cy * size + cx];
    for (let y = Math.min(ay, by, cy); y <= Math.max(ay, by, cy); y++) {
      for (let x = Math.min(ax, bx, cx); x <= Math.max(ax, bx, cx); x++) {
        const b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area;
        const c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area;
        if (b < 0 || c < 0 || b + c > 1) continue;
        largest = Math.max(largest, Math.abs(ha + b * (hb - ha) + c * (hc - ha) - heights[y * size + x]));
      }
    }
  }
  return largest;
}

function measure(tile, request, heights, size) {
  const error = request.triangles > 0 ? errorForTriangles(tile, request.triangles) : request.max_error_m;
  const mesh = tile.getMesh(error);
  const triangles = triangleCount(mesh);
  const ms = medianTime_ms(() => tile.getMesh(error));
  return { max_error_m: error, true_error_m: trueError(mesh, heights, size), triangles, ms, mtri_per_s: triangles / (1000 * ms) };
}

const [file, size_text, requests_text] = process.argv.slice(2);
const size = Number(size_text);
const bytes = readFileSync(file);
const heights = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
const { ms: tables_ms, result: martini } = timed(() => new Martini(size));
const { ms: tile_ms, result: tile } = timed(() => martini.createTile(heights));
const report = {
  version,
  node: process.versions.node,
  grid_size: size,
  tables_ms,
  tile_ms,
  clear_ms: medianTime_ms(() => martini.indices.fill(0)),
  meshes: JSON.parse(requests_text).map((request) => measure(tile, request, heights, size)),
};
console.log(JSON.stringify(report));
