// The page without a mouse, for who wants less motion or more contrast, and its small map; in headless Chromium against the real server.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { makeFolder, makeSceneOnEarth, openBrowser, openSources, root, startServer, status, until, visitPage } from './support.mjs';

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

test('a language is the one that is asked for, or the first of the reader that there is; unknown words stay', () => {
  const of = language.languageOf;
  assert.deepEqual([of(null, []), of(null, ['it', 'fr-CA', 'de']), of('es', ['de']), of('xx', ['de-AT'])], ['en', 'fr', 'es', 'de']);
  assert.equal(language.translated('Contours', 'de'), 'Höhenlinien');
  assert.deepEqual([language.translated('Contours', 'en'), language.translated('12 m', 'fr')], ['Contours', '12 m']);
  // Of bars there is no more room on the smallest screens than for English.
  for (const bar of [['Measure', 'Cut', 'Path', 'Record', 'Share'], ['Survey', 'Canyon', 'Spin', 'Orbit']])
    for (const each of language.kLanguages) assert.ok(bar.map((word) => language.translated(word, each)).join('').length <= bar.join('').length + 1, `${bar} ${each}`);
});

test('a gamepad flies the camera, and takes it from a tour', kTest, () =>
  visit('tour=survey', async (page) => {
    await until(page, (s) => s.touring);
    await page.evaluate((axes) => (navigator.getGamepads = () => [{ mapping: 'standard', connected: true, axes, buttons: [] }]), [0, -1, 0, 0]);
    const { eye } = await until(page, (s) => !s.touring);
    await until(page, (s, from) => Math.hypot(...s.eye.map((v, k) => v - from[k])) > 20, eye);
    const { heading } = await status(page);
    await page.evaluate((axes) => (navigator.getGamepads = () => [{ mapping: 'standard', connected: true, axes, buttons: [] }]), [0, 0, 1, 0]);
    await until(page, (s, before) => s.heading > before + 0.1, heading);
  }, { prepare: (page) => page.addInitScript(() => (navigator.getGamepads = () => [])) }));

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
