// Overlays in the page: files that are dropped, named in its address or given by the server, where they lie on the screen, and what
// happens to the page when one is bad.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { Terrain } from '@foreland/client';
import { zipSync } from 'fflate';
import { dropFile, makeFolder, makeScene, makeSceneOnEarth, openBrowser, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 600_000 };
const kFov_rad = (55 * Math.PI) / 180; // the page's lens, from below to above
let folder, scene, server, browser;

// Across 301 samples from 8 degrees east and 46 degrees north on.
const line = { stroke: '#ff00ff', 'stroke-width': 3, name: 'A way' };
const zigzag = Array.from({ length: 15 }, (_, i) => [8.04 + 0.012 * i, 46.11 + 0.02 * (i % 2)]);
const feature = (type, coordinates, properties = {}) => ({ type: 'Feature', properties, geometry: { type, coordinates } });
const collection = (...features) => JSON.stringify({ type: 'FeatureCollection', features });

before(async () => {
  folder = await makeFolder();
  scene = await makeSceneOnEarth(folder.folder);
  const huts = join(folder.folder, 'huts & paths.geojson');
  await writeFile(huts, collection(feature('Polygon', [[[8.1, 46.1], [8.15, 46.1], [8.15, 46.15], [8.1, 46.15], [8.1, 46.1]]], { name: 'A reserve', since: 1914 })));
  server = await startServer(scene, 0, ['--overlay', huts]);
  browser = await openBrowser({ has_antialias: true });
}, kTest);
after(async () => {
  await browser?.close();
  await server?.stop();
  await folder?.remove();
});

// Drawn coarsely, because a processor does it, unless the query says otherwise.
const visit = (query, body, { server: at = server, ...options } = {}) =>
  visitPage(browser, new URL(`?${query}&sharpness=0.4&tau=4`, at.url), body, { prepare: (page) => page.setDefaultTimeout(120_000), ...options });
const press = (control) => control.evaluate((element) => element.click()); // does not wait for frames, which take seconds here
const untilLaid = (page, name) => until(page, (s, n) => s.overlays.some((o) => o.name === n) && s.overlays_laid > 0, name, 240_000);

// Pixels of a picture whose colour is that of the line, at least by half.
function linePixels(page, picture) {
  return page.evaluate(async (url) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(url), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data, width, height } = context.getImageData(0, 0, image.width, image.height);
    const found = [];
    for (let y = 0; y < height; ++y)
      for (let x = 0; x < width; ++x) {
        const [r, g, b] = data.subarray(4 * (y * width + x));
        if (Math.min(r, b) - g > 128) found.push([x + 0.5, y + 0.5]);
      }
    return found;
  }, picture.toString('base64'));
}

const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const scaled = (a, factor) => a.map((v) => v * factor);
const plus = (a, b) => a.map((v, i) => v + b[i]);
const unit = (a) => scaled(a, 1 / Math.hypot(...a));

// A pinhole camera of a heading (clockwise from north) and a pitch, degrees, at an eye with a given up.
function cameraOf(eye, up, heading, pitch, { width, height }, tall = 1) {
  const [h, p] = [heading, pitch].map((degrees) => (degrees * Math.PI) / 180);
  const north = unit(plus([0, 1, 0], scaled(up, -up[1]))), east = cross(north, up);
  const level = plus(scaled(east, Math.sin(h)), scaled(north, Math.cos(h)));
  const forward = plus(scaled(level, Math.cos(p)), scaled(up, Math.sin(p)));
  const right = unit(cross(forward, up)), above = cross(right, forward);
  const focal = height / 2 / Math.tan(kFov_rad / 2);
  return (point) => {
    const way = plus(point, scaled(eye, -1)).map((v, i) => (i === 2 ? tall * v : v)), depth = dot(way, forward);
    return [width / 2 + (focal * dot(way, right)) / depth, height / 2 - (focal * dot(way, above)) / depth];
  };
}
function distanceTo([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay], length2 = dx * dx + dy * dy;
  const t = length2 > 0 ? Math.min(Math.max(((x - ax) * dx + (y - ay) * dy) / length2, 0), 1) : 0;
  return Math.hypot(x - ax - t * dx, y - ay - t * dy);
}

// The ground's exact heights along the line, of a session of its own.
async function pointsAlong(coordinates, eye) {
  const terrain = Terrain.connect(`ws://127.0.0.1:${server.port}/fly`, { lens: { fovY: 1, width: 320, height: 200 } });
  try {
    await terrain.ready;
    const places = coordinates.slice(1).flatMap(([lon, lat], i) => Array.from({ length: 60 }, (_, k) => {
      const [from_lon, from_lat] = coordinates[i];
      return { lon: from_lon + ((lon - from_lon) * k) / 60, lat: from_lat + ((lat - from_lat) * k) / 60 };
    }));
    places.push({ lon: coordinates.at(-1)[0], lat: coordinates.at(-1)[1] });
    const heights = await terrain.heights(places);
    return { up: terrain.place(eye).up, points: places.map((place, i) => terrain.toScene({ ...place, height: heights[i] })) };
  } finally {
    terrain.close();
  }
}

// From above, so that no ridge hides the line: its pixels are where the exact ground is seen, and no others.
// So it is where heights are drawn taller.
for (const [eye, heading, pitch, tall] of [[[0, -9000, 12_000], 0, -58, 1], [[6000, -4000, 9000], 317, -64, 1], [[0, -9000, 8000], 0, -62, 2]])
  test(`a dropped line is drawn where its ground is seen, from ${eye}, ${tall} times as tall`, kTest, () =>
    visit(`sharpness=1&tau=0.5&fog=0&exaggeration=${tall}&view=${[...eye, heading, pitch]}`, async (page) => {
      await dropFile(page, 'way.geojson', collection(feature('LineString', zigzag, line)));
      await untilLaid(page, 'way.geojson');
      const { frames } = await until(page, (s) => s.tau_px <= 0.5);
      await until(page, (s, n) => s.frames > n + 3, frames);
      const { up, points } = await pointsAlong(zigzag, eye);
      const { eye: own } = await status(page);
      assert.deepEqual(own, eye);
      const seen = points.map(cameraOf(eye, up, heading, pitch, page.viewportSize(), tall));
      await page.addStyleTag({ content: 'body > :not(#scene) { display: none !important; }' }).catch(() => null);
      const pixels = await linePixels(page, await page.screenshot());
      const inside = seen.filter(([x, y]) => x > 4 && x < page.viewportSize().width - 4 && y > 4 && y < page.viewportSize().height - 4);
      assert.ok(inside.length > 250, `${inside.length} places in view`);
      assert.ok(pixels.length > 400, `${pixels.length} pixels of the line`);
      const lost = inside.filter((at) => !pixels.some((pixel) => Math.hypot(pixel[0] - at[0], pixel[1] - at[1]) <= 1));
      assert.deepEqual(lost, [], 'places that are not drawn');
      const stray = pixels.filter((pixel) => !seen.some((at, i) => i > 0 && distanceTo(pixel, seen[i - 1], at) <= line['stroke-width'] / 2 + 1));
      assert.deepEqual(stray, [], 'pixels beside the line');
    }, { width: 640, height: 400 }));

test('files of the server and of the address lie on the ground; a click tells of them, and rows hide them', kTest, () =>
  visit('overlay=overlays/0.geojson&view=0,0,9000,0,-89', async (page) => {
    await untilLaid(page, 'huts & paths.geojson');
    const { overlays } = await untilLaid(page, '0.geojson');
    assert.deepEqual(overlays.map(({ name }) => name), ['huts & paths.geojson', '0.geojson']);
    await page.mouse.click(480, 270); // 8.125 degrees east and 46.125 north are in the middle
    await page.locator('#feature').getByText('A reserve').waitFor();
    assert.deepEqual(await page.locator('#feature dl').allInnerTexts(), ['since\n1914']);
    await page.keyboard.press('Escape');
    assert.equal(await page.locator('#feature').isVisible(), false);
    for (const name of ['huts & paths.geojson', '0.geojson']) await press(page.locator('#overlays label', { hasText: name }));
    await until(page, (s) => s.overlays.every((o) => !o.is_shown));
    await page.mouse.click(480, 270);
    assert.equal(await page.locator('#feature').isVisible(), false);
    await press(page.getByRole('button', { name: 'Take 0.geojson away' }));
    await until(page, (s) => s.overlays.length === 1);
  }));

test('a bad file is refused in words, and the page goes on', kTest, () =>
  visit('', async (page) => {
    const point = (coordinates) => JSON.stringify({ type: 'Point', coordinates });
    const files = [
      ['swapped.geojson', point([46.1, 8.1]), /axes seem to be exchanged/],
      ['swapped too.geojson', point([46.1, 108.1]), /axes seem to be exchanged/],
      ['map.geojson', point([500000, 5100000]), /not on the earth/],
      ['elsewhere.geojson', point([-120, 40]), /lies outside of this scene/],
      ['empty.gpx', '<gpx xmlns="http://www.topografix.com/GPX/1/1"/>', /has no points, lines or areas/],
      ['bomb.kmz', zipSync({ 'doc.kml': new Uint8Array(80 << 20) }, { level: 9 }), /more than 64 MB/],
      ['notes.txt', 'hello', /notes\.txt is no colour map/],
    ];
    for (const [name, content, reason] of files) {
      await dropFile(page, name, content);
      await page.locator('#notice', { hasText: reason }).waitFor();
      await press(page.locator('#notice button'));
    }
    // Made in the page: it is too large to bring there.
    await page.evaluate(() => {
      const files = new DataTransfer();
      files.items.add(new File(['<kml>', new Uint8Array(50e6).fill(32), '</kml>'], 'large.kml'));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: files, bubbles: true, cancelable: true }));
    });
    await page.locator('#notice', { hasText: /large\.kml has more than 16 MB of XML/ }).waitFor();
    await press(page.locator('#notice button'));
    const { frames } = await status(page);
    await until(page, (s, n) => s.frames > n + 2, frames);
    await dropFile(page, 'good.geojson', point([8.1, 46.1]));
    await untilLaid(page, 'good.geojson');
    // What can be read in some way is, and the page says in which.
    await dropFile(page, 'old.csv', Buffer.from('name,lon,lat\nGöschenen,8.1,46.12\n', 'latin1'));
    await page.locator('#hint', { hasText: /old\.csv is not UTF-8; it was read as Latin-1/ }).waitFor({ state: 'attached' });
    const walk = [0, 1, 2].map((i) => `<trkpt lat="46.1" lon="${8.1 + i / 100}"><ele>3000</ele></trkpt>`).join('');
    await dropFile(page, 'untimed.gpx', `<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>${walk}</trkseg></trk></gpx>`);
    await page.locator('#hint', { hasText: /untimed\.gpx has no times: it is flown at 10 m\/s/ }).waitFor({ state: 'attached' });
  }));

test('an overlay of the address that does not come is said', kTest, () =>
  visit('overlay=nothing.kml&overlay=ftp://a/b.kml', async (page) => {
    await page.locator('#notice', { hasText: /ftp:\/\/a\/b\.kml is no address of the web/ }).waitFor();
    assert.equal((await untilLaid(page, 'huts & paths.geojson')).connected, true);
  }, { expected: /404/ }));

// What it takes is for a measurement: here it must only come.
test('a line of 100,000 places lies on the ground', kTest, () =>
  visit('', async (page) => {
    const walk = Array.from({ length: 100_000 }, (_, i) => [8.12 + 0.1 * Math.sin(i / 900) * (i / 100_000), 46.12 + 0.1 * Math.cos(i / 700)]);
    await dropFile(page, 'walk.geojson', JSON.stringify({ type: 'LineString', coordinates: walk }));
    await untilLaid(page, 'walk.geojson');
  }));

test('a planar scene whose map is not known says so of longitudes', kTest, async () => {
  const plain = await startServer(await makeScene(folder.folder, { size: 129 }));
  try {
    await visit('', async (page) => {
      await dropFile(page, 'a.geojson', JSON.stringify({ type: 'Point', coordinates: [8, 46] }));
      await page.locator('#notice', { hasText: /how the scene.s map \(synthetic landscape\) follows from these is not known here/ }).waitFor();
    }, { server: plain });
  } finally {
    await plain.stop();
  }
});

test('names of a table are written where they are in sight, and not behind a ridge', kTest, () =>
  visit('view=0,0,2600,45,-12', async (page) => {
    const terrain = await Terrain.open(server.url.href.replace('http', 'ws'), { lens: { fovY: kFov_rad, width: 100, height: 100 } });
    try {
      // Everywhere, in Latin-1.
      const places = Array.from({ length: 400 }, (_, i) => ({ name: `Höhe ${i}`, lon: 8.01 + 0.0115 * (i % 20), lat: 46.01 + 0.0115 * Math.floor(i / 20) }));
      await dropFile(page, 'heights.csv', Buffer.from(`name;lon;lat\n${places.map(({ name, lon, lat }) => `${name};${lon.toFixed(5)};${lat.toFixed(5)}`).join('\n')}`, 'latin1'));
      await page.locator('#hint', { hasText: /heights\.csv is not UTF-8; it was read as Latin-1/ }).waitFor({ state: 'attached' });
      const { labels, names, eye } = await until(page, (s) => s.labels.length > 2, null, 240_000);
      assert.equal(names, 400);
      const heights = await terrain.heights(places), from = terrain.toGeodetic(eye);
      const sights = await terrain.visible(places.map(({ lon, lat }, i) => [from, { lon: Number(lon.toFixed(5)), lat: Number(lat.toFixed(5)), height: heights[i] + 3 }]), { refraction: 0 });
      const seen = places.filter((_, i) => sights[i].isSeen).map(({ name }) => name);
      assert.ok(seen.length < 380, `${seen.length} are seen`);
      assert.deepEqual(labels.filter((name) => !seen.includes(name)), []);
      // Without a switch that does nothing.
      await page.locator('[name=labels]').evaluate((control) => control.click());
      await until(page, (s) => s.labels.length === 0);
    } finally {
      await terrain.close();
    }
  }));
