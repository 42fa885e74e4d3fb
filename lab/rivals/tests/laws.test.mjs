// Laws of what needs no browser: tiles say what the ground is, and the judge is right about meshes whose error is known.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { test } from 'node:test';
import { gunzipSync } from 'node:zlib';
import sharp from 'sharp';
import { cutQuantizedMesh } from '../cut_tiles.mjs';
import { axesOf, earthOf } from '../earth.mjs';
import { groundOf } from '../ground.mjs';
import { cameraOf, compare, drawnBy, indexMesh, pointsSeen } from '../judge.mjs';
import { finestLevel, heightError, kCells, layerJson, tileBounds, tilesOver } from '../quantized_mesh.mjs';
import { MeshJournal } from '../pages/mesh_journal.mjs';
import { poseBetween } from '../poses.mjs';
import { between } from '../processor_times.mjs';
import { coarserTolerance, overForeland } from '../rivals.mjs';
import { decodeTexel, finestRgbLevel, kStep_m, kTexels, losslessWebp, rgbTexels, rgbTilesOver } from '../terrain_rgb.mjs';

const { default: decode } = createRequire(import.meta.url)('@here/quantized-mesh-decoder');

const about = { width: 181, height: 121, west_deg: 8, south_deg: 46, step_deg: [1 / 1200, 1 / 1200], semi_major_m: 6378137, flattening: 1 / 298.257223563, origin_deg: [8.07, 46.05], origin_height_m: 0 };
const heights = Float64Array.from({ length: about.width * about.height }, (_, n) => {
  const [i, j] = [n % about.width, Math.floor(n / about.width)];
  return 1200 + 500 * Math.sin(i / 17) * Math.cos(j / 13) + 90 * Math.sin((i + 2 * j) / 5);
});
const ground = groundOf(about, heights), earth = earthOf(about), radians = (v) => (v * Math.PI) / 180;
const lens = { fov_rad: Math.PI / 3, width_px: 1920, height_px: 1080 };

// Northward and down by `pitch`, from the ground's southern edge.
function pose(pitch) {
  const half = 0.5 * (Math.PI / 2 - pitch);
  return { eye: [0, -5000, 3500], orientation: [Math.sin(half), 0, 0, Math.cos(half)] };
}

// The ground as one mesh, each vertex so much too high.
function meshOfGround(lifted_m) {
  const [places, scene, indices] = [[], [], []], { width, height } = about;
  for (let j = 0; j < height; ++j)
    for (let i = 0; i < width; ++i) {
      const [lon, lat] = [ground.west + i * ground.dx, ground.south + j * ground.dy], v = j * width + i;
      places.push(lon, lat);
      scene.push(...earth.ecefToScene(earth.toEcef(lon, lat, heights[v] + lifted_m)));
      if (i + 1 < width && j + 1 < height) indices.push(v, v + 1, v + width, v + width, v + 1, v + width + 1);
    }
  return indexMesh({ places: Float64Array.from(places), scene: Float64Array.from(scene), indices: Uint32Array.from(indices) });
}

test('places on the earth come back', () => {
  for (const place of [[8.1, 46.02, 4000], [-122, -40, -100], [179.9, 80, 90_000]]) {
    const [lon, lat, height] = earth.toGeodetic(earth.toEcef(radians(place[0]), radians(place[1]), place[2]));
    const off = earth.toEcef(lon, lat, height).map((v, i) => v - earth.toEcef(radians(place[0]), radians(place[1]), place[2])[i]);
    assert.ok(Math.hypot(...off) < 1e-6, `${place}`);
    const there = earth.toEcef(radians(place[0]), radians(place[1]), place[2]), back = earth.sceneToEcef(earth.ecefToScene(there));
    assert.ok(Math.hypot(...back.map((v, i) => v - there[i])) < 1e-6);
  }
  assert.ok(Math.hypot(...earth.ecefToScene(earth.toEcef(radians(8.07), radians(46.05), 0))) < 1e-6, 'the origin');
});

test('the ground is what its samples are, at them', () => {
  for (const [i, j] of [[0, 0], [180, 120], [77, 3]]) {
    const [lon, lat, height] = ground.nearest(ground.west + i * ground.dx, ground.south + j * ground.dy);
    assert.equal(height, heights[j * about.width + i]);
    assert.ok(Math.abs(ground.heightAt(lon, lat) - height) < 1e-6);
  }
  assert.equal(ground.nearest(ground.east + 2 * ground.dx, ground.south), null);
});

test('a tile of quantized-mesh decodes to the ground, within half a step of its heights', () => {
  const tiles = cutQuantizedMesh(ground, earth), finest = finestLevel(ground);
  assert.ok(Math.PI / 2 ** finest / kCells <= ground.dx, 'the finest level is as dense as the data');
  let judged = 0;
  for (const level of [5, finest - 1, finest]) {
    const { startX, startY } = tilesOver(ground, level), { west, south, east, north } = tileBounds(level, startX, startY);
    const { header, vertexData, triangleIndices } = decode(new Uint8Array(gunzipSync(tiles.get(`/quantized/${level}/${startX}/${startY}.terrain`).body)).buffer);
    const count = vertexData.length / 3, within = heightError(header.minHeight, header.maxHeight);
    assert.equal(count, (kCells + 1) ** 2);
    assert.equal(triangleIndices.length, 6 * kCells ** 2);
    for (let v = 0; v < count; ++v, ++judged) {
      const [i, j] = [vertexData[v], vertexData[count + v]].map((q) => Math.round((q * kCells) / 32767));
      const truth = ground.heightAt(west + (i * (east - west)) / kCells, south + (j * (north - south)) / kCells);
      const height = header.minHeight + (vertexData[2 * count + v] * (header.maxHeight - header.minHeight)) / 32767;
      assert.ok(Math.abs(height - truth) <= within, `level ${level}, vertex ${i}, ${j}: ${height} for ${truth}`);
    }
    let area = 0; // of the square from 0 to 32767, that the triangles cover once
    for (let t = 0; t < triangleIndices.length; t += 3) {
      const [a, b, c] = [0, 1, 2].map((k) => [vertexData[triangleIndices[t + k]], vertexData[count + triangleIndices[t + k]]]);
      area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    }
    assert.equal(area, 32767 ** 2);
  }
  assert.equal(judged, 3 * (kCells + 1) ** 2);
});

test('whatever layer.json promises is there', () => {
  const tiles = cutQuantizedMesh(ground, earth), { available } = layerJson(ground, finestLevel(ground));
  available.forEach((ranges, level) => {
    const { startX, startY, endX, endY } = Array.isArray(ranges) ? ranges[0] : ranges;
    for (let y = startY; y <= endY; ++y) for (let x = startX; x <= endX; ++x) assert.ok(tiles.has(`/quantized/${level}/${x}/${y}.terrain`), `${level}/${x}/${y}`);
  });
});

test('a terrain-RGB tile decodes to the ground at the middles of its texels, within half a step', async () => {
  const level = finestRgbLevel(ground), { startX, startY, endX, endY } = rgbTilesOver(ground, level), [x, y] = [startX, endY], n = 2 ** level;
  assert.ok(startX <= endX && startY <= endY);
  const { data, info } = await sharp(await losslessWebp(rgbTexels(level, x, y, ground))).removeAlpha().raw().toBuffer({ resolveWithObject: true });
  assert.deepEqual([info.width, info.height, info.channels], [kTexels, kTexels, 3]);
  for (let t = 0; t < kTexels * kTexels; t += 7) {
    const [u, v] = [(x + ((t % kTexels) + 0.5) / kTexels) / n, (y + (Math.floor(t / kTexels) + 0.5) / kTexels) / n];
    const truth = ground.heightAt((u - 0.5) * 2 * Math.PI, Math.atan(Math.sinh((0.5 - v) * 2 * Math.PI)));
    assert.ok(Math.abs(decodeTexel(data[3 * t], data[3 * t + 1], data[3 * t + 2]) - truth) <= 0.5 * kStep_m + 1e-6, `texel ${t}`);
  }
});

test('the judge finds no error in the truth', () => {
  const mesh = meshOfGround(0);
  for (const pitch of [0.2, 0.5, 0.9]) {
    const camera = cameraOf(pose(pitch), lens), points = pointsSeen(camera, ground, earth);
    assert.ok(points.length > 100, `${points.length} points at a pitch of ${pitch}`);
    const error = compare(camera, points, (point) => point.scene, (point) => drawnBy([mesh], point));
    assert.ok(error.largest < 1e-3, `${error.largest} px`);
    assert.equal(error.uncovered, 0);
    assert.equal(error.seen, points.length);
  }
});

test('corners of triangles without area may be anywhere', () => {
  const square = { places: Float64Array.of(0, 0, 1, 0, 0, 1, 1, 1, 1e9, NaN), scene: Float64Array.of(0, 0, 5, 1, 0, 5, 0, 1, 5, 1, 1, 5, 0, 0, 0) };
  const mesh = indexMesh({ ...square, indices: Uint32Array.of(4, 4, 4, 0, 1, 2, 2, 1, 3) });
  assert.equal(mesh.triangles, 2);
  for (const [x, y] of [[0.2, 0.3], [0.9, 0.7], [0, 0], [1, 1]]) assert.ok(mesh.drawnAt(x, y).every((v, i) => Math.abs(v - [x, y, 5][i]) < 1e-9));
  assert.equal(mesh.drawnAt(1.5, 0.5), null);
});

test('the judge sees how far ground is lifted, and where there is none', () => {
  const camera = cameraOf(pose(0.5), lens), points = pointsSeen(camera, ground, earth), lifted = meshOfGround(3);
  const { squares, largest, seen } = compare(camera, points, (point) => point.scene, (point) => drawnBy([lifted], point));
  const focal = 540 / Math.tan(Math.PI / 6), { right, up, forward } = axesOf(pose(0.5).orientation), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const onScreen = (d) => [right, up].map((axis) => (focal * dot(axis, d)) / dot(forward, d));
  let most = 0;
  for (const { scene } of points) {
    const d = scene.map((v, i) => v - camera.eye[i]), [from, to] = [onScreen(d), onScreen([d[0], d[1], d[2] + 3])]; // the vertical turns by under a thousandth over this ground
    most = Math.max(most, Math.hypot(to[0] - from[0], to[1] - from[1]));
  }
  assert.ok(Math.abs(largest / most - 1) < 0.01, `${largest} px, not ${most}`);
  assert.ok(Math.sqrt(squares / seen) < largest);
  assert.equal(compare(camera, points, (point) => point.scene, () => null).uncovered, points.length);
});

test('bytes at equal error lie on the line of the logarithms between two flights, and are not guessed beyond them', () => {
  const flight = (quality) => ({ quality, rms_px: 0.3 * quality, bytes: 1e6 * quality ** -1.5 }), theirs = [4, 1, 2, 8].map(flight);
  const finer = overForeland(theirs, [{ quality: 1, rms_px: 0.9, bytes: 1e5 }]);
  assert.ok(Math.abs(finer.bytes_over_foreland - 10 * 3 ** -1.5) < 1e-9);
  assert.equal(finer.at_rms_px, 0.9);
  const ours = [{ quality: 1, rms_px: 0.1, bytes: 1e5 }];
  assert.equal(overForeland(theirs, ours).bytes_over_foreland, null, 'the rival does not come down to our error');
  const tolerance = coarserTolerance(theirs, ours);
  assert.ok(Math.abs(tolerance - 4.5) < 1e-9);
  ours.push({ quality: tolerance, rms_px: 0.1 * tolerance, bytes: 1e5 * tolerance ** -1.5 }); // so we come up to the rival's
  assert.equal(coarserTolerance(theirs, ours), null, 'that is enough');
  const coarser = overForeland(theirs, ours);
  assert.ok(Math.abs(coarser.bytes_over_foreland - 10 * 3 ** 1.5) < 1e-9);
  assert.ok(Math.abs(coarser.at_rms_px - 0.3) < 1e-12);
  assert.equal(coarserTolerance(theirs, [{ quality: 1, rms_px: 0.5, bytes: 1 }]), null);
});

test('a pose between two is unit, at the ends theirs, and turns the shorter way', () => {
  const [from, to] = [pose(0.1), pose(0.5)], back = { ...to, orientation: to.orientation.map((v) => -v) };
  for (const goal of [to, back])
    for (const share of [0, 0.25, 0.5, 1]) {
      const { eye, orientation } = poseBetween(from, goal, share), wanted = pose(0.1 + 0.4 * share);
      assert.ok(Math.abs(Math.hypot(...orientation) - 1) < 1e-12);
      const forward = (q) => axesOf(q).forward;
      assert.ok(Math.hypot(...forward(orientation).map((v, i) => v - forward(wanted.orientation)[i])) < 1e-9, `share ${share}`);
      assert.deepEqual(eye, from.eye.map((v, i) => v + (goal.eye[i] - v) * share));
    }
});

// Meshes of 200 ms, each of which is given 50 ms before it is needed, and takes 30, 10, 5 and 65 ms.
test('a journal tells what each stage of a mesh takes, and how late that makes it', () => {
  const journal = new MeshJournal(), ofWorker = (time) => performance.timeOrigin + time;
  for (let i = 1; i <= 10; ++i) {
    const needed = 200 * i, given = needed - 50, times = { given: ofWorker(given), made: ofWorker(given + 30), posted: ofWorker(given + 40) };
    journal.add({ version: i, to_time_ms: needed + 200, times, terrain: { channels: { index: { data: new Uint32Array(6), ranges: Uint32Array.of(0, 3, 9, 12) } } } }, given + 45);
    for (const [frame, ready] of [[given + 45, i - 1], [given + 110, i]]) journal.frame(ready, { version: ready, guaranteedPx: 1 }, frame, 2);
  }
  const { meshes, bytes, calls, frame_work_ms, decoded, copied, posted, uploaded, late_in_worker, late_in_page, late_on_card } = journal.report(1000);
  assert.deepEqual([meshes, bytes, calls, frame_work_ms], [5, 24, 2, 2]);
  const about = (stage, ms) => (assert.ok(Math.abs(stage.mean_ms - ms) < 0.11), assert.ok(Math.abs(stage.p90_ms - ms) < 0.11));
  for (const [stage, ms] of [[decoded, 30], [copied, 10], [posted, 5], [uploaded, 65], [late_in_worker, -50], [late_in_page, -5], [late_on_card, 60]]) about(stage, ms);
  assert.deepEqual(journal.reportSince(1900, 1), [{ given: 50, made: 80, posted: 90, came: 95, on_card: 160, shown: 160, guaranteed_px: 1, bytes: 24 }]);
});

test('processor time is told by who took it, the most first', () => {
  assert.deepEqual(Object.entries(between({ a: 1, b: 2 }, { a: 1.5, b: 4, c: 0.01, d: 0.3 })), [['b', 2], ['a', 0.5], ['d', 0.3]]);
});
