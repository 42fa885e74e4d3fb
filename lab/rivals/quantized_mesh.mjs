// Cesium's quantized-mesh-1.0 tiles cut from the ground: regular grids of 65 x 65 vertices, as most cutters make them, over the tiling
// of two squares at level 0. Beyond the data the heights of its edge go on, so that no cliff costs bytes. No normals. Written from
// the format's description; tests let a decoder that others made judge it.
import { gzipSync } from 'node:zlib';

export const kCells = 64;
const kMax = 32767;

// Radians. Rows count from the south.
export function tileBounds(level, x, y) {
  const size = Math.PI / 2 ** level;
  return { west: -Math.PI + x * size, south: -Math.PI / 2 + y * size, east: -Math.PI + (x + 1) * size, north: -Math.PI / 2 + (y + 1) * size };
}

// First and last column and row of a level's tiles with data.
export function tilesOver(ground, level) {
  const size = Math.PI / 2 ** level, inside = 1e-9 * size;
  const index = (v, low) => Math.floor((v - low) / size);
  return { startX: index(ground.west + inside, -Math.PI), startY: index(ground.south + inside, -Math.PI / 2), endX: index(ground.east - inside, -Math.PI), endY: index(ground.north - inside, -Math.PI / 2) };
}

export function layerJson(ground, finest) {
  const available = Array.from({ length: finest + 1 }, (_, level) => [level === 0 ? { startX: 0, startY: 0, endX: 1, endY: 0 } : tilesOver(ground, level)]);
  return { tilejson: '2.1.0', format: 'quantized-mesh-1.0', version: '1.0.0', scheme: 'tms', tiles: ['{z}/{x}/{y}.terrain'], projection: 'EPSG:4326',
    bounds: [ground.west, ground.south, ground.east, ground.north].map((v) => (v * 180) / Math.PI), minzoom: 0, maxzoom: finest, available };
}

// The level whose vertices are at least as dense as the data.
export function finestLevel(ground) {
  return Math.ceil(Math.log2(Math.PI / kCells / Math.min(ground.dx, ground.dy)) - 1e-9);
}

// By how much a decoded height may differ from the ground's at the vertex, metres: half a step, and what the header's floats lose.
export const heightError = (low, high) => (0.5 * (high - low)) / kMax + 2 ** -23 * Math.max(Math.abs(low), Math.abs(high));

export function encodeTile(bounds, ground, earth) {
  const mesh = gridOf(bounds, ground);
  const { order, indices } = byFirstUse(mesh.indices, mesh.heights.length);
  const low = Math.fround(mesh.heights.reduce((a, b) => Math.min(a, b))), high = Math.fround(mesh.heights.reduce((a, b) => Math.max(a, b)));
  const side = kCells + 1, step = (k) => Math.round((k * kMax) / kCells);
  const columns = order.map((v) => step(v % side)), rows = order.map((v) => step(Math.floor(v / side)));
  const heights = order.map((v) => (high > low ? Math.min(kMax, Math.max(0, Math.round(((mesh.heights[v] - low) / (high - low)) * kMax))) : 0));
  const edge = (values, value) => indexArray(values.flatMap((v, i) => (v === value ? [i] : [])));
  return Buffer.concat([
    header(bounds, mesh, low, high, earth), uint32(order.length), zigzag(columns), zigzag(rows), zigzag(heights),
    uint32(indices.length / 3), highWater(indices),
    edge(columns, 0), edge(rows, 0), edge(columns, kMax), edge(rows, kMax), // west, south, east, north
  ]);
}

export const compressTile = (tile) => gzipSync(tile, { level: 9 });

function gridOf({ west, south, east, north }, ground) {
  const side = kCells + 1, heights = new Float64Array(side * side), indices = [];
  for (let j = 0; j < side; ++j)
    for (let i = 0; i < side; ++i) heights[j * side + i] = ground.heightAt(west + (i * (east - west)) / kCells, south + (j * (north - south)) / kCells);
  for (let j = 0; j < kCells; ++j)
    for (let i = 0; i < kCells; ++i) {
      const v = j * side + i;
      indices.push(v, v + 1, v + side, v + side, v + 1, v + side + 1);
    }
  return { heights, indices };
}

function byFirstUse(indices, vertices) {
  const place = new Int32Array(vertices).fill(-1), order = [];
  const placed = indices.map((v) => (place[v] < 0 ? (place[v] = order.push(v) - 1) : place[v]));
  return { order, indices: placed };
}

// Centre, heights, bounding sphere, and the point that is below the horizon only if all of the tile is.
function header({ west, south, east, north }, { heights }, low, high, earth) {
  const side = kCells + 1, centre = earth.toEcef(0.5 * (west + east), 0.5 * (south + north), 0.5 * (low + high));
  const towards = unit(scaled(centre, earth));
  let radius = 0, reach = 1;
  for (let v = 0; v < heights.length; ++v) {
    const p = earth.toEcef(west + ((v % side) * (east - west)) / kCells, south + (Math.floor(v / side) * (north - south)) / kCells, heights[v]);
    radius = Math.max(radius, Math.hypot(p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]));
    const by = horizonReach(scaled(p, earth), towards);
    reach = by > 0 ? Math.max(reach, by) : Infinity;
  }
  const out = Buffer.alloc(88);
  const put = (values, at) => values.forEach((v, i) => out.writeDoubleLE(v, at + 8 * i));
  put(centre, 0);
  out.writeFloatLE(low, 24), out.writeFloatLE(high, 28);
  put([...centre, radius], 32);
  put(towards.map((v) => v * Math.min(reach, 100)), 64);
  return out;
}

const unit = (v) => v.map((x) => x / Math.hypot(...v));
const scaled = (p, { radii }) => p.map((x, i) => x / radii[i]);
// How far along `towards` a point must be to be hidden by a unit sphere wherever `p` is; negative where none is far enough.
function horizonReach(p, towards) {
  const length = Math.max(1, Math.hypot(...p)), d = unit(p), along = d[0] * towards[0] + d[1] * towards[1] + d[2] * towards[2];
  const across = Math.sqrt(Math.max(0, 1 - along * along)), cos = 1 / length, sin = Math.sqrt(length * length - 1) * cos;
  return 1 / (along * cos - across * sin);
}

const bytesOf = (array) => Buffer.from(array.buffer);
const uint32 = (value) => bytesOf(Uint32Array.of(value));
const indexArray = (indices) => Buffer.concat([uint32(indices.length), bytesOf(Uint16Array.from(indices))]);
function zigzag(values) {
  let last = 0;
  return bytesOf(Uint16Array.from(values, (v) => { const step = v - last; last = v; return (step << 1) ^ (step >> 31); }));
}
// Relative to the highest index that is used yet.
function highWater(indices) {
  let highest = 0;
  return bytesOf(Uint16Array.from(indices, (v) => { const code = highest - v; if (code === 0) ++highest; return code; }));
}
