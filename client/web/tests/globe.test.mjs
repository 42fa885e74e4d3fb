// The page over a globe, in headless Chromium against the real server. Every wait is for a condition.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { dropFile, fingersOf, makeFolder, makeGlobe, makeScene, openBrowser, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 280_000 };
const kRadius = 6378137, kTan = Math.tan((27.5 * Math.PI) / 180);
const kSize = { width: 480, height: 360 };
let folder, server, browser;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeGlobe(folder.folder));
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  await server?.stop();
  await folder?.remove();
});

const visit = (query, body, options = {}) => visitPage(browser, new URL(`?sharpness=1&${query}`, server.url), body, { ...kSize, ...options });
// Takes the panels from over the picture.
const bare = (page) => page.evaluate(() => document.querySelectorAll('nav, section, aside, header, p, #compass').forEach((part) => (part.style.display = 'none')));
const groundAt = (page, x, y) => page.evaluate(([x, y]) => window.foreland.groundAt(x, y), [x, y]);
const onScreen = (page, point) => page.evaluate((point) => window.foreland.onScreen(point), point);
const length = (v) => Math.hypot(...v);
const apart = (a, b) => length(a.map((v, i) => v - b[i]));
// Until a frame has been drawn from where the camera is.
const untilDrawn = async (page) => until(page, (s, frames) => s.frames > frames + 1, (await status(page)).frames);
const ecef = (lat, lon, r = kRadius) => [Math.cos(lat) * Math.cos(lon) * r, Math.cos(lat) * Math.sin(lon) * r, Math.sin(lat) * r];

// The pixels of a frame just drawn, RGBA, row by row from above.
function framePixels(page) {
  return page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => {
    const canvas = document.getElementById('scene'), copy = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d');
    copy.drawImage(canvas, 0, 0);
    resolve({ width: canvas.width, height: canvas.height, data: [...copy.getImageData(0, 0, canvas.width, canvas.height).data] });
  })));
}
const bright = ({ data, width }, x, y) => Math.max(...data.slice(4 * (y * width + x), 4 * (y * width + x) + 3));

test('the whole globe is seen at first, as large as it is, with air around it', kTest, () =>
  visit('ground=plain', async (page) => {
    const { eye } = await until(page, (s) => s.air);
    assert.ok(Math.abs(length(eye) - kRadius - 2e7) < 0.5e6, `${length(eye) - kRadius} m high`);
    const radius_px = (kSize.height / 2 / kTan) * Math.tan(Math.asin(kRadius / length(eye))), [x, y] = [kSize.width / 2, kSize.height / 2];
    // Beside the light, from the north-west: the edge of the ground is where the picks end.
    const edge = async (dx, dy) => {
      let [inside, outside] = [0.8 * radius_px, 1.2 * radius_px];
      while (outside - inside > 0.5) {
        const middle = (inside + outside) / 2;
        if (await groundAt(page, x + dx * middle, y + dy * middle)) inside = middle;
        else outside = middle;
      }
      return inside;
    };
    for (const way of [[1, 0], [-1, 0], [0, 1], [0, -1]]) assert.ok(Math.abs((await edge(...way)) - radius_px) < 2, `${await edge(...way)} of ${radius_px}`);
    const picture = await framePixels(page), at = (r) => bright(picture, Math.round(x - 0.707 * r), Math.round(y - 0.707 * r));
    assert.ok(at(0.5 * radius_px) > 60, `ground ${at(0.5 * radius_px)}`);
    assert.ok(at(radius_px + 0.6) > 12, `air ${at(radius_px + 0.6)}`);
    assert.ok(at(1.3 * radius_px) < 3, `space ${at(1.3 * radius_px)}`);
    assert.equal(picture.data.length, 4 * kSize.width * kSize.height);
    await checkArea(page, eye, [x, y], 0.8 * radius_px);
  }));

// An area that is dropped covers what lies in it, over edges and corners of the cube, and nothing else.
async function checkArea(page, eye, middle, reach_px) {
  const placeOf = (v) => [Math.atan2(v[1], v[0]), Math.asin(v[2] / length(v))].map((angle) => (angle * 180) / Math.PI), [lon, lat] = placeOf(eye);
  const low = [lon - 40, Math.max(lat - 30, -80)], high = [lon + 46, Math.min(lat + 20, 80)];
  const ring = [low, [high[0], low[1]], high, [low[0], high[1]], low], style = { stroke: '#00ff00', 'stroke-width': 2, fill: '#00ff00', 'fill-opacity': 1 };
  await dropFile(page, 'area.geojson', JSON.stringify({ type: 'Feature', properties: style, geometry: { type: 'Polygon', coordinates: [ring] } }));
  await until(page, (s) => s.overlays_laid > 0);
  await bare(page);
  await untilDrawn(page);
  const { data, width } = await framePixels(page), counts = [0, 0];
  for (let i = 0; i < 40; ++i) {
    const angle = 2.4 * i, r = reach_px * Math.sqrt((i + 0.5) / 40), [px, py] = [middle[0] + r * Math.cos(angle), middle[1] + r * Math.sin(angle)].map(Math.floor);
    const place = placeOf(await groundAt(page, px + 0.5, py + 0.5)), turned = [lon + (((place[0] - lon + 540) % 360) - 180), place[1]];
    const beside = Math.min(...turned.map((v, k) => Math.min(v - low[k], high[k] - v))), [red, green, blue] = data.slice(4 * (py * width + px), 4 * (py * width + px) + 3);
    if (Math.abs(beside) < 3) continue;
    assert.equal(green - Math.max(red, blue) > 200, beside > 0, `${place}: ${[red, green, blue]}`);
    ++counts[beside > 0 ? 1 : 0];
  }
  assert.ok(Math.min(...counts) > 5, `${counts}`);
}

test('the ground that is grabbed stays under the pointer, and what the wheel nears does', kTest, () =>
  visit('fog=0', async (page) => {
    await bare(page);
    const [x, y] = [200, 150], point = await groundAt(page, x, y), from = await status(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(300, 210, { steps: 3 });
    await page.mouse.up();
    await untilDrawn(page);
    const dragged = await onScreen(page, point);
    assert.ok(Math.hypot(dragged[0] - 300, dragged[1] - 210) < 0.1, dragged.join());
    assert.ok(apart((await status(page)).eye, from.eye) > 1e6);
    const there = await groundAt(page, 300, 210);
    assert.ok(apart(there, point) < 0.02 * (await status(page)).above_ground_m, `${apart(there, point)} m`);
    const { above_ground_m } = await status(page);
    for (let i = 0; i < 4; ++i) await page.mouse.wheel(0, -300);
    await until(page, (s, high) => s.above_ground_m < 0.5 * high, above_ground_m);
    let last;
    await until(page, (s) => s.frames > 0);
    do { last = (await status(page)).eye; await untilDrawn(page); } while (apart((await status(page)).eye, last) > 1);
    // What was drawn when it was pointed at may have been off by the tolerance, a pixel of then.
    const neared = await onScreen(page, there), grown = above_ground_m / (await status(page)).above_ground_m;
    assert.ok(grown > 4 && Math.hypot(neared[0] - 300, neared[1] - 210) < 0.5 + grown, `${neared.join()}, ${grown} times nearer`);
  }));

test('the other button tilts about what it points at', kTest, () =>
  visit('fog=0&at=46,10,800000', async (page) => {
    await bare(page);
    const [x, y] = [kSize.width / 2, kSize.height / 2], point = await groundAt(page, x, y), before = await status(page);
    await page.mouse.move(x, y);
    await page.mouse.down({ button: 'right' });
    await page.mouse.move(x + 20, y - 60, { steps: 3 });
    await page.mouse.up({ button: 'right' });
    await untilDrawn(page);
    const after = await status(page), seen = await onScreen(page, point);
    assert.ok(Math.abs(apart(after.eye, point) / apart(before.eye, point) - 1) < 1e-6);
    assert.ok(after.pitch > before.pitch + 0.3, `${before.pitch} to ${after.pitch}`);
    assert.ok(Math.hypot(seen[0] - x, seen[1] - y) < 1.5, seen.join());
  }));

test('two fingers tilt, turn and near what lies between them', kTest, () =>
  visit('fog=0&at=46,10,800000', async (page) => {
    await bare(page);
    const move = await fingersOf(page), [x, y] = [kSize.width / 2, kSize.height / 2], before = await status(page), point = await groundAt(page, x, y);
    const pair = (gap, angle = 0, up = 0) => [-1, 1].map((side) => [x + side * gap * Math.cos(angle), y - up + side * gap * Math.sin(angle)]);
    const tilted = await move(pair(60), pair(60, 0, 60)), seen = await onScreen(page, point);
    assert.ok(tilted.pitch > before.pitch + 0.3, `${before.pitch} to ${tilted.pitch}`);
    assert.ok(Math.hypot(seen[0] - x, seen[1] - y + 60) < 3, seen.join());
    const held = await groundAt(page, x, y), turned = await move(pair(60), pair(60, 0.5)), still = await onScreen(page, held);
    assert.ok(Math.abs(turned.heading - tilted.heading + 0.5) < 0.05, `${tilted.heading} to ${turned.heading}`);
    assert.ok(Math.hypot(still[0] - x, still[1] - y) < 3, still.join());
    const near = await move(pair(60), pair(120));
    assert.ok(Math.abs((2 * apart(near.eye, held)) / apart(turned.eye, held) - 1) < 0.05, `${apart(turned.eye, held)} m to ${apart(near.eye, held)} m`);
  }, { mobile: true }));

test('a view is shared by latitude and longitude, and coordinates are searched for', kTest, () =>
  visit('fog=0&at=46.5,8.25,30000,60,-40', async (page) => {
    const { eye, heading, pitch } = await status(page), degrees = Math.PI / 180;
    assert.ok(Math.abs(heading - 60 * degrees) < 1e-9 && Math.abs(pitch + 40 * degrees) < 1e-9);
    const up = ecef(46.5 * degrees, 8.25 * degrees, 1);
    assert.ok(Math.abs(Math.asin(eye[2] / length(eye)) - 46.31 * degrees) < 0.001 && Math.abs(Math.atan2(eye[1], eye[0]) - 8.25 * degrees) < 1e-9 && up[2] > 0);
    await page.fill('input[name=place]', '33\u00b030\u2032S 70.5W');
    await page.press('input[name=place]', 'Enter');
    await until(page, (s) => s.eye[2] < 0 && s.triangles > 100);
    await page.waitForURL(/at=-33\.5,-70\.5,20000,0,-90/);
    await page.locator('#readout', { hasText: /33\.50000\u00b0 S\s+70\.50000\u00b0 W/ }).waitFor();
    await page.fill('input[name=place]', 'Santiago');
    await page.press('input[name=place]', 'Enter');
    assert.match(await page.locator('#hint').innerText(), /latitude and a longitude/);
    assert.match(page.url(), /at=-33\.5,-70\.5/);
  }));

test('what there is not on globes has no switch', kTest, () =>
  visit('map=1&exaggeration=3', async (page) => {
    for (const name of ['exaggeration', 'map', 'speed']) assert.equal(await page.locator(`#panel [name=${name}]`).isVisible(), false, name);
    assert.equal(await page.locator('#panel [name=snow_line]').isVisible() || !(await page.locator('#panel .body').isVisible()), true);
    assert.equal(await page.locator('#map').isVisible(), false);
  }));

test('lengths are measured along the ellipsoid, what is beyond the horizon is hidden, and the scale is that of the ground', kTest, () =>
  visit('fog=0&at=46,10,1500000', async (page) => {
    await bare(page);
    const clicks = [[120, 120], [360, 240]], [a, b] = [await groundAt(page, ...clicks[0]), await groundAt(page, ...clicks[1])];
    await page.locator('#scene').focus();
    await page.keyboard.press('m');
    for (const [x, y] of clicks) await page.mouse.click(x, y);
    const { measured_m } = await until(page, (s) => s.measured_m !== null);
    const chord = apart(a, b), arc = 2 * kRadius * Math.asin(chord / 2 / kRadius);
    assert.ok(Math.abs(measured_m / arc - 1) < 0.01, `${measured_m} m, ${arc} m along a ball`);
    const [bar_px, text] = await page.evaluate(() => [document.querySelector('.scale').style.width, document.querySelector('.scale').textContent]);
    const px_m = (1.5e6 * 2 * kTan) / kSize.height, told_m = Number.parseFloat(text) * (text.includes('km') ? 1000 : 1);
    assert.ok(Math.abs((Number.parseFloat(bar_px) * px_m) / told_m - 1) < 0.02, `${bar_px} are ${text}`);
    // Both are seen from space, and not from each other.
    await page.keyboard.press('m');
    await page.keyboard.down('Shift');
    await page.mouse.click(...clicks[0]);
    await until(page, (s) => s.sight_marked && s.sight_seen === null);
    await page.mouse.click(...clicks[1]);
    await until(page, (s) => !s.sight_marked && s.sight_seen === false);
    await page.keyboard.up('Shift');
  }));

test('depths keep what is near before what is far', kTest, () =>
  visit('fog=0&at=46,10,2600,0,0', async (page) => {
    assert.equal((await status(page)).depth_reversed, true);
    const { eye } = await until(page, (s) => s.above_ground_m !== null && s.above_ground_m < 1000);
    const near = await groundAt(page, kSize.width / 2, kSize.height - 10);
    assert.ok(near && apart(near, eye) < 5000, `${near && apart(near, eye)} m`);
    assert.ok(length(near) < length(eye));
  }));

test('the ground is not entered', kTest, () =>
  visit('fog=0&at=46,10,3000,0,-20', async (page) => {
    await page.locator('#scene').focus();
    await page.keyboard.down('q');
    const low = await until(page, (s) => s.above_ground_m !== null && s.above_ground_m < 30);
    await until(page, (s, frames) => s.frames > frames + 20, low.frames);
    await page.keyboard.up('q');
    const { above_ground_m } = await status(page);
    assert.ok(above_ground_m > 1.9 && above_ground_m < 30, `${above_ground_m} m above the ground`);
  }));

// Where the island that is looked at is on the screen, pixels: the middle of its light; of `count` frames, with a step of a drag before each.
function wander(page, count, step_px) {
  return page.evaluate(([count, step_px]) => new Promise((resolve) => {
    const canvas = document.getElementById('scene'), { width, height } = canvas, side = 96;
    const copy = new OffscreenCanvas(side, side).getContext('2d', { willReadFrequently: true }), found = [];
    let at = width / 2, last = -1;
    const point = (type, x) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: x, clientY: height / 2, button: 2, buttons: 2, bubbles: true }));
    canvas.setPointerCapture = () => {};
    if (step_px > 0) point('pointerdown', at);
    const look = () => {
      const { frames } = window.foreland.status();
      if (frames !== last) {
        copy.drawImage(canvas, (width - side) / 2, (height - side) / 2, side, side, 0, 0, side, side);
        const { data } = copy.getImageData(0, 0, side, side);
        let [sum, x, y] = [0, 0, 0];
        for (let i = 0; i < side * side; ++i) {
          const px = (i % side) - side / 2 + 0.5, py = Math.floor(i / side) - side / 2 + 0.5;
          if (Math.hypot(px, py) > side / 2) continue;
          const light = Math.max(data[4 * i] - 60, 0);
          [sum, x, y] = [sum + light, x + light * px, y + light * py];
        }
        found.push([x / sum, y / sum, sum]);
        last = frames;
        if (step_px > 0) point('pointermove', (at += step_px));
      }
      if (found.length < count) requestAnimationFrame(look);
      else {
        if (step_px > 0) point('pointerup', at);
        resolve(found);
      }
    };
    requestAnimationFrame(look);
  }), [count, step_px]);
}
// The largest distance of a frame from the parabola through its neighbours, of so many on each side.
function jitterOf(places, half = 12) {
  let most = 0;
  for (let i = half; i + half < places.length; ++i)
    for (const axis of [0, 1]) {
      const near = places.slice(i - half, i + half + 1).map((place) => place[axis]), n = near.length, t = near.map((_, k) => k - half);
      const [s2, s4] = [2, 4].map((power) => t.reduce((sum, v) => sum + v ** power, 0)), sum = near.reduce((a, b) => a + b), sum2 = near.reduce((a, b, k) => a + b * t[k] ** 2, 0);
      most = Math.max(most, Math.abs(near[half] - (sum * s4 - sum2 * s2) / (n * s4 - s2 * s2)));
    }
  return most;
}

test('a point of the ground does not jitter, from a camera that is still and from one that walks around it slowly', kTest, () =>
  visit(`fog=0&sun=free&height=90&ground=heights&colours=viridis&at=44.4,10,300000,0,-60`, async (page) => {
    await bare(page);
    await until(page, (s) => s.keyframes > 10);
    const count = Number(process.env.FRAMES ?? 60), still = await wander(page, count, 0);
    const spread = [0, 1].map((axis) => Math.max(...still.map((v) => v[axis])) - Math.min(...still.map((v) => v[axis])));
    const from = (await status(page)).eye, orbit = await wander(page, count, 0.5), jitter = jitterOf(orbit);
    await untilDrawn(page);
    assert.ok(apart((await status(page)).eye, from) > 1000, 'it has walked');
    console.log(`still ${spread.map((v) => v.toFixed(4)).join(' ')} px, orbit ${jitter.toFixed(4)} px in ${count} frames, light ${still[0][2].toFixed(0)}`);
    assert.ok(still[0][2] > 1e4 && Math.max(...spread) < 0.1, spread.join());
    assert.ok(jitter < 0.1, `${jitter}`);
  }, { width: 240, height: 180 }));

test('a server that comes back with a map is entered anew', kTest, () =>
  visit('fog=1', async (page) => {
    await until(page, (s) => s.air);
    const map = await makeScene(folder.folder, { size: 129 }), loaded = page.waitForEvent('load', { timeout: 0 }), { port } = server;
    await server.stop();
    server = await startServer(map, port);
    await loaded;
    const { air } = await until(page, (s) => s.triangles > 100 && s.frames > 2);
    assert.equal(air, false);
  }, { expected: /WebSocket|ERR_CONNECTION/ }));
