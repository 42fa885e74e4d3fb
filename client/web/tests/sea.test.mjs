// The sea of a globe in the page, in headless Chromium against the real server: where it is water, judged by heights that `foreland heights`
// tells above the geoid of PROJ's grid.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { bin, islands, makeFolder, makeGlobe, openBrowser, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 280_000 };
const kSize = { width: 240, height: 180 }, kTan = Math.tan((27.5 * Math.PI) / 180), kPixel_rad = (2 * kTan) / kSize.height;
const kAxis = 6378137, kFlat = 1 / 298.257223563, kRadians = Math.PI / 180;
let folder, server, browser, scene, geoid;

before(async () => {
  folder = await makeFolder();
  scene = await makeGlobe(folder.folder, ['--vertical', 'egm96', '--sea', '--inset', await makeCoast(folder.folder)]);
  server = await startServer(scene);
  browser = await openBrowser();
  const grid = await readFile('/usr/share/proj/egm96_15.gtx');
  geoid = (lat, lon) => grid.readFloatBE(40 + 4 * (Math.round((lat + 90) * 4) * 1440 + (Math.round((lon + 180) * 4) % 1440)));
}, kTest);
after(async () => {
  await browser?.close();
  await server?.stop();
  await folder?.remove();
});

// Bays and islands at the southern coast of the island at 46 N 10 E, which lies 2.5 degrees from its top.
async function makeCoast(folder) {
  const { depth, top } = islands, file = join(folder, 'Coast.asc'), lines = ['ncols 201', 'nrows 201', 'xllcenter 9', 'yllcenter 42.5', 'cellsize 0.01'];
  for (let j = 200; j >= 0; --j)
    lines.push(Array.from({ length: 201 }, (_, i) => {
      const [lat, lon] = [42.5 + j / 100, 9 + i / 100], away = Math.hypot(46 - lat, (10 - lon) * Math.cos(lat * kRadians)) / 2.5;
      const swell = 60 * Math.sin((2 * Math.PI * lat) / 0.23) * Math.cos((2 * Math.PI * lon) / 0.31);
      return ((depth + top) * Math.exp(-(away ** 2) * Math.log((depth + top) / depth)) - depth + swell).toFixed(1);
    }).join(' '));
  await writeFile(file, lines.join('\n') + '\n');
  return file;
}

// Light from behind the camera, which looks north: nothing glitters.
const visit = (query, body) => visitPage(browser, new URL(`?sharpness=1&fog=0&ground=plain&sun=free&azimuth=180&height=40&${query}`, server.url), body, kSize);
const pixels = (page) => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => {
  const canvas = document.getElementById('scene'), copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
  copy.drawImage(canvas, 0, 0);
  resolve([...copy.getImageData(0, 0, canvas.width, canvas.height).data]);
})));
const rgbAt = (data, x, y) => data.slice(4 * (y * kSize.width + x), 4 * (y * kSize.width + x) + 3);
const isWater = ([r, , b]) => b > 1.25 * r && b > 12;
const isLand = ([r, , b]) => r > 40 && b < 1.2 * r;

// Heights above the sea at places, by a program that knows nothing of the page.
async function heightsAbove(places) {
  const child = spawn(join(bin, 'foreland'), ['heights', scene], { stdio: ['pipe', 'pipe', 'inherit'] }), chunks = [];
  child.stdout.on('data', (chunk) => chunks.push(chunk));
  child.stdin.end(places.map(([lat, lon]) => `${lon},${lat}`).join('\n') + '\n');
  await new Promise((done) => child.once('close', done));
  const [head, ...lines] = Buffer.concat(chunks).toString().trim().split('\n').map((line) => line.split(',')), column = head.indexOf('above_sea_m');
  assert.equal(lines.length, places.length);
  return lines.map((line) => Number(line[column]));
}
// Where the ray of a pixel meets the ellipsoid raised by `raised_m`: latitude, longitude, distance; null beside it.
function seenAt({ eye, heading, pitch }, x, y, raised_m) {
  const e2 = kFlat * (2 - kFlat), lon = Math.atan2(eye[1], eye[0]);
  let lat = Math.atan2(eye[2], Math.hypot(eye[0], eye[1]) * (1 - e2));
  for (let i = 0; i < 6; ++i) lat = Math.atan2(eye[2] + (e2 * kAxis * Math.sin(lat)) / Math.sqrt(1 - e2 * Math.sin(lat) ** 2), Math.hypot(eye[0], eye[1]));
  const [s, c, sl, cl] = [Math.sin(lat), Math.cos(lat), Math.sin(lon), Math.cos(lon)], east = [-sl, cl, 0], north = [-s * cl, -s * sl, c], up = [c * cl, c * sl, s];
  const mix = (...terms) => [0, 1, 2].map((k) => terms.reduce((sum, [v, w]) => sum + w * v[k], 0));
  const level = mix([east, Math.sin(heading)], [north, Math.cos(heading)]), ahead = mix([level, Math.cos(pitch)], [up, Math.sin(pitch)]);
  const right = mix([east, Math.cos(heading)], [north, -Math.sin(heading)]), above = mix([level, -Math.sin(pitch)], [up, Math.cos(pitch)]);
  const ray = mix([ahead, 1], [right, (x + 0.5 - kSize.width / 2) * kPixel_rad], [above, (kSize.height / 2 - y - 0.5) * kPixel_rad]), length = Math.hypot(...ray);
  const axes = [1, 1, (kAxis + raised_m) / (kAxis * (1 - kFlat) + raised_m)], d = ray.map((v, k) => (v * axes[k]) / length), o = eye.map((v, k) => v * axes[k]);
  const [a, b, power] = [d.reduce((sum, v) => sum + v * v, 0), d.reduce((sum, v, k) => sum + v * o[k], 0), o.reduce((sum, v) => sum + v * v, 0) - (kAxis + raised_m) ** 2], square = b * b - a * power;
  if (square < 0 || b > 0) return null;
  const distance = (-b - Math.sqrt(square)) / a, at = mix([eye, 1], [ray, distance / length]);
  return { lat: Math.atan2(at[2], Math.hypot(at[0], at[1]) * (1 - e2)) / kRadians, lon: Math.atan2(at[1], at[0]) / kRadians, distance };
}
// Every sixth pixel's place on the sea.
async function judged(page, raised_m) {
  const view = await status(page), found = [];
  for (let y = 3; y < kSize.height; y += 6)
    for (let x = 3; x < kSize.width; x += 6) {
      const at = seenAt(view, x, y, raised_m);
      if (at) found.push({ x, y, ...at });
    }
  const heights_m = await heightsAbove(found.map(({ lat, lon }) => [lat, lon]));
  return found.map((at, i) => ({ ...at, above_m: heights_m[i] }));
}
const settled = async (page) => {
  await until(page, (s) => s.sea && s.triangles > 100 && s.relief_shown > 0);
  const { keyframes } = await status(page);
  await until(page, (s, from) => s.keyframes > from + 4, keyframes);
};

test('water is what lies below the geoid, to the tolerance, from afar and from near', kTest, async () => {
  for (const [view, raised] of [['46,10,900000,0,-89', [46, 10]], ['43.46,10,220,0,-8', [43.5, 10]]])
    await visit(`at=${view}`, async (page) => {
      await settled(page);
      const data = await pixels(page), places = await judged(page, geoid(...raised)), tally = { water: 0, land: 0 };
      for (const { x, y, distance, above_m } of places) {
        // Of the mesh its guarantee, and nine tenths of that for its bend; of tiles half a step, and what the steepest ground rises in two pixels.
        const pixel_m = kPixel_rad * distance, mesh_m = 1.9 * pixel_m, tiles_m = 4 + 2 * 0.03 * pixel_m;
        if (Math.abs(above_m) < (pixel_m > 8 ? tiles_m : Math.max(mesh_m, pixel_m > 4 ? tiles_m : 0)) + 1e-4 * distance) continue;
        const rgb = rgbAt(data, x, y), what = isWater(rgb) ? 'water' : isLand(rgb) ? 'land' : 'neither';
        assert.equal(what, above_m < 0 ? 'water' : 'land', `${view}: ${rgb} at ${x}, ${y}, ${above_m} m above the sea, ${distance} m away`);
        ++tally[what];
      }
      assert.ok(tally.water > 100 && tally.land > 20, `${view}: ${JSON.stringify(tally)}`);
    });
});

test('the sea has its own horizon, ends what is seen, and can be left out', kTest, () =>
  visit('at=25,-40,110,0,0', async (page) => {
    await settled(page);
    const raised_m = geoid(25, -40), view = await status(page), x = kSize.width / 2, data = await pixels(page);
    let horizon = 0;
    while (!seenAt(view, x, horizon, raised_m)) ++horizon;
    assert.ok(horizon > kSize.height / 2 && horizon < kSize.height / 2 + 8, `${horizon}`);
    for (let y = horizon + 1; y < kSize.height; y += 5) assert.ok(isWater(rgbAt(data, x, y)), `${rgbAt(data, x, y)} at ${y}, the horizon at ${horizon}`);
    assert.ok(Math.max(...rgbAt(data, x, horizon - 2)) < 6, `${rgbAt(data, x, horizon - 2)} above it`);
    // What is pointed at is the sea, to the undulations' step.
    const { distance } = seenAt(view, x, 150, raised_m), point = await page.evaluate(([x, y]) => window.foreland.groundAt(x, y), [x + 0.5, 150.5]);
    const pointed_m = Math.hypot(...point.map((v, k) => v - view.eye[k]));
    assert.ok(Math.abs(pointed_m - distance) < (0.03 * distance) / 100, `${pointed_m} m, ${distance} m`);
    assert.ok(Math.abs(view.above_ground_m - (110 - raised_m)) < 1, `${view.above_ground_m} m above`);
    // The window has no room for the open panel.
    assert.equal(await page.evaluate(() => {
      const input = document.querySelector('#panel [name=sea]');
      input.click();
      return input.closest('.row').hidden;
    }), false);
    await until(page, (s) => !s.sea && s.above_ground_m > 2900);
    const floor = await pixels(page);
    assert.ok(Math.max(...rgbAt(floor, x, horizon + 2)) < 6, 'the floor ends below');
    assert.ok(isLand(rgbAt(floor, x, kSize.height - 5)), `${rgbAt(floor, x, kSize.height - 5)} is the floor`);
  }));
