// The page without a mouse, for who wants less motion or more contrast, and its small map; in headless Chromium against the real server.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { changedShare, fingersOf, makeFolder, makeSceneOnEarth, openBrowser, openSources, pictureOf, root, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 300_000 };
let folder, server, browser, sources, pads, language;

before(async () => {
  sources = await openSources();
  [pads, language] = await Promise.all(['ui/gamepad.ts', 'ui/language.ts'].map((path) => sources.load(path)));
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

const visit = (query, body, options = {}) =>
  visitPage(browser, new URL(`?sharpness=0.25&tau=4&${query}`, server.url), body, { width: 960, height: 640, ...options });
const pad = (axes, pressed = {}, mapping = 'standard') =>
  ({ mapping, connected: true, axes, buttons: Array.from({ length: 16 }, (_, i) => ({ pressed: (pressed[i] ?? 0) > 0.5, value: pressed[i] ?? 0 })) });

test('a gamepad rests in the middle, and moves and looks outside of that', () => {
  assert.equal(pads.padState([]), null);
  assert.equal(pads.padState([null, pad([0.14, -0.14, 0.1, 0])]), null);
  assert.equal(pads.padState([pad([1, 1, 1, 1], {}, '')]), null);
  assert.deepEqual(pads.padState([pad([1, -1, 0, 1], { 7: 1, 5: 1 })]), { move: [1, 1, 1], look: [0, -1], is_faster: true });
  const [right] = pads.padState([pad([0.575, 0, 0, 0])]).move;
  assert.ok(Math.abs(right - 0.5) < 1e-9);
});

test("a headset's sticks move, turn and rise", () => {
  const held = (handedness, x, y, trigger = 0) => ({ handedness, gamepad: { mapping: 'xr-standard', axes: [0, 0, x, y], buttons: [{ value: trigger }] } });
  assert.equal(pads.headsetPad([]), null);
  assert.equal(pads.headsetPad([held('left', 0.1, -0.1), { handedness: 'right', gamepad: null }]), null);
  assert.deepEqual(pads.headsetPad([held('left', 1, -1), held('right', -1, 1, 1)]), { move: [1, 1, -1], look: [-1, 0], is_faster: true });
});

test('a language is the one that is asked for, or the first of the reader that there is; unknown words stay', () => {
  const of = language.languageOf;
  assert.deepEqual([of(null, []), of(null, ['it', 'fr-CA', 'de']), of('es', ['de']), of('xx', ['de-AT'])], ['en', 'fr', 'es', 'de']);
  assert.equal(language.translated('Contours', 'de'), 'Höhenlinien');
  assert.deepEqual([language.translated('Contours', 'en'), language.translated('12 m', 'fr')], ['Contours', '12 m']);
  // Of bars there is no more room on the smallest screens than for English.
  for (const bar of [['Measure', 'Cut', 'Path', 'Record', 'Share'], ['Survey', 'Canyon', 'Spin', 'Orbit']])
    for (const each of language.kLanguages) assert.ok(bar.map((word) => language.translated(word, each)).join('').length <= bar.join('').length + 1, `${bar} ${each}`);
});

const kApart_m = 40;
// An emulator (iwer), with two eyes so far apart that it is seen, and matters.
async function addHeadset(page) {
  await page.addInitScript({ path: join(root, 'client/web/node_modules/iwer/build/iwer.min.js') });
  await page.addInitScript((ipd) => {
    window.device = new window.IWER.XRDevice(window.IWER.metaQuest3, { stereoEnabled: true, visibilityMask: null, ipd });
    window.device.installRuntime({ forceInstall: true });
  }, kApart_m);
}

// What is stated holds for both eyes: the server is told how far they are from the middle, and nothing is guaranteed until its regions are so wide.
async function checkHeadset(page) {
  const isBoth = (s, apart_m) => s.headset_eyes.length === 2 && Math.abs(Math.hypot(...s.headset_eyes[0].map((v, k) => v - s.headset_eyes[1][k])) - apart_m) < 1e-3 && s.tau_px < 4.001;
  const halves = async () => { // of one frame
    const { width, height } = page.viewportSize(), picture = await page.screenshot();
    return changedShare(page, picture, picture, [0, width / 2].map((x) => [x, 0, width / 2, height]));
  };
  const canvas = await page.locator('#scene').boundingBox();
  await page.locator('[name=headset]').click();
  const { eye, headset_eyes: [left, right] } = await until(page, isBoth, kApart_m);
  assert.ok(Math.hypot(...eye.map((v, k) => (left[k] + right[k]) / 2 - v)) < 2, `${[left, right]} about ${eye}`);
  const apart = await halves();
  assert.ok(apart > 0.02, `each eye has a picture of its own: they differ in ${apart}`);
  await page.evaluate(() => (window.device.ipd = 0));
  const { frames } = await until(page, isBoth, 0);
  await until(page, (s, before) => s.frames > before + 1, frames);
  const together = await halves();
  assert.ok(together < 0.002, `eyes in one place see the same: they differ in ${together}`);
  await page.evaluate(() => window.device.controllers.left.updateAxis('thumbstick', 'y-axis', -1));
  await until(page, (s, from) => Math.hypot(...s.eye.map((v, k) => v - from[k])) > 20, eye);
  await page.evaluate(() => {
    window.device.controllers.left.updateAxis('thumbstick', 'y-axis', 0);
    return window.device.activeSession.end();
  });
  await until(page, (s) => s.headset_eyes.length === 0 && s.tau_px < 4.001);
  assert.deepEqual(await page.locator('#scene').boundingBox(), canvas);
  assert.ok((await pictureOf(page)).colours > 100);
}

test('a gamepad flies the camera, and takes it from a tour; a headset shows the scene to each eye', kTest, () =>
  visit('tour=survey&contours=1&wireframe=1', async (page) => { // so that there is something to see
    await until(page, (s) => s.touring);
    await page.evaluate((axes) => (navigator.getGamepads = () => [{ mapping: 'standard', connected: true, axes, buttons: [] }]), [0, -1, 0, 0]);
    const { eye } = await until(page, (s) => !s.touring);
    await until(page, (s, from) => Math.hypot(...s.eye.map((v, k) => v - from[k])) > 20, eye);
    const { heading } = await status(page);
    await page.evaluate((axes) => (navigator.getGamepads = () => [{ mapping: 'standard', connected: true, axes, buttons: [] }]), [0, 0, 1, 0]);
    await until(page, (s, before) => s.heading > before + 0.1, heading);
    await page.evaluate(() => (navigator.getGamepads = () => []));
    await checkHeadset(page);
  }, { prepare: async (page) => {
    await page.addInitScript(() => (navigator.getGamepads = () => []));
    await addHeadset(page);
  } }));

test('the map shows the scene, and a click goes there; nothing serious is wrong for people with other needs', kTest, () =>
  visit('map=1&view=0,0,3000,0,-20', async (page) => {
    const { eye } = await until(page, (s) => s.map && s.relief_shown > 0);
    const box = await page.locator('#map canvas').boundingBox();
    await page.mouse.click(box.x + 0.25 * box.width, box.y + 0.25 * box.height);
    const there = await until(page, (s, from) => Math.hypot(s.eye[0] - from[0], s.eye[1] - from[1]) > 1000, eye);
    assert.ok(there.eye[0] < eye[0] - 1000 && there.eye[1] > eye[1] + 1000, `${there.eye} from ${eye}`);
    await page.evaluate(await readFile(join(root, 'client/web/node_modules/axe-core/axe.min.js'), 'utf8'));
    const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'] }));
    assert.deepEqual(violations.filter(({ impact }) => ['serious', 'critical'].includes(impact)).map(({ id, nodes }) => `${id}: ${nodes[0].html}`), []);
  }));

test('two fingers tilt, turn and near what lies between them, and three carry along', kTest, () =>
  visit('view=0,-2500,3500,0,-40', async (page) => {
    await page.evaluate(() => document.activeElement?.blur());
    const move = await fingersOf(page), [x, y] = [480, 320], point = await page.evaluate(([x, y]) => window.foreland.groundAt(x, y), [x, y]);
    const away = ({ eye }) => Math.hypot(...eye.map((v, k) => v - point[k])), seen = () => page.evaluate((at) => window.foreland.onScreen(at), point);
    const pair = (apart, angle = 0, up = 0) => [-1, 1].map((side) => [x + side * apart * Math.cos(angle), y - up + side * apart * Math.sin(angle)]);
    const before = await status(page);
    const isHeld = async (name) => {
      const [sx, sy] = await seen();
      assert.ok(Math.hypot(sx - x, sy - y) < 3, `${name}: what lay between the fingers is at ${sx}, ${sy}`);
    };
    const tilted = await move(pair(80), pair(80, 0, 60));
    assert.ok(tilted.pitch > before.pitch + 0.2 && tilted.pitch < before.pitch + 0.35, `${tilted.pitch} after ${before.pitch}`);
    assert.ok(Math.abs(away(tilted) / away(before) - 1) < 1e-3 && tilted.eye[2] < before.eye[2] - 300, `${tilted.eye}`);
    await isHeld('tilted');
    const turned = await move(pair(80), pair(80, 0.5));
    assert.ok(Math.abs(turned.heading - tilted.heading + 0.5) < 0.02, `${turned.heading} after ${tilted.heading}`);
    assert.ok(Math.abs(away(turned) / away(tilted) - 1) < 1e-3 && Math.abs(turned.pitch - tilted.pitch) < 0.02);
    await isHeld('turned');
    const near = await move(pair(80), pair(120));
    assert.ok(Math.abs((1.5 * away(near)) / away(turned) - 1) < 0.01, `${away(near)} m after ${away(turned)} m`);
    await isHeld('neared');
    await page.screenshot({ path: process.env.KEEP ? `${process.env.KEEP}/touch.png` : undefined });
    const three = [[400, 300], [480, 300], [560, 300]], carried = await move(three, three.map(([fx, fy]) => [fx, fy + 60]));
    const [ahead, aside] = [carried.eye[0] - near.eye[0], carried.eye[1] - near.eye[1]];
    assert.ok(Math.hypot(ahead, aside) > 50 && Math.abs(Math.atan2(ahead, aside) - near.heading) < 0.1, `${carried.eye} after ${near.eye}`);
    assert.ok(Math.abs(carried.pitch - near.pitch) < 1e-9 && Math.abs(carried.eye[2] - near.eye[2]) < 2);
  }, { mobile: true }));

test('who wants less motion stops at once', kTest, () =>
  visit('view=0,0,3000,0,-20', async (page) => {
    await page.evaluate(() => document.activeElement?.blur());
    await page.keyboard.down('KeyW');
    const { eye } = await status(page);
    await until(page, (s, from) => Math.hypot(...s.eye.map((v, k) => v - from[k])) > 5, eye);
    await page.keyboard.up('KeyW');
    const { frames } = await status(page);
    const stopped = await until(page, (s, n) => s.frames > n + 1, frames);
    const later = await until(page, (s, n) => s.frames > n + 3, stopped.frames);
    assert.deepEqual(later.eye, stopped.eye);
  }, { prepare: (page) => page.emulateMedia({ reducedMotion: 'reduce', contrast: 'more' }) }));
