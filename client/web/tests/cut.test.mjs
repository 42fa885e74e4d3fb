// Cuts through the ground: what is left, the wall of strata along them, and how they are asked for; in headless Chromium against the real server.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { dropFile, makeFolder, makeSceneOnEarth, on_earth, openBrowser, openSources, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 300_000 };
let folder, server, browser, sources, rings, walls, views, spans, rays;

before(async () => {
  sources = await openSources();
  [rings, walls, views, spans, rays] = await Promise.all(['cut/ring.ts', 'cut/wall.ts', 'draw/cut_view.ts', 'cut/spans.ts', 'cut/rays.ts'].map((path) => sources.load(path)));
  folder = await makeFolder();
  server = await startServer(await makeSceneOnEarth(folder.folder));
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  await server?.stop();
  await folder?.remove();
  await sources?.close();
});

const seed = Number(process.env.SEED ?? Date.now() % 1e9);
let state = seed || 1;
const random = () => ((state = (state * 48271) % 2147483647) / 2147483647);
const between = (low, high) => low + (high - low) * random();

test('of two halves one has what is left of a line, the other what is right of it', () => {
  console.log(`seed ${seed}`);
  const samples = [300, 200], somewhere = () => [between(-100, 400), between(-100, 300)];
  for (let i = 0; i < 500; ++i) {
    const [a, b] = [somewhere(), somewhere()], [left, right] = [rings.halfOf(samples, a, b), rings.halfOf(samples, b, a)];
    for (let k = 0; k < 20; ++k) {
      const at = [between(0, 299), between(0, 199)], side = (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]);
      if (Math.abs(side) < 1e-6) continue;
      assert.equal(rings.isInside(left, at), side > 0);
      assert.equal(rings.isInside(right, at), side < 0);
    }
    assert.ok(left.length <= 5 && right.length <= 5);
  }
  assert.deepEqual(rings.halfOf(samples, [0, -50], [-1, -50]), []);
});

test('columns stand a step apart along all edges, and not more than are wanted', () => {
  const ring = [[0, 0], [100.5, 0], [100.5, 7], [-3, 9.25]];
  for (const most of [10_000, 60]) {
    const edges = rings.alongEdges(ring, most), apart = most > 1000 ? 1 : Infinity;
    edges.forEach((edge, i) => {
      assert.deepEqual([edge[0], edge.at(-1)], [ring[i], ring[(i + 1) % 4]]);
      for (let k = 1; k < edge.length; ++k) assert.ok(Math.hypot(edge[k][0] - edge[k - 1][0], edge[k][1] - edge[k - 1][1]) <= apart + 1e-9);
    });
    assert.ok(edges.flat().length <= most);
  }
});

test('a wall reaches from the ground to below all of it, and stands where there is ground', () => {
  const edges = [[0, 1, 2, 3, 4].map((x) => ({ easting: x, northing: 0 })), [4, 5].map((x) => ({ easting: x, northing: 1 }))];
  const ground = [NaN, 10, 30, NaN, 20, 25, 20], toScene = ({ easting, northing, height }) => [easting, northing, height];
  const wall = walls.wallOf(edges, ground, toScene);
  assert.equal(wall.columns, 5);
  const at = (v) => [0, 1, 2].map((i) => wall.positions[3 * v + i] + wall.origin[i]);
  [[1, 0, 10], [2, 0, 30], [4, 0, 20], [4, 1, 25], [5, 1, 20]].forEach((top, column) => {
    assert.deepEqual(at(2 * column), top);
    const foot = at(2 * column + 1);
    assert.deepEqual(foot.slice(0, 2), top.slice(0, 2));
    assert.ok(foot[2] <= 3, `${foot}`);
    assert.deepEqual([...wall.heights.slice(4 * column, 4 * column + 2)], [top[2], 0]);
    assert.ok(Math.abs(wall.heights[4 * column + 3] - (top[2] - foot[2])) < 1e-5);
  });
  // From the first to the second column, and from the fourth to the fifth: not over what is not known, nor from edge to edge.
  assert.deepEqual([...new Set([...wall.indices])].sort((a, b) => a - b), [0, 1, 2, 3, 6, 7, 8, 9]);
  assert.equal(walls.wallOf(edges, new Float64Array(7).fill(NaN), toScene).columns, 0);
});

test('strata are of round heights', () => {
  assert.deepEqual([0.7, 1, 1.1, 3, 47, 51, 0.012].map(views.roundStep), [1, 1, 2, 5, 50, 100, 0.02]);
});

// A star about a place, which may be as sharp as it likes.
const starAbout = ([x, y], count) => Array.from({ length: count }, (_, i) => {
  const angle = (2 * Math.PI * (i + 0.8 * random())) / count, radius = between(5, 60);
  return [x + radius * Math.cos(angle), y + radius * Math.sin(angle)];
});

const offLine = ([x, y], [ax, ay], [bx, by]) => Math.abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / Math.hypot(bx - ax, by - ay);
test('what is left of a way are the shares of it whose places are left, straight on the lattice or not', () => {
  console.log(`seed ${seed}`);
  for (let i = 0; i < 100; ++i) {
    const kept = { ring: starAbout([0, 0], 3 + Math.floor(13 * random())), is_hole: random() < 0.5 };
    const [from, to, bend] = [[between(-90, 90), between(-90, 90)], [between(-90, 90), between(-90, 90)], random() < 0.3 ? 0 : between(-3, 3)];
    const latticeAt = (t) => [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]) + bend * t * (1 - t)];
    const left = spans.spansAlong(kept, latticeAt, bend === 0 ? 1 : 64);
    for (let k = 1; k < left.length; ++k) assert.ok(left[k].from > left[k - 1].to);
    left.forEach((span) => assert.equal(span.is_at_wall, span.from > 0));
    for (const t of left.flatMap((span) => [span.from, span.to]).filter((t) => t > 0 && t < 1)) {
      const [x, y] = latticeAt(t), off = Math.min(...kept.ring.map((a, k) => offLine([x, y], a, kept.ring[(k + 1) % kept.ring.length])));
      assert.ok(off < 1e-9, `${off} off the ring`);
    }
    const isAtEnd = (t) => left.some(({ from: begin, to: end }) => Math.abs(t - begin) < 1e-9 || Math.abs(t - end) < 1e-9);
    const isWrong = (t) => left.some(({ from: begin, to: end }) => t >= begin && t <= end) !== (rings.isInside(kept.ring, latticeAt(t)) !== kept.is_hole) && !isAtEnd(t);
    assert.deepEqual(Array.from({ length: 1001 }, (_, k) => k / 1000).filter(isWrong), [], JSON.stringify({ kept, from, to, bend, left }));
  }
});

// Waves of ground under a scene whose lattice is its plane; what a ray meets is sought step by step.
test('a way meets the ground that is left or the wall, whichever is first, exactly and at once', async () => {
  const groundAt = ([x, y]) => 6 * Math.sin(x / 9) * Math.cos(y / 7), foot_m = -20;
  const first = (from, to, isMet) => {
    for (let k = 0; k <= 1500; ++k) {
      const at = from.map((v, i) => v + (k / 1500) * (to[i] - v));
      if (isMet(at)) return at;
    }
    return null;
  };
  const placeOf = ([x, y, z]) => ({ easting: x, northing: y, height: z, lattice: [x, y], ground: groundAt([x, y]) });
  const terrain = {
    scene: { frame: 'planar' }, place: placeOf, toGeodetic: placeOf, heights: async (places) => places.map(({ easting, northing }) => groundAt([easting, northing])),
    visible: async (pairs) => pairs.map((pair) => ({ isKnown: true, hit: first(...pair.map(({ easting, northing, height }) => [easting, northing, height]), (at) => at[2] <= groundAt(at)) })),
    raycast: (origin, direction, far) => first(origin, origin.map((v, i) => v + far * direction[i]), (at) => at[2] <= groundAt(at)),
  };
  let [on_wall, on_ground, nothing] = [0, 0, 0];
  for (let i = 0; i < 200; ++i) {
    const cut = { ring: starAbout([0, 0], 4 + Math.floor(9 * random())), is_hole: random() < 0.5, wall: { foot_m } };
    const way = { from: [between(-80, 80), between(-80, 80), between(8, 40)], to: [between(-80, 80), between(-80, 80), between(-30, 10)] };
    let was_open = true; // above the ground, or where nothing is left
    const there = first(way.from, way.to, (at) => {
      const is_in_ground = rings.isInside(cut.ring, at) !== cut.is_hole && at[2] <= groundAt(at), is_met = is_in_ground && was_open && at[2] >= foot_m;
      was_open = !is_in_ground;
      return is_met;
    });
    const [exact] = await rays.metExactly(terrain, cut, [way]), now = rays.metNow(terrain, cut, way), length = Math.hypot(...way.to.map((v, k) => v - way.from[k]));
    for (const met of [exact, now]) {
      assert.equal(met === null, there === null, JSON.stringify({ cut, way, met, there }));
      if (met) assert.ok(Math.hypot(...met.point.map((v, k) => v - there[k])) < length / 500, JSON.stringify({ cut, way, met, there }));
    }
    if (!exact) ++nothing;
    else if (exact.is_wall) ++on_wall;
    else ++on_ground;
  }
  assert.ok(on_wall > 5 && on_ground > 20 && nothing > 5, `${on_wall}, ${on_ground}, ${nothing}`);
});

// ---- in the page

const kView = 'view=0,0,4500,0,-25';
const visit = (query, body, { view = kView, ...options } = {}) =>
  visitPage(browser, new URL(`?${view}&${query}&sharpness=0.5&tau=2&fog=0&relief=0&ground=plain`, server.url), body, { width: 960, height: 640, ...options });
// Where neither panel nor bar is: colours of the picture, from above to below, in the middle of the window.
async function column(page) {
  const picture = await page.screenshot({ clip: { x: 500, y: 150, width: 1, height: 400 } });
  return page.evaluate(async (url) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(url.split(',')[1]), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(1, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, 1, image.height);
    return Array.from({ length: image.height }, (_, y) => [...data.subarray(4 * y, 4 * y + 3)]);
  }, `data:image/png;base64,${picture.toString('base64')}`);
}
const isStratum = ([r, g, b]) => r > b + 15 && r >= g; // brown: plain ground is grey, the sky blue
const isSky = ([r, , b]) => b > r + 15;
const kinds = (pixels) => pixels.map((pixel) => (isStratum(pixel) ? 'wall' : isSky(pixel) ? 'sky' : 'ground'));
const share = (pixels, kind) => kinds(pixels).filter((each) => each === kind).length / pixels.length;

test('key X cuts across the view: the near ground is gone, a wall of strata stands below the middle; again, and all is there', kTest, () =>
  visit('', async (page) => {
    await page.evaluate(() => document.activeElement?.blur());
    const before = await column(page);
    assert.ok(share(before, 'wall') < 0.02 && share(before.slice(210), 'ground') > 0.95, `${kinds(before)}`);
    await page.keyboard.press('KeyX');
    const { cut_columns } = await until(page, (s) => s.cut_columns > 0);
    assert.ok(cut_columns >= on_earth.size - 2, `${cut_columns}`);
    await until(page, (s, frames) => s.frames > frames + 1, (await status(page)).frames);
    const cut = kinds(await column(page)), first = cut.indexOf('wall');
    // The middle of the window is 170 of these pixels down: the cut goes through what was seen there.
    assert.ok(Math.abs(first - 170) < 12, `the wall begins at ${first} of ${cut}`);
    assert.ok(cut.slice(first, first + 20).every((kind) => kind !== 'sky') && cut.slice(-40).every((kind) => kind === 'sky'), `${cut}`);
    assert.ok((await page.evaluate(() => window.location.search)).includes('cut=') || (await page.waitForTimeout(1500), (await page.evaluate(() => window.location.search)).includes('cut=')));
    await page.keyboard.press('KeyX');
    await until(page, (s, frames) => s.cut_corners === 0 && s.frames > frames + 1, (await status(page)).frames);
    assert.ok(share(await column(page), 'wall') < 0.02);
  }));

test('the other side is what was missing; by touch alone', kTest, () =>
  visit('', async (page) => {
    await page.tap('#tools button[name=cut]');
    await page.tap('#cut button[name=cut_across]');
    await until(page, (s) => s.cut_columns > 0);
    await page.tap('#cut button[name=cut_turn]');
    await until(page, (s) => s.cut_hole);
    await until(page, (s, frames) => s.frames > frames + 1, (await status(page)).frames);
    const cut = kinds(await column(page));
    // From this side no wall is seen: the ground ends there, and the sky is behind it.
    assert.ok(cut.slice(190).filter((kind) => kind === 'ground').length > 0.95 * (cut.length - 190), `${cut}`);
    assert.ok(cut.slice(0, 150).filter((kind) => kind === 'sky').length > 140, `${cut}`);
    await page.tap('#cut button[name=cut_clear]');
    await until(page, (s) => s.cut_corners === 0);
  }, { mobile: true }));

test('what is measured is cut out, and an address leads there again', kTest, () => {
  const { size, step } = on_earth, [lon, lat] = [8 + 0.5 * size * step, 46 + 0.5 * size * step];
  const ring = [[-30, -30], [30, -30], [30, 30], [-30, 30]].flatMap(([x, y]) => [lon + x * step, lat + y * step]);
  return visit(`cut=in,${ring}`, async (page) => {
    const { cut_corners, cut_columns } = await until(page, (s) => s.cut_columns > 0);
    assert.equal(cut_corners, 4);
    assert.ok(cut_columns > 230 && cut_columns < 260, `${cut_columns}`);
    await page.evaluate(() => document.activeElement?.blur());
    await page.keyboard.press('KeyM');
    for (const [x, y] of [[480, 330], [520, 330], [500, 350]]) {
      const { measured_corners } = await status(page);
      await page.mouse.click(x, y);
      await until(page, (s, corners) => s.measured_corners > corners, measured_corners);
    }
    await page.click('#measure button[name=measure_cut]');
    await until(page, (s) => s.cut_corners === 3 && s.cut_columns > 0);
  }, { view: 'view=0,-6000,4500,0,-30' });
});

test('an address that is no cut is told, and nothing is cut', kTest, () =>
  visit('cut=in,8,46,9', async (page) => {
    await page.waitForFunction(() => /cut of this address/.test(document.getElementById('hint').textContent));
    assert.equal((await status(page)).cut_corners, 0);
  }));

// Into a pit from the south: what was in it hides its northern wall no more, tells nothing and has no names.
test('clicks, names and what lies on the ground know of what is cut away', kTest, () => {
  const { size, step, west, south } = on_earth, [lon, lat] = [west + 0.5 * size * step, south + 0.5 * size * step];
  const pit = [[-40, -30], [40, -30], [40, 30], [-40, 30]].map(([x, y]) => [lon + x * step, lat + y * step]), north = lat + 30 * step;
  return visit(`cut=out,${pit.flat()}`, async (page) => {
    await until(page, (s) => s.cut_columns > 0);
    const feature = { type: 'Feature', properties: { name: 'In the pit' }, geometry: { type: 'Polygon', coordinates: [[...pit, pit[0]]] } };
    await dropFile(page, 'pit.geojson', JSON.stringify(feature));
    const places = Array.from({ length: 225 }, (_, i) => ({ name: `P${i}`, lon: west + 0.02 + 0.014 * (i % 15), lat: south + 0.06 + 0.012 * Math.floor(i / 15) }));
    const isInPit = ({ lon: x, lat: y }) => Math.abs(x - lon) < 40 * step && Math.abs(y - lat) < 30 * step;
    await dropFile(page, 'names.csv', `name,lon,lat\n${places.map(({ name, lon: x, lat: y }) => `${name},${x},${y}`).join('\n')}`);
    const labelled = ({ labels }) => places.filter(({ name }) => labels.includes(name));
    const cut = await until(page, (s) => s.overlays_laid > 1 && s.labels.length > 3 && s.relief_shown > 0);
    assert.deepEqual(labelled(cut).filter(isInPit), []);
    await page.evaluate(() => document.activeElement?.blur());
    await page.mouse.click(480, 320);
    assert.equal(await page.locator('#feature').isVisible(), false, 'what lies on ground that is cut away is not there');
    await page.keyboard.press('KeyM');
    await page.mouse.click(480, 320);
    const { measured_at: [wall] } = await until(page, (s) => s.measured_corners === 1);
    assert.ok(Math.abs(wall.lat - north) < 1e-7 && Math.abs(wall.lon - west - 150 * step) < 1e-4, `${JSON.stringify(wall)}, not at ${north}`);
    const held = await page.evaluate(() => window.foreland.onScreen(window.foreland.groundAt(480, 320)));
    assert.ok(Math.hypot(held[0] - 480, held[1] - 320) < 0.5, 'the wall is held');
    await page.screenshot({ path: process.env.KEEP ? `${process.env.KEEP}/pit.png` : undefined });
    await page.keyboard.press('KeyM');
    await page.keyboard.press('KeyX');
    await until(page, (s) => s.cut_corners === 0 && s.labels.length > 3);
    await page.keyboard.press('KeyM');
    await page.mouse.click(480, 320);
    const { measured_at: [ground] } = await until(page, (s) => s.measured_corners === 1);
    assert.ok(ground.lat < north - 0.004, JSON.stringify(ground));
    await page.keyboard.press('KeyM');
    await page.mouse.click(480, 320);
    await page.locator('#feature').getByText('In the pit').waitFor();
    while (labelled(await status(page)).filter(isInPit).length === 0) await page.waitForTimeout(50);
  }, { view: 'relief=1&view=0,-6000,3500,0,-18.5' });
});
