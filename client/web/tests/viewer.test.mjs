// The page in headless Chromium against the real server, as a person would use it. Every wait is for a condition.
import assert from 'node:assert/strict';
import { mkdir, readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { serveMessage } from '../../js/tests/socket.mjs';
import { readHeights } from '../../js/tests/heights.mjs';
import {
  changedShare, is_soak, makeFolder, makeMovingScene, makeScene, makeSceneWithObjects, makeSceneWithPicture, middleOf, openBrowser, openPage, pictureOf, root, runForeland, startServer, status, until, untilTerrain, visitPage,
} from './support.mjs';

const kTest = { timeout: 180_000 };
const kSaves = process.env.FORELAND_SCREENSHOT === '1'; // pictures, to docs/images
let folder, scene, server, browser;

before(async () => {
  folder = await makeFolder();
  scene = await makeScene(folder.folder);
  server = await startServer(scene);
  browser = await openBrowser();
}, kTest);

after(async () => {
  await browser?.close();
  await server?.stop();
  await folder?.remove();
});

// Drawn coarsely, because a processor does it.
function visit(query, body, { watches = false, sharpness = 0.6, server: at = server, ...options } = {}) {
  const url = new URL(`?${query}&sharpness=${sharpness}&tau=4`, at.url);
  return visitPage(browser, url, body, { prepare: (page) => watches && watchFrames(page), ...options });
}

// Keeps the status of every frame from now on, and on pages that are opened later.
async function watchFrames(page) {
  const watch = () => {
    window.watched = [];
    const look = () => {
      const status = window.foreland?.status();
      if (status?.title) window.watched.push({ eye: status.eye, above_ground_m: status.above_ground_m });
      requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  };
  await page.addInitScript(watch);
  await page.evaluate(watch);
}
const watchedFrames = (page) => page.evaluate(() => window.watched);

test('terrain comes to the screen and keyframes go on', kTest, () =>
  visit('', async (page) => {
    const picture = await pictureOf(page);
    assert.ok(picture.colours > 60, `only ${picture.colours} colours`);
    const [sky, ground] = [picture.sky, picture.ground];
    assert.ok(sky[2] > sky[0], `the sky is blue: ${sky}`);
    assert.ok(sky[2] - sky[0] > ground[2] - ground[0], `the ground is not: ${ground}`);
    const before_ = await status(page);
    await until(page, (s, [keyframes, version]) => s.keyframes >= keyframes && s.mesh_version > version, [before_.keyframes + 5, before_.mesh_version]);
    assert.equal(await page.locator('#notice').isVisible(), false);
    assert.ok((await page.title()).endsWith('Foreland'));
  }));

test('the connection and the meshes are in a worker', kTest, async () => {
  const { page, complaints, close } = await openPage(browser);
  try {
    await page.addInitScript(() => (window.WebSocket = class { constructor() { throw new Error('a socket of the drawing thread'); } }));
    await page.goto(new URL('?sharpness=0.6&tau=4', server.url).href);
    await untilTerrain(page);
    assert.deepEqual(page.workers().map((worker) => new URL(worker.url()).pathname.replace(/-.*/, '')), ['/assets/worker']);
    assert.deepEqual(complaints, []);
  } finally {
    await close();
  }
});

test('keys fly and the ground is not entered', kTest, () =>
  visit('', async (page) => {
    const { eye } = await status(page);
    await page.locator('#scene').focus();
    await page.keyboard.down('KeyW');
    await until(page, (s, e) => Math.hypot(s.eye[0] - e[0], s.eye[1] - e[1]) > 20, eye);
    await page.keyboard.up('KeyW');
    await page.mouse.wheel(0, -4000); // a great speed
    await watchFrames(page);
    await page.keyboard.down('KeyQ');
    await until(page, (s) => s.above_ground_m !== null && s.above_ground_m < 20);
    await page.keyboard.down('KeyW'); // along the ground, up and down
    await until(page, (s, n) => s.frames > n + 40, (await status(page)).frames);
    for (const key of ['KeyW', 'KeyQ']) await page.keyboard.up(key);
    const frames = await watchedFrames(page);
    const lowest = Math.min(...frames.map((f) => f.above_ground_m ?? Infinity));
    assert.ok(lowest > 1.9 && lowest < 20, `${lowest} m above ground`);
  }));

// From where it is below the ground, which the page cannot know before the ground has come.
test('an eye that rests stays, whatever comes, and its own motion frees it', kTest, () =>
  visit('view=0,0,-300,90,0', async (page) => {
    await untilTiles(page);
    for (const { eye } of await watchedFrames(page)) assert.deepEqual(eye, [0, 0, -300]);
    const buried = await status(page);
    assert.ok(buried.above_ground_m < -100, `${buried.above_ground_m} m above ground`);
    await page.locator('#scene').focus();
    await page.keyboard.down('KeyW');
    await until(page, (s) => s.above_ground_m > 1.9, null, 120_000);  // in steps of a frame, of which there are few
    await page.keyboard.up('KeyW');
    const frames = await watchedFrames(page);
    const rises = frames.slice(1).map((f, i) => f.eye[2] - frames[i].eye[2]);
    for (const up of rises) assert.ok(up < 45, `lifted by ${up} m in a frame`); // at most as far as it flies
  }, { watches: true }));

test('dragging turns the view', kTest, () =>
  visit('', async (page) => {
    const { heading } = await status(page);
    await page.mouse.move(400, 200);
    await page.mouse.down();
    await page.mouse.move(250, 210, { steps: 4 });
    await page.mouse.up();
    await until(page, (s, h) => s.heading > h + 0.2, heading);
  }));

for (const strategy of ['delay', 'current', 'predict']) {
  test(`strategy ${strategy} is switched to in flight`, kTest, () =>
    visit('tour=orbit', async (page) => {
      await until(page, (s) => s.touring);
      await page.locator('.choice label', { has: page.locator(`[value=${strategy}]`) }).click();
      const { keyframes } = await status(page);
      const now = await until(page, (s, n) => s.keyframes >= n, keyframes + 8);
      assert.ok(now.connected);
    }));
}

test('geomorphs are switched to and from in flight', kTest, () =>
  visit('tour=canyon', async (page) => {
    await until(page, (s) => s.touring && s.blend === 'keyframe');
    for (const blend of ['geomorph', 'keyframe', 'geomorph']) {
      await page.locator('.choice label', { has: page.locator(`[value=${blend}]`) }).click();
      const { keyframes, mesh_version } = await until(page, (s, b) => s.blend === b, blend);
      const now = await until(page, (s, [n, shown]) => s.keyframes >= n && s.mesh_version > shown, [keyframes + 8, mesh_version]);
      assert.ok(now.connected);
    }
    const picture = await pictureOf(page);
    assert.ok(picture.colours > 60, `only ${picture.colours} colours`);
  }));

// Of order 2 and 3, and by way of linear blends, from adaptive keyframes as well.
test('splines of keyframes are switched to and from in flight', kTest, () =>
  visit('tour=survey&blend=b-spline-2', async (page) => {
    await until(page, (s) => s.touring && s.blend === 'b-spline-2' && s.keyframes > 8);
    for (const blend of ['b-spline-3', 'keyframe', 'b-spline-2']) {
      await page.locator('.choice label', { has: page.locator(`[value=${blend}]`) }).click();
      const { keyframes, mesh_version } = await until(page, (s, b) => s.blend === b, blend);
      if (blend === 'keyframe') await page.locator('[name=adaptive]').check();
      const now = await until(page, (s, [n, shown]) => s.keyframes >= n && s.mesh_version > shown, [keyframes + 8, mesh_version]);
      assert.ok(now.connected);
      assert.equal(await page.locator('[name=adaptive]').isVisible(), blend === 'keyframe');
    }
    const picture = await pictureOf(page);
    assert.ok(picture.colours > 60, `only ${picture.colours} colours`);
  }));

test('a finer tolerance gives more triangles', kTest, () =>
  visit('tau=8', async (page) => {
    const coarse = await status(page);
    await page.locator('[name=tau_px]').fill('0');
    const fine = await until(page, (s, n) => s.triangles > 1.5 * n && s.tau_px < 1.01, coarse.triangles);
    assert.ok(coarse.tau_px > 7.9 && fine.triangles > coarse.triangles);
  }));

test('wireframe and contours are drawn', kTest, () =>
  visit('', async (page) => {
    const drawnAgain = async () => {
      const { frames } = await status(page);
      await until(page, (s, n) => s.frames > n, frames + 2);
      return middleOf(page);
    };
    await page.locator('[name=frozen]').check(); // so that nothing else changes
    await until(page, (s) => s.frozen);
    await untilTiles(page);
    const plain = await drawnAgain();
    const still = await changedShare(page, plain, await drawnAgain());
    assert.ok(still < 0.002, `${still} of a view at rest changes`);
    for (const name of ['wireframe', 'contours']) {
      await page.locator(`[name=${name}]`).check();
      let share = 0;
      for (let tries = 0; share === 0 && tries < 10; ++tries) share = await changedShare(page, plain, await drawnAgain());
      assert.ok(share > 0.02 && share < 0.95, `${name} changes ${share} of the terrain`);
      await page.locator(`[name=${name}]`).uncheck();
    }
  }));

test('a frozen section stays while the camera goes outside', kTest, () =>
  visit('tau=2', async (page) => {
    await page.locator('[name=frozen]').check();
    const frozen = await settled(page, (s) => s.frozen);
    await page.locator('#scene').focus();
    await page.keyboard.down('KeyS');
    await until(page, (s, e) => Math.hypot(s.eye[0] - e[0], s.eye[1] - e[1]) > 800, frozen.eye); // so that sections differ by more than a few nodes
    await page.keyboard.up('KeyS');
    const later = await settled(page, () => true);
    assert.equal(later.nodes, frozen.nodes);
    await page.locator('[name=frozen]').uncheck();
    await until(page, (s, n) => !s.frozen && s.nodes !== n, frozen.nodes);
  }));

test('what ridges hide is left out, and comes back', kTest, async () => {
  const occluding = await startServer(scene, 0, ['--occlusion', 'on']);
  try {
    await visit('tau=2&occlusion=0', async (page) => {
      await page.locator('[name=frozen]').check(); // so that nothing else changes
      const whole = await settled(page, () => true);
      await page.locator('[name=occlusion]').check(); // needs a new connection
      const hidden = await settled(page, (s, n) => s.connected && s.nodes < 0.9 * n, whole.nodes);
      await page.locator('[name=occlusion]').uncheck();
      const again = await settled(page, (s, n) => s.nodes > n, hidden.nodes);
      assert.equal(again.nodes, whole.nodes);
    }, { server: occluding });
  } finally {
    await occluding.stop();
  }
});

// The status of a page that asks for a tolerance of 2 px once a condition holds, four more keyframes are there, and the tolerance,
// which a busy machine raises for a while, is what was asked for.
async function settled(page, condition, value) {
  const { keyframes } = await until(page, condition, value);
  return until(page, (s, n) => s.keyframes >= n && s.tau_px <= 2, keyframes + 4);
}

for (const tour of ['survey', 'canyon', 'spin', 'orbit']) {
  test(`the tour ${tour} is flown from its button`, kTest, () =>
    visit('', async (page) => {
      await page.locator(`[data-tour=${tour}]`).click();
      const start = await until(page, (s) => s.touring);
      await until(page, (s, b) => Math.hypot(...s.eye.map((v, i) => v - b.eye[i])) > 30 || Math.abs(s.heading - b.heading) > 0.2, start);
      await page.locator(`[data-tour=${tour}]`).click();
      await until(page, (s) => !s.touring && s.connected);
    }));
}

// Its keyframes and frames keep the tolerance that they state when they are judged on a replay, so what was recorded is what was flown.
// Only frames that promise nothing may be coarser: a slow page draws one before the first section is there.
test('a flight by hand is recorded, and replayed', kTest, () =>
  visit('record=1', async (page) => {
    const { keyframes } = await status(page);
    await page.keyboard.down('w');
    await page.locator('[name=tau_px]').fill('1'); // 2 px
    await until(page, (s, n) => s.keyframes > n + 12, keyframes);
    await page.keyboard.up('w');
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Save the recording' }).click();
    const file = join(folder.folder, 'flight.rec');
    await (await download).saveAs(file);
    const report = JSON.parse(await runForeland('replay', file, '--truth', scene, '--truth-every', '1', '--json'));
    assert.ok(report.frames > 5, `${report.frames} frames`);
    assert.ok(report.keyframes > 12, `${report.keyframes} keyframes`);
    const { max_error_px_keyframes, max_error_px_frames, keyframes_over_tau, frames_over_tau, measured_frames_outside } = report;
    assert.ok(max_error_px_keyframes > 0 && keyframes_over_tau === 0, `${keyframes_over_tau} keyframes, ${max_error_px_keyframes} px`);
    assert.ok(max_error_px_frames > 0, 'frames without an error were not judged');
    assert.ok(frames_over_tau <= measured_frames_outside, `${frames_over_tau} of ${measured_frames_outside} outside`);
  }));

test('a flight can be recorded from where the camera is', kTest, () =>
  visit('view=100,-1500,3000,30,-20', async (page) => {
    const { eye } = await status(page);
    await page.getByRole('button', { name: 'Record a flight from here' }).click();
    await page.waitForURL(/record=1/);
    await untilTerrain(page);
    const there = await status(page);
    eye.forEach((metres, i) => assert.ok(Math.abs(metres - there.eye[i]) < 1, `${eye}, then ${there.eye}`));
    await page.getByRole('button', { name: 'Save the recording' }).waitFor();
  }));

test('the address keeps the view, so that the page can be loaded again and shared there', kTest, () =>
  visit('tour=orbit&tau=4', async (page) => {
    const query = () => new URL(page.url()).searchParams;
    await until(page, (s) => s.touring);
    await page.waitForURL(/view=/);
    assert.equal(query().get('tour'), 'orbit');
    await page.locator('#scene').focus();
    await page.keyboard.down('KeyW');
    const { eye } = await until(page, (s) => !s.touring);
    await until(page, (s, e) => Math.hypot(...s.eye.map((v, i) => v - e[i])) > 50, eye);
    await page.keyboard.up('KeyW');
    const isKept = async () => {
      const { eye: there } = await status(page);
      const view = query().get('view').split(',').map(Number);
      return there.every((v, i) => Math.abs(v - view[i]) < 0.06);
    };
    const drawTwice = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const restsAt = async ({ eye: before }) => (await drawTwice(), (await status(page)).eye.every((v, i) => v === before[i]));
    let rested = await status(page);
    while (!((await restsAt(rested)) && (await isKept()))) rested = await status(page); // a camera that slows down may pass where it is kept
    assert.deepEqual([query().get('tour'), query().get('tau'), query().get('sharpness')], [null, '4', '0.6'], 'the rest stays');
    assert.equal(await page.evaluate(() => history.length), 2, 'no page to go back through');
    await page.reload();
    const again = await untilTerrain(page);
    rested.eye.forEach((v, i) => assert.ok(Math.abs(v - again.eye[i]) < 0.1, `${rested.eye}, then ${again.eye}`));
    assert.ok(Math.abs(again.heading - rested.heading) < 1e-3, `${rested.heading}, then ${again.heading}`);
  }));

test('a lost server is told of, and found again', kTest, () =>
  visit('', async (page) => {
    const { eye } = await status(page);
    await server.stop();
    await page.getByText('Connection lost').waitFor();
    const picture = await pictureOf(page);
    assert.ok(picture.colours > 40, 'the last terrain stays on the screen');
    server = await startServer(scene, server.port);
    await page.locator('#notice').waitFor({ state: 'hidden' });
    const now = await until(page, (s) => s.connected && s.keyframes >= 3 && s.mesh_version > 0);
    assert.deepEqual(now.eye.map(Math.round), eye.map(Math.round));
  }, { expected: /WebSocket|ERR_CONNECTION/ }));

test('a page without its client core says so', kTest, async () => {
  const { page, close } = await openPage(browser);
  await page.route('**/foreland*.wasm', (route) => route.fulfill({ status: 404, body: 'gone' }));
  await page.goto(server.url.href);
  await page.getByText('The client core did not load.').waitFor();
  await close();
});

test('a browser without WebGL 2 is told so', kTest, async () => {
  const { page, close } = await openPage(browser);
  await page.addInitScript(() => (HTMLCanvasElement.prototype.getContext = () => null));
  await page.goto(server.url.href);
  await page.getByText('This browser cannot draw the terrain.').waitFor();
  await close();
});

test('a message that is no message ends the session with its reason', kTest, async () => {
  const bad = await serveMessage(Buffer.from([0xff, 1, 2, 3]));
  const { page, close } = await openPage(browser);
  await page.goto(new URL(`?server=${bad.url}`, server.url).href);
  await page.getByText('The session ended.').waitFor();
  await page.getByRole('button', { name: 'Try again' }).waitFor();
  await close();
  bad.close();
});

test('it fits a phone', kTest, () =>
  visit('', async (page) => {
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth > window.innerWidth), false);
    await page.getByRole('button', { name: 'Settings' }).tap();
    await page.locator('[name=wireframe]').waitFor();
    await page.getByRole('button', { name: 'Settings' }).tap();
    await page.locator('[name=wireframe]').waitFor({ state: 'hidden' });
    const { eye } = await status(page);
    await pinch(page);
    await until(page, (s, e) => Math.hypot(...s.eye.map((v, i) => v - e[i])) > 1, eye);
  }, { width: 390, height: 760, mobile: true }));

// Pairs of the page's parts that lie over one another.
const overlaps = (page) => page.evaluate(() => {
  const boxes = ['title', 'tools', 'panel', 'readout', 'map', 'compass', 'time', 'tours', 'hint'].map((id) => [id, document.getElementById(id).getBoundingClientRect()]);
  const covers = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  const shown = boxes.filter(([, box]) => box.width > 0);
  return shown.flatMap(([a, box], i) => shown.slice(i + 1).filter(([, other]) => covers(box, other)).map(([b]) => `${a}, ${b}`));
});

// The page's parts that reach beyond the window.
const cutOff = (page) => page.evaluate(() => ['title', 'tools', 'panel', 'readout', 'map', 'compass', 'time', 'tours', 'hint'].filter((id) => {
  const { left, top, right, bottom } = document.getElementById(id).getBoundingClientRect();
  return left < 0 || top < 0 || right > window.innerWidth || bottom > window.innerHeight;
}));

test('a visitor finds what a visitor wants, and the laboratory stays open for who has opened it', kTest, () =>
  visit('', async (page) => {
    assert.equal((await page.locator('#hint').textContent()).split('\n').length, 3);
    const body = page.locator('#panel .body');
    assert.equal(await body.evaluate((b) => b.scrollHeight > b.clientHeight), false, 'all settings of a visitor are in view');
    for (const name of ['ground', 'sun', 'relief', 'speed', 'quality']) assert.ok(await page.locator(`[name=${name}]`).isVisible(), name);
    for (const name of ['strategy', 'tau_px', 'wireframe']) assert.equal(await page.locator(`[name=${name}]`).first().isVisible(), false, name);
    assert.equal(await page.locator('[name=imagery]').isVisible(), false, 'the scene has no imagery');
    assert.match(await page.locator('#readout').textContent(), / high .* above ground.* fps$/);
    assert.equal(await page.locator('#readout dl').isVisible(), false);

    await page.locator('[name=quality]').fill('-2');
    assert.equal(await page.locator('[name=tau_px]').inputValue(), '2'); // of 2 to its power, pixels
    await until(page, (s) => s.tau_px === 4);
    const speed = page.locator('.row:has([name=speed]) output'), before_ = await speed.textContent();
    await page.mouse.move(480, 270);
    await page.mouse.wheel(0, -500);
    await speed.filter({ hasNotText: before_ }).waitFor();
    await page.locator('[name=speed]').fill('1');
    assert.equal(await speed.textContent(), '10 m/s');

    await page.getByText('Laboratory').click();
    await page.locator('#readout button').click();
    await page.locator('#readout dl').waitFor();
    await page.reload();
    await untilTerrain(page);
    assert.ok(await page.locator('[name=strategy]').first().isVisible());
    assert.ok(await page.locator('#readout dl').isVisible());
    assert.equal((await page.locator('#hint').textContent()).split('\n').length, 1);
  }, { width: 1280, height: 720, is_first_visit: true }));

test('who hears the page, or has little contrast, finds nothing serious amiss in it', kTest, () =>
  visit('', async (page) => {
    await page.locator('#hint').evaluate((hint) => hint.remove()); // it goes by itself, over whatever is behind it
    await page.getByRole('button', { name: 'Measure', exact: true }).click();
    await page.locator('#measure').waitFor();
    await page.evaluate(await readFile(join(root, 'client/web/node_modules/axe-core/axe.min.js'), 'utf8'));
    const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
    const serious = violations.filter(({ impact }) => impact === 'serious' || impact === 'critical');
    assert.deepEqual(serious.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html.slice(0, 120)).join('; ')}`), []);
  }, { width: 1280, height: 720 }));

test('no part of the page lies over another, on small screens and large ones, with a time line and without', kTest, async () => {
  const moving = await startServer(await makeMovingScene(folder.folder));
  try {
    for (const [at, query] of [[server, ''], [moving, ''], [server, 'map=1&lang=fr'], [server, 'map=1&lang=de']]) {
      await visit(query, async (page) => {
        for (const [width, height] of [[640, 360], [390, 844], [360, 640], [844, 390], [720, 600], [960, 600], [1280, 720], [1920, 1080]]) {
          await page.setViewportSize({ width, height });
          assert.deepEqual(await overlaps(page), [], `${width} x ${height} ${query}`);
          assert.deepEqual(await cutOff(page), [], `${width} x ${height} ${query}`);
        }
      }, { server: at, mobile: true, width: 640, height: 360, is_first_visit: true });
    }
  } finally {
    await moving.stop();
  }
});

// Two fingers going apart.
async function pinch(page) {
  const client = await page.context().newCDPSession(page);
  const touch = (type, gap) =>
    client.send('Input.dispatchTouchEvent', {
      type,
      touchPoints: gap === null ? [] : [{ x: 120 - gap, y: 480, id: 1 }, { x: 200 + gap, y: 480, id: 2 }],
    });
  await touch('touchStart', 0);
  for (const gap of [15, 30, 45, 60]) await touch('touchMove', gap);
  await touch('touchEnd', null);
}

test('fifty objects fly by, each in the colours of its model', kTest, async () => {
  const crowded = await startServer(await makeSceneWithObjects(folder.folder, 50));
  const { page, complaints, close } = await openPage(browser);
  try {
    await page.goto(new URL('?sharpness=0.6&tau=4&tour=orbit', crowded.url).href);
    await untilTerrain(page);
    const before_ = await until(page, (s) => s.object_images === 1 && s.touring);
    const after_ = await until(page, (s, b) => s.keyframes >= b.keyframes + 15 && s.mesh_version > b.mesh_version, before_);
    assert.ok(after_.object_triangles > 50 * 96, `${after_.object_triangles} triangles of 50 objects`);
    await page.locator('[name=wireframe]').check();
    const wired = await status(page);
    await until(page, (s, n) => s.mesh_version >= n, wired.mesh_version + 2);
    assert.deepEqual(complaints, []);
  } finally {
    await close();
    await crowded.stop();
  }
});

// Comparisons of a page in flight, as App.compareEnds gives them.
async function compareEnds(page, count) {
  const all = [];
  while (all.length < count) {
    const one = await page.evaluate(() => window.foreland.compareEnds());
    if (one) all.push(one);
    const { mesh_version } = await status(page);
    if (one) await until(page, (s, version) => s.mesh_version > version, mesh_version);
  }
  return all;
}

test('the next mesh begins as the last one ends, terrain and objects', kTest, async () => {
  const crowded = await startServer(await makeSceneWithObjects(folder.folder, 50));
  try {
    for (const blend of ['keyframe', 'geomorph']) {
      await visit(`tour=orbit&tau=1&fog=0&blend=${blend}`, async (page) => {
        await until(page, (s) => s.touring && s.object_triangles > 50 * 96);
        const all = await compareEnds(page, is_soak ? 12 : 6);
        const shareOf = (key) => Math.max(...all.map((one) => one[key] / one.pixels));
        // Light does not move: what is seen to is the ground's outline and height.
        assert.ok(shareOf('moved') > 0.005, `only ${shareOf('moved')} of the pixels change from beginning to end`);
        // Triangles are divided otherwise, so what lies between their corners is rounded otherwise: of the more pixels, the more
        // of the mesh changes, which on a busy machine is much now and then.
        const differing = all.map((one) => one.differing / one.pixels).sort((a, b) => a - b);
        assert.ok(differing[Math.floor(differing.length / 2)] < 0.008, `${blend}: ${differing.join(', ')} of the pixels differ`);
        assert.ok(shareOf('visible') < 0.002, `${blend}: ${shareOf('visible')} of the pixels differ visibly`);
      }, { server: crowded, width: 640, height: 360 });
    }
  } finally {
    await crowded.stop();
  }
});

// Waits until the view has the tiles that it needs, by the server's statement, and no others come or are drawn for a while: on a
// slow machine the server begins slowly, with seconds between tiles, and meshes that bring tiles wait for their uploads.
async function untilTiles(page) {
  const isWhole = (s) => s.relief_shown > 0 && s.relief_texel_px <= 2 && (s.imagery_shown === 0 || s.imagery_texel_px <= 2);
  let last = await until(page, isWhole);
  for (;;) {
    const now = await until(page, (s, last) => s.keyframes >= last.keyframes + 4 && s.mesh_version >= last.mesh_version + 6, last);
    if (now.tiles === last.tiles && now.relief_shown === last.relief_shown) return now;
    last = now;
  }
}

// Of the levels of which all tiles are drawn from everywhere: the region that the server computes keyframes for depends on the tolerance.
const kLowSun = 'sun=free&azimuth=250&height=12';
for (const [what, query] of [['light', ''], ['light with cast shadows', `shadows=1&${kLowSun}`], ['colour by height', 'ground=heights']]) {
  test(`${what} on the ground is the same at any tolerance`, kTest, async () => {
    const positions = [];
    for (let y = 20.25; y < 500; y += 24) for (let x = 20.75; x < 500; x += 24) positions.push(x, y);
    const read = [];
    for (const tau of [0.5, 8]) {
      await visit(`tau=${tau}&fog=0&${query}`, async (page) => {
        const { relief_shown } = await untilTiles(page);
        read.push({ relief_shown, shades: await page.evaluate((p) => [2, 3].map((footprint) => window.foreland.shadeAt(p, footprint, 1)), positions) });
      });
    }
    const [fine, coarse] = read;
    for (const { relief_shown } of read) assert.ok(relief_shown >= 5, `${relief_shown} tiles: not the coarser levels`);
    for (const i of [0, 1]) {
      assert.ok(new Set(fine.shades[i]).size > 30, 'the ground has many shades');
      const worst = Math.max(...fine.shades[i].map((shade, k) => Math.abs(shade - coarse.shades[i][k])));
      assert.ok(worst <= 1, `a shade differs by ${worst}`);
    }
  });
}

// Where the sun would shine on the ground; the rays are followed over the raster that the scene was built from.
test('shadows lie where rays to the sun meet the ground', kTest, async () => {
  const heights = await readHeights(join(folder.folder, 'Example mountains.tif'));
  const positions = [];
  for (let y = 12; y < heights.side - 12; y += 9) for (let x = 12; x < heights.side - 12; x += 9) positions.push(x, y);
  await visit(`fog=0&shadows=1&${kLowSun}`, async (page) => {
    for (const azimuth of [250, 70]) {
      await page.locator('[name=sun_azimuth_deg]').fill(String(azimuth));
      await page.locator('[name=shadows]').check();
      const { keyframes } = await status(page);
      await until(page, (s, n) => s.keyframes > n + 8, keyframes);
      await untilTiles(page);
      const [shadowed, plain] = await page.evaluate((p) => {
        const { foreland } = window, shadows = document.querySelector('[name=shadows]');
        const both = [foreland.shadeAt(p, 1, 1)];
        shadows.click();
        return [...both, foreland.shadeAt(p, 1, 1)];
      }, positions);
      const sun = [Math.sin((azimuth * Math.PI) / 180), Math.cos((azimuth * Math.PI) / 180), Math.tan((12 * Math.PI) / 180)];
      const seen = { dark: 0, lit: 0, wrong: 0 };
      for (let i = 0; i < positions.length / 2; ++i) {
        const [x, y] = positions.slice(2 * i, 2 * i + 2);
        const over_m = heights.shadowOver(x, y, sun);
        if (!heights.facesSun(x, y, sun) || Math.abs(over_m) < 6) continue;
        const is_dark = plain[3 * i] - shadowed[3 * i] > 3;
        ++seen[over_m > 0 ? 'dark' : 'lit'];
        if (is_dark !== over_m > 0) ++seen.wrong;
      }
      assert.ok(seen.dark > 40 && seen.lit > 200, JSON.stringify(seen));
      assert.ok(seen.wrong <= 0.01 * (seen.dark + seen.lit), `sun from ${azimuth}: ${JSON.stringify(seen)}`);
    }
  });
});

test('ground is coloured by a colour map, and a file brings another', kTest, () =>
  visit('ground=heights&fog=0', async (page) => {
    const legend = page.locator('.legend');
    assert.match(await legend.evaluate((l) => l.style.backgroundImage), /linear-gradient/);
    assert.match(await legend.textContent(), /\d m$/);
    const shown = async () => {
      const { frames } = await status(page);
      await until(page, (s, n) => s.frames > n + 2, frames);
      return middleOf(page);
    };
    const first = await shown();
    await page.locator('[name=colours]').selectOption('viridis');
    const second = await shown();
    assert.ok((await changedShare(page, first, second)) > 0.3);
    const file = (name, text) => ({ name, mimeType: 'text/plain', buffer: Buffer.from(text) });
    await page.locator('[name=colour_file]').setInputFiles(file('bad.cpt', '0 red 1 blue\n1 red 2 mauve-ish\n'));
    await page.getByText('bad, line 2: "mauve-ish" is no colour that is known').waitFor();
    assert.equal(await page.locator('[name=colours]').inputValue(), 'viridis');
    await page.getByRole('button', { name: 'Close' }).click();
    await page.locator('[name=colour_file]').setInputFiles(file('mine.cpt', '-9000 255/0/0 9000 255/0/0\n'));
    const third = await shown();
    assert.equal(await page.locator('[name=colours]').inputValue(), 'mine');
    assert.ok((await changedShare(page, second, third)) > 0.3);
    assert.equal(await page.locator('#notice').isVisible(), false);
  }));

// 2 MiB for each sixtieth of a second that a frame took. A picture is uploaded whole, so one of them may be more.
test('no frame uploads more than its share while tiles come in flight', kTest, async () => {
  const pictured = await startServer(await makeSceneWithPicture(folder.folder));
  try {
    await visit('tour=canyon&shadows=1&sun=free', async (page) => {
      const { keyframes } = await until(page, (s) => s.touring && s.relief_shown > 0 && s.imagery_shown > 0);
      await page.locator('[name=sun_azimuth_deg]').fill('100'); // and all shadows change
      const { largest_upload, tiles_received } = await until(page, (s, n) => s.keyframes > n + 40, keyframes);
      assert.ok(tiles_received > 10, `${tiles_received} tiles`);
      assert.ok(largest_upload > 0 && largest_upload <= 1 + 320 / 2048, `${largest_upload} of what a frame may upload`);
    }, { server: pictured });
  } finally {
    await pictured.stop();
  }
});

test('tiles that are held are not sent again', kTest, () =>
  visit('', async (page) => {
    const before_ = await untilTiles(page);
    await server.stop();
    await page.getByText('Connection lost').waitFor();
    server = await startServer(scene, server.port);
    const now = await until(page, (s, n) => s.connected && s.keyframes >= n, before_.keyframes + 8);
    assert.ok(before_.tiles > 0 && now.tiles >= before_.tiles, `${before_.tiles} tiles, then ${now.tiles}`);
    assert.equal(now.tiles_received, now.tiles, 'each was received once');
    assert.ok(now.relief_shown >= before_.relief_shown);
  }, { expected: /WebSocket|ERR_CONNECTION/ }));

test('a picture lies over the ground, where it belongs, and says whose it is', kTest, async () => {
  const painted = await startServer(await makeSceneWithPicture(folder.folder));
  try {
    await visit('view=0,-1500,6000,0,-80&fog=0', async (page) => {
      await until(page, (s) => s.imagery_shown > 1 && s.relief_shown > 0);
      await untilTiles(page);
      assert.equal(await page.locator('#credits').textContent(), 'Painted by a test');
      const sides = await sidesOf(page);
      assert.ok(sides.left[0] > 2 * sides.left[1], `the west is red: ${sides.left}`);
      assert.ok(sides.right[1] > 1.5 * sides.right[0], `the east is green: ${sides.right}`);
      await page.locator('[name=imagery]').uncheck();
      const { frames } = await status(page);
      await until(page, (s, n) => s.frames > n + 2, frames);
      assert.equal(await page.locator('#credits').textContent(), '');
      const bare = await sidesOf(page);
      assert.ok(bare.left[0] < 2 * bare.left[1], `no picture: ${bare.left}`);
    }, { server: painted });
    await visit('tour=orbit&fog=0', async (page) => {
      // While the first tiles come, a level with each mesh.
      const { imagery_shown } = await until(page, (s) => s.touring && s.imagery_shown > 0);
      const all = await compareEnds(page, 6);
      assert.ok((await status(page)).imagery_shown > imagery_shown, 'tiles have come');
      const shareOf = (key) => Math.max(...all.map((one) => one[key] / one.pixels));
      assert.ok(shareOf('moved') > 0.01, `only ${shareOf('moved')} of the pixels change from beginning to end`);
      assert.ok(shareOf('visible') < 0.004, `${shareOf('visible')} of the pixels differ visibly from mesh to mesh`);
    }, { server: painted, width: 640, height: 360 });
  } finally {
    await painted.stop();
  }
});

// The mean colour to the left and to the right of the middle.
async function sidesOf(page) {
  const data = `data:image/png;base64,${(await middleOf(page)).toString('base64')}`;
  return page.evaluate(async (url) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(url.split(',')[1]), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const meanOf = (x, width) => {
      const { data: pixels } = context.getImageData(x, 0, width, image.height);
      return [0, 1, 2].map((k) => pixels.reduce((sum, v, i) => (i % 4 === k ? sum + v : sum), 0) / (pixels.length / 4));
    };
    const third = Math.floor(image.width / 3);
    return { left: meanOf(0, third), right: meanOf(2 * third, third) };
  }, data);
}

test('relief, the sun and the colours of the ground are chosen', kTest, () =>
  visit('fog=0&tau=1', async (page) => {
    await untilTiles(page);
    const changes = async (choose) => {
      const before_ = await middleOf(page);
      await choose();
      const { frames } = await status(page);
      await until(page, (s, n) => s.frames > n + 2, frames);
      return changedShare(page, before_, await middleOf(page));
    };
    for (const ground of ['plain', 'slope', 'aspect', 'natural'])
      assert.ok((await changes(() => page.locator('[name=ground]').selectOption(ground))) > 0.3, ground);
    assert.ok((await changes(async () => {
      await page.locator('[name=sun]').selectOption('free');
      await page.locator('[name=sun_azimuth_deg]').fill('135');
    })) > 0.1, 'the sun in the south-east');
    const without = await changes(() => page.locator('[name=relief]').uncheck());
    assert.ok(without < 0.3, `the mesh's own normals are much the same, but ${without} of the pixels changed`);
  }));

test('scene time is dragged, runs to its end, and stops', kTest, async () => {
  const day_ms = 86_400_000;
  const [first, last] = [Date.UTC(2000, 0, 1), Date.UTC(2002, 0, 1)];
  const moving = await startServer(await makeMovingScene(folder.folder));
  try {
    await visit('', async (page) => {
      const bar = page.locator('#time');
      assert.equal(await bar.isVisible(), true);
      assert.equal(await bar.locator('.ticks i').count(), 3);
      assert.equal((await status(page)).scene_time_ms, first);
      const drag = (ms) => bar.locator('input').evaluate((slider, value) => {
        slider.value = String(value);
        slider.dispatchEvent(new Event('input'));
        slider.dispatchEvent(new Event('change'));
        return Number(slider.value); // of a whole step
      }, ms);
      const before_ = await page.screenshot();
      const middle = await drag(first + 200 * day_ms); // 17 s before its end at the speed below: a page that is slow stops it in time
      await until(page, (s, ms) => s.scene_time_ms === ms, middle);
      assert.equal(await bar.locator('output').textContent(), new Date(middle).toISOString().slice(0, 10));
      assert.ok((await changedShare(page, before_, await page.screenshot())) > 0.1, 'the ground is another one');
      await bar.locator('select').selectOption('30');
      await bar.locator('button').click();
      await until(page, (s, ms) => s.scene_time_ms > ms + 20 * 86_400_000, middle);
      await bar.locator('button').click(); // stops
      assert.equal(await bar.locator('button').getAttribute('aria-label'), 'Run scene time');
      const { keyframes } = await status(page);
      const stopped = await until(page, (s, n) => s.keyframes > n + 15, keyframes);
      assert.ok(stopped.scene_time_ms > middle && stopped.scene_time_ms < last, 'it neither went back nor ran to its end');
      assert.equal((await until(page, (s, n) => s.keyframes > n + 10, stopped.keyframes)).scene_time_ms, stopped.scene_time_ms);
      await bar.locator('select').selectOption('365');
      await bar.locator('button').click();
      await until(page, (s, ms) => s.scene_time_ms === ms, last);
      assert.equal(await bar.locator('button').getAttribute('aria-label'), 'Run scene time');
      await bar.locator('select').selectOption('30');
      await bar.locator('button').click(); // once more, from the first date, though the last is still shown
      await until(page, (s, ms) => s.scene_time_ms < ms, last);
      assert.equal(await bar.locator('button').getAttribute('aria-label'), 'Stop scene time');
      // What an area has gained since a date, until the ground that is shown.
      await bar.locator('button').click();
      const shown = await drag(first + 300 * day_ms);
      await until(page, (s, ms) => s.scene_time_ms === ms, shown);
      await page.getByRole('button', { name: 'Measure', exact: true }).click();
      const { width, height } = page.viewportSize();
      for (const [x, y, count] of [[0.45, 0.75, 1], [0.58, 0.75, 2], [0.52, 0.6, 3]]) {
        await page.mouse.click(x * width, y * height);
        await until(page, (s, n) => s.measured_corners === n, count);
      }
      const since_first = (await status(page)).measured_change;
      assert.deepEqual([since_first.since_ms, since_first.until_ms], [first, shown]);
      assert.match(await page.locator('#measure').textContent(), new RegExp(`Gained until ${new Date(shown).toISOString().slice(0, 10)}`));
      await page.locator('[name=measure_since]').selectOption(String(last));
      const since_last = (await until(page, (s, ms) => s.measured_change?.since_ms === ms, last)).measured_change;
      assert.ok(Math.abs(since_first.gained_m3 - since_first.lost_m3 - since_last.gained_m3 + since_last.lost_m3) > 1, JSON.stringify([since_first, since_last]));
    }, { server: moving });
  } finally {
    await moving.stop();
  }
});

// Drags the time line to the step nearest to a time, and waits until its ground is shown.
async function showGroundAt(page, wanted_ms) {
  const at = await page.locator('#time input').evaluate((s, ms) => {
    s.value = String(ms);
    for (const event of ['input', 'change']) s.dispatchEvent(new Event(event));
    return Number(s.value);
  }, wanted_ms);
  await until(page, (s, ms) => s.scene_time_ms === ms, at);
  const { keyframes } = await status(page);
  await until(page, (s, n) => s.keyframes > n + 8, keyframes);
}

// Its first ground, two between, and its last, side by side. FORELAND_MOVING_SCENE and FORELAND_MOVING_VIEW choose another scene and
// view: the picture in the documents is of Mount St. Helens (README.md, foreland build), with FORELAND_SCREENSHOT=1 from
// FORELAND_MOVING_VIEW=60,-2000,2550,180,-16.
test('the strip of a ground that changes', kTest, async () => {
  const moving = await startServer(process.env.FORELAND_MOVING_SCENE ?? await makeMovingScene(folder.folder));
  const view = process.env.FORELAND_MOVING_VIEW ?? '';
  try {
    await visit(view === '' ? '' : `view=${view}&fog=0`, async (page) => {
      const slider = page.locator('#time input');
      const [first, last] = await slider.evaluate((s) => [Number(s.min), Number(s.max)]);
      const pictures = [];
      for (const share of kSaves ? [0, 0.62, 0.78, 1] : [0, 1]) {
        await showGroundAt(page, first + share * (last - first));
        const { width, height } = page.viewportSize();
        const date = await page.locator('#time output').textContent();
        const clip = { x: 0.34 * width, y: 0.16 * height, width: 0.32 * width, height: 0.62 * height };
        pictures.push({ date, data: (await page.screenshot({ clip })).toString('base64') });
      }
      assert.ok((await changedShare(page, ...[0, 1].map((i) => Buffer.from(pictures[i * (pictures.length - 1)].data, 'base64')))) > 0.02);
      if (!kSaves) return;
      await page.evaluate((all) => {
        const strip = document.createElement('div');
        strip.append(...all.map(({ date, data }) => {
          const figure = document.createElement('figure');
          const image = Object.assign(new Image(), { src: `data:image/png;base64,${data}` });
          const caption = Object.assign(document.createElement('figcaption'), { textContent: date });
          Object.assign(figure.style, { margin: 0, position: 'relative' });
          Object.assign(caption.style, { position: 'absolute', left: '10px', bottom: '8px', font: '600 15px sans-serif', textShadow: '0 1px 4px #000' });
          figure.append(image, caption);
          return figure;
        }));
        Object.assign(strip.style, { position: 'fixed', inset: '0', zIndex: 9, display: 'grid', gap: '4px', background: '#fff',
          gridTemplateColumns: `repeat(${all.length}, max-content)` });
        document.body.append(strip);
      }, pictures);
      await page.setViewportSize({ width: 1651, height: 446 });
      await save(page, 'moving.png');
    }, { server: moving, ...(kSaves ? { width: 1280, height: 720, sharpness: 1 } : {}) });
  } finally {
    await moving.stop();
  }
});

// The picture in the documents is made as the strip is.
test('ground is coloured by how far it has moved since the first date', kTest, async () => {
  const moving = await startServer(process.env.FORELAND_MOVING_SCENE ?? await makeMovingScene(folder.folder));
  const view = process.env.FORELAND_MOVING_VIEW ?? '';
  try {
    await visit(`ground=change&fog=0${view === '' ? '' : `&view=${view}`}`, async (page) => {
      const slider = page.locator('#time input');
      const [first, last] = await slider.evaluate((s) => [Number(s.min), Number(s.max)]);
      const risenAt = async (ms) => {
        await showGroundAt(page, ms);
        return risenShare(page);
      };
      const legend = page.locator('#panel .legend.change');
      const [low, , middle, , high] = await legend.locator('span').allTextContents();
      assert.match(high, /^\+\d+ m$/);
      assert.equal(low, high.replace('+', '\u2212'));
      assert.equal(middle, '0');
      assert.equal(await risenAt(first), 0, 'nothing has risen');
      const risen = await risenAt(last);
      assert.ok(risen > 0.002, `a share of ${risen} has risen`);
      await page.locator('input[name=change]').evaluate((range) => {
        range.value = '-1';
        range.dispatchEvent(new Event('input'));
      });
      const [, , , , half] = await legend.locator('span').allTextContents();
      assert.ok(Math.abs(2 * parseFloat(half) - parseFloat(high)) < 2, `${half} is half of ${high}`);
      const { frames } = await status(page);
      await until(page, (s, n) => s.frames > n + 2, frames);
      assert.ok((await risenShare(page)) > risen, 'smaller changes have stronger colours');
      await page.locator('#panel .body').evaluate((body) => body.scrollTo(0, body.scrollHeight));
      await save(page, 'change.png');
    }, { server: moving, ...(kSaves ? { width: 1280, height: 720, sharpness: 1 } : {}) });
  } finally {
    await moving.stop();
  }
});

// The share of a page's ground that is clearly red.
async function risenShare(page) {
  const { width, height } = page.viewportSize();
  const picture = await page.screenshot({ clip: { x: 0.3 * width, y: 0.3 * height, width: 0.4 * width, height: 0.5 * height } });
  return page.evaluate(async (coded) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(coded), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let red = 0;
    for (let i = 0; i < data.length; i += 4) red += data[i] - data[i + 2] > 90 ? 1 : 0;
    return red / (data.length / 4);
  }, picture.toString('base64'));
}

test('a scene that does not change has no time line, and no colours of change', kTest, () =>
  visit('ground=change', async (page) => {
    assert.equal(await page.locator('#panel .legend').isVisible(), false);
    assert.equal(await page.locator('#time').isVisible(), false);
  }));

test('a model without an image is drawn, and none is asked for', kTest, async () => {
  const plain = await startServer(await makeSceneWithObjects(folder.folder, 3, false));
  try {
    await visit('tour=orbit&tau=1', async (page) => {
      const asked = [];
      page.on('request', (request) => asked.push(request.url()));
      const { keyframes } = await until(page, (s) => s.object_triangles > 3 * 96);
      await until(page, (s, n) => s.keyframes > n + 3, keyframes);
      assert.deepEqual(asked.filter((url) => url.includes('models/')), []);
    }, { server: plain }); // and the console has nothing to complain of
  } finally {
    await plain.stop();
  }
});

// The share of the screen's middle that is green beyond what the ground is.
async function greenShare(page) {
  return page.evaluate(async (data) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data: pixels } = context.getImageData(0, 0, image.width, image.height);
    let green = 0;
    for (let i = 0; i < pixels.length; i += 4) if (pixels[i + 1] > 1.4 * pixels[i] && pixels[i + 1] > 1.4 * pixels[i + 2]) ++green;
    return green / (pixels.length / 4);
  }, (await middleOf(page)).toString('base64'));
}
const nextFrames = async (page) => until(page, (s, n) => s.frames > n + 2, (await status(page)).frames);

test('shift-click draws a line of sight, and V what is seen', kTest, async () => {
  const own = await makeFolder();
  const small = await startServer(await makeScene(own.folder, { size: 129 }));
  try {
    await visit('fog=0', async (page) => {
      const shiftClick = async (x, y) => {
        await page.keyboard.down('Shift');
        await page.mouse.click(x, y);
        await page.keyboard.up('Shift');
      };
      await page.mouse.click(480, 400);
      await nextFrames(page);
      assert.equal((await status(page)).sight_marked, false, 'a click without Shift marks nothing');
      await shiftClick(480, 400);
      await until(page, (s) => s.sight_marked && s.sight_seen === null);
      await shiftClick(520, 330);
      await until(page, (s) => !s.sight_marked && s.sight_seen !== null);
      assert.match(await page.locator('#hint').textContent(), /^(Seen\.|Hidden behind the ground\.)$/);
      await nextFrames(page);
      const before_ = await greenShare(page);
      await page.keyboard.press('KeyV');
      await until(page, (s) => s.viewshed_known === 1 && !s.viewshed_coming);
      assert.match(await page.locator('#hint').textContent(), /^[\d.]+ % of the ground around is seen/);
      await nextFrames(page);
      const draped = await greenShare(page);
      assert.ok(draped > before_ + 0.1, `${draped} of the picture is green, ${before_} before`); // from the camera: what it sees is seen
      await page.keyboard.press('KeyV');
      await until(page, (s) => s.viewshed_known === null);
      await nextFrames(page);
      assert.ok((await greenShare(page)) < before_ + 0.02);
      // Ended as it comes, it leaves nothing, and another one can be asked for.
      await page.evaluate(() => {
        window.dispatchEvent(new KeyboardEvent('keydown', { code: 'KeyV' }));
        window.coming = window.foreland.status().viewshed_coming;
        window.dispatchEvent(new KeyboardEvent('keydown', { code: 'Escape' }));
      });
      assert.equal(await page.evaluate(() => window.coming), true);
      const ended = await nextFrames(page);
      assert.deepEqual([ended.viewshed_coming, ended.viewshed_known], [false, null]);
      await page.keyboard.press('KeyV');
      await until(page, (s) => s.viewshed_known === 1);
    }, { server: small });
  } finally {
    await small.stop();
    await own.remove();
  }
});

// Small, but when the picture is asked for.
test('the picture of hidden valleys, frozen and seen from outside', kTest, async () => {
  const occluding = await startServer(scene, 0, ['--occlusion', 'on']);
  try {
    await visit('wireframe=1&fog=0', async (page) => {
      await until(page, (s) => s.keyframes > 5);
      await page.locator('[name=frozen]').check();
      const { eye } = await until(page, (s) => s.frozen);
      const middle = kSaves ? 640 : 400;
      await page.locator('#scene').focus();
      await page.mouse.move(middle, 200);
      await page.mouse.wheel(0, -2500); // speed
      await page.keyboard.down('KeyE');
      await page.keyboard.down('KeyS');
      await until(page, (s, e) => s.eye[2] - e[2] > 2500, eye);
      await page.keyboard.up('KeyE');
      await page.keyboard.up('KeyS');
      await page.mouse.down();
      await page.mouse.move(middle, 50, { steps: 5 });
      await page.mouse.up();
      const { frames } = await status(page);
      await until(page, (s, n) => s.frames > n + 2, frames);
      await save(page, 'hidden.png');
    }, { server: occluding, ...(kSaves ? { width: 1280, height: 720, sharpness: 1 } : { width: 960, height: 540 }) });
  } finally {
    await occluding.stop();
  }
});

test('the compass turns the view to the north, and the scale bar is as long on the ground as it says', kTest, () =>
  visit('view=0,-2000,4000,130,-80', async (page) => {
    const button = page.getByRole('button', { name: /^Compass: 130 degrees/ });
    const bar = page.locator('#compass .scale');
    await bar.filter({ hasText: /^\d/ }).waitFor();
    const { above_ground_m } = await status(page);
    const [size, unit] = (await bar.textContent()).split(' '), metres = Number(size) * (unit === 'km' ? 1000 : 1);
    const { width } = await bar.boundingBox(), { height } = page.viewportSize();
    const seen_m = (width / height) * 2 * Math.tan((55 * Math.PI) / 360) * above_ground_m; // straight below
    assert.ok(Math.abs(metres / seen_m - 1) < 0.15, `${metres} m, not ${seen_m} m`);
    await button.click();
    await until(page, (s) => s.heading === 0);
    await page.getByRole('button', { name: /^Compass: 0 degrees/ }).waitFor();
  }));

test('points, lines and areas are measured by mouse and by keys', kTest, () =>
  visit('', async (page) => {
    const rows = () => page.locator('#measure dt').allTextContents();
    const measured = (n) => until(page, (s, count) => s.measured_corners === count, n);
    await page.getByRole('button', { name: 'Measure', exact: true }).click();
    await page.mouse.click(420, 330);
    await measured(1);
    assert.deepEqual((await rows()).slice(-2), ['Slope', 'Falls towards']);
    await page.mouse.click(540, 340);
    const line = await measured(2);
    assert.ok(line.measured_m > 10, `${line.measured_m} m`);
    assert.deepEqual((await rows()).slice(0, 3), ['Length', 'Along the ground', 'Straight']);
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'CSV' }).click();
    const file = join(folder.folder, 'profile.csv');
    await (await download).saveAs(file);
    const [header, ...places] = (await readFile(file, 'utf8')).trim().split('\n');
    assert.match(header, /,distance_m,height_m$/);
    assert.ok(Math.abs(Number(places.at(-1).split(',')[2]) - line.measured_m) < 0.01);
    await page.locator('#measure svg').hover();
    await page.getByText(/ along: .* high$/).waitFor();

    await page.locator('#scene').focus();
    await page.keyboard.press('Enter'); // what is in the middle
    assert.ok((await measured(3)).measured_m2 > 100);
    assert.ok((await rows()).includes('On the slope'));
    await page.getByRole('button', { name: 'Units: metric' }).click();
    assert.match(await page.locator('#measure dd').first().textContent(), / (ft|mi)$/);
    await page.locator('#scene').focus();
    await page.keyboard.press('Backspace');
    assert.equal((await measured(2)).measured_m2, null);
    await page.mouse.click(480, 30); // the sky
    await page.getByText('There is no ground to measure there.').waitFor();
    await page.keyboard.press('Escape');
    assert.equal((await until(page, (s) => !s.measuring)).measured_corners, 0);
    assert.equal(await page.locator('#measure').isVisible(), false);
  }));

// Pictures go to docs/images only when asked for, so that a test run leaves the checkout as it was.
async function save(page, name) {
  await page.evaluate(() => document.getElementById('hint')?.toggleAttribute('hidden', true));
  const to = kSaves ? join(root, 'docs/images') : folder.folder;
  await mkdir(to, { recursive: true });
  await page.screenshot({ path: join(to, name) });
}
