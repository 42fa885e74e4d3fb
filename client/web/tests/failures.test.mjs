// The page in headless Chromium where something fails: it says what, and what to do, and nothing goes on half-dead; or it does without.
// Every wait is for a condition.
import assert from 'node:assert/strict';
import { cp, readdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { changedShare, makeFolder, makeSceneWithObjects, makeSceneWithPicture, middleOf, openBrowser, openPage, page_folder, startServer, status, until, untilTerrain } from './support.mjs';

const kTest = { timeout: 180_000 };
let folder, pictured, server, crowd, crowded, browser;

before(async () => {
  folder = await makeFolder();
  pictured = await makeSceneWithPicture(folder.folder);
  server = await startServer(pictured);
  crowd = await makeSceneWithObjects(folder.folder, 3);
  crowded = await startServer(crowd);
  browser = await openBrowser();
}, kTest);

after(async () => {
  await browser?.close();
  await server?.stop();
  await crowded?.stop();
  await folder?.remove();
});

// Runs `body` with a page that `prepare` has had before it was opened. What it complains of has to be what `complains` says, and may be
// what `expected` says.
async function visit(query, { prepare = () => {}, at = server, complains = [], expected }, body) {
  const { page, complaints, close } = await openPage(browser);
  try {
    await prepare(page);
    await page.goto(new URL(`?${query}&sharpness=0.6&tau=4`, at.url).href);
    await body(page);
    const others = complaints.filter((complaint) => !expected?.test(complaint));
    assert.equal(others.length, complains.length, others.join('\n'));
    others.forEach((complaint, i) => assert.match(complaint, complains[i]));
  } finally {
    await close();
  }
}

// Nothing is drawn, and no session goes on.
async function assertEnded(page) {
  const { frames, keyframes, connected } = await status(page);
  assert.equal(connected, false);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const later = await status(page);
  assert.deepEqual([later.frames, later.keyframes], [frames, keyframes]);
}

// The message with which the worker is started is changed by `change`, text of a function.
const startWith = (change) => (page) => page.addInitScript(`{
  const post = Worker.prototype.postMessage;
  Worker.prototype.postMessage = function (message) { post.call(this, message.kind === 'start' ? (${change})(message) : message); };
}`);

test('a client core that fails in flight is told of, and the page is loaded again from there', kTest, () =>
  visit('', {
    prepare: startWith('(start) => ({ ...start, texture_layers: { relief: 7, imagery: 7 } })'), // too few: a check of the module fails
    complains: [1, 2].flatMap(() => [/CHECK failed: texture_layers/, /RuntimeError: unreachable/]), // before it was loaded again, and after
  }, async (page) => {
    await page.getByText('The client core failed.').waitFor();
    assert.match(await page.locator('#notice').textContent(), /unreachable\. The flight has ended\. Reload the page/);
    await assertEnded(page);
    await page.locator('[name=wireframe]').check(); // and the settings do nothing
    const { eye } = await status(page);
    await page.getByRole('button', { name: 'Reload the page' }).click();
    await page.waitForURL(/view=/);
    await page.getByText('The client core failed.').waitFor(); // as it is started likewise
    (await status(page)).eye.forEach((metres, i) => assert.ok(Math.abs(metres - eye[i]) < 1));
  }));

test('a client core that does not start in the worker is told of', kTest, () =>
  visit('', {
    prepare: startWith('(start) => ({ ...start, module: new WebAssembly.Module(Uint8Array.of(0, 0x61, 0x73, 0x6d, 1, 0, 0, 0)) })'),
    complains: [/_initialize/],
  }, async (page) => {
    await page.getByText('The client core did not start.').waitFor();
    await page.getByRole('button', { name: 'Reload the page' }).waitFor();
    await assertEnded(page);
  }));

// Which fails before the client core is there, and after.
for (const is_first of [true, false]) {
  test(`a page without its worker says so, which is missed ${is_first ? 'at once' : 'late'}`, kTest, () => {
    const held = [];
    const prepare = async (page) => {
      await page.route('**/assets/worker-*.js', async (route) => {
        if (!is_first) await until(page, (s) => s.connected === false);
        await route.fulfill({ status: 404, body: 'gone' });
        for (const go of held) go();
      });
      if (is_first) await page.route('**/foreland*.wasm', (route) => new Promise((go) => held.push(go)).then(() => route.continue()));
    };
    return visit('', { prepare, complains: [/worker did not load/] }, async (page) => {
      await page.getByText('A part of the page did not load.').waitFor();
      await page.getByRole('button', { name: 'Reload the page' }).waitFor();
    });
  });
}

test('a message of the worker that cannot be handled ends the session', kTest, () =>
  visit('', {
    prepare: (page) => page.addInitScript(() => Object.defineProperty(document, 'title', { set: () => { throw new Error('a title is refused'); } })),
    complains: [/a title is refused/],
  }, async (page) => {
    await page.getByText('The page failed.').waitFor();
    assert.match(await page.locator('#notice').textContent(), /a title is refused\. The flight has ended\. Reload the page/);
    await assertEnded(page);
  }));

// The context of the canvas that is drawn on.
const loseCard = (page) => page.evaluate(() => document.getElementById('scene').getContext('webgl2').getExtension('WEBGL_lose_context').loseContext());

test('after a graphics card was reset the picture comes back, at the same view and in the same session', kTest, () =>
  visit('view=300,-2200,3500,40,-35&fog=0', {}, async (page) => {
    await until(page, (s) => s.imagery_shown > 1 && s.relief_shown > 1);
    const tiles = await settledTiles(page);
    const [before_, picture] = [await status(page), await middleOf(page)];
    for (let times = 0; times < 2; ++times) {
      await loseCard(page);
      await until(page, (s, n) => s.card_resets === n, times + 1); // it draws on another canvas
      assert.equal(await page.locator('#notice').isVisible(), false);
      await until(page, (s, n) => s.connected && s.triangles > 500 && s.imagery_shown >= n.imagery_shown && s.relief_shown >= n.relief_shown, tiles);
    }
    const now = await status(page);
    assert.deepEqual([now.eye, now.heading], [before_.eye, before_.heading]);
    assert.ok(now.keyframes >= before_.keyframes && now.frames > before_.frames, 'both go on');
    assert.ok(now.tiles_received <= before_.tiles_received + 4, 'no tile is sent again');
    await settledTiles(page);
    const share = await changedShare(page, picture, await middleOf(page));
    assert.ok(share < 0.002, `${share} of the picture is another one`);
    await page.mouse.move(400, 200); // and it is steered there
    await page.mouse.down();
    await page.mouse.move(250, 210, { steps: 4 });
    await page.mouse.up();
    await until(page, (s, h) => s.heading > h + 0.1, now.heading);
  }));

test('while the browser cannot draw the page waits, and says so', kTest, () =>
  visit('', {
    prepare: (page) => page.addInitScript(() => {
      const get = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function (...all) {
        if (all[0] !== 'webgl2' || !window.is_without_card) return get.apply(this, all);
        ++window.asked;
        return null;
      };
    }),
  }, async (page) => {
    const { eye } = await untilTerrain(page);
    await page.evaluate(() => {
      const loser = document.getElementById('scene').getContext('webgl2').getExtension('WEBGL_lose_context');
      Object.assign(window, { is_without_card: true, asked: 0 });
      loser.loseContext();
    });
    await until(page, () => window.asked > 1);
    assert.match(await page.locator('#notice').textContent(), /The picture comes back as soon as/);
    await page.getByRole('button', { name: 'Reload the page' }).waitFor();
    await page.evaluate(() => (window.is_without_card = false));
    await page.locator('#notice').waitFor({ state: 'hidden' });
    const { frames } = await until(page, (s) => s.connected && s.triangles > 500);
    const later = await until(page, (s, n) => s.frames > n + 2, frames);
    assert.deepEqual(later.eye, eye);
  }));

// No tile has come for a while of keyframes.
async function settledTiles(page) {
  for (let last = await status(page); ;) {
    const now = await until(page, (s, n) => s.keyframes > n + 6, last.keyframes);
    if (now.tiles_received === last.tiles_received && now.imagery_shown === last.imagery_shown && now.relief_shown === last.relief_shown) return now;
    last = now;
  }
}

test('an address that is no server is told of', kTest, () =>
  visit('server=nowhere', {}, async (page) => {
    await page.getByText('There is no such server.').waitFor();
  }));

test('images that cannot be decoded are said once and counted, and the flight goes on', kTest, async () => {
  const broken = await startServer(pictured, 0, [], await pageWithWorker(`{
    const decode = self.createImageBitmap;
    let asked = 0;
    self.createImageBitmap = (...all) => (++asked === 3 || asked === 5 ? Promise.reject(new Error('damaged')) : decode(...all));
  }`));
  try {
    await visit('fog=0', { at: broken }, async (page) => {
      await page.getByText('A tile of the ground is damaged: a coarser one stays in its place.').waitFor();
      const { keyframes } = await until(page, (s) => s.imagery_shown > 2 && s.damaged_tiles === 2);
      await until(page, (s, n) => s.connected && s.keyframes > n + 5, keyframes);
      await page.locator('#readout').getByText(/^2 of \d+ damaged$/).waitFor();
      assert.equal(await page.locator('#notice').isVisible(), false);
    });
  } finally {
    await broken.stop();
  }
});

// A copy of the page whose worker begins with `code`.
async function pageWithWorker(code) {
  const web = join(folder.folder, 'web');
  await cp(page_folder, web, { recursive: true });
  const [worker] = (await readdir(join(web, 'assets'))).filter((name) => name.startsWith('worker-')).map((name) => join(web, 'assets', name));
  await writeFile(worker, code + (await readFile(worker, 'utf8')));
  return web;
}

// The connection ends amid the image; it is whole with the next session.
test('an image of a model that does not come is said, and asked for again', kTest, () => {
  const breaks = () => {
    const read = Response.prototype.arrayBuffer;
    let left = 1;
    Response.prototype.arrayBuffer = function () {
      return /rgba$/.test(this.url) && left-- > 0 ? Promise.reject(new TypeError('network error')) : read.call(this);
    };
  };
  return visit('tour=orbit', { prepare: (page) => page.addInitScript(breaks), at: crowded, expected: /ERR_CONNECTION|WebSocket/ }, async (page) => {
    await page.getByText('An image of a model did not come: it is drawn in a plain colour.').waitFor();
    const { object_images, keyframes } = await until(page, (s) => s.object_triangles > 0);
    assert.equal(object_images, 0);
    await until(page, (s, n) => s.keyframes > n + 3, keyframes);
    await crowded.stop();
    await page.getByText('Connection lost').waitFor();
    crowded = await startServer(crowd, crowded.port);
    await until(page, (s) => s.connected && s.object_images === 1);
  });
});

test('a colour map that cannot be read is told of', kTest, () =>
  visit('ground=heights', {
    prepare: (page) => page.addInitScript(() => (Blob.prototype.arrayBuffer = () => Promise.reject(new DOMException('gone', 'NotReadableError')))),
  }, async (page) => {
    await untilTerrain(page);
    await page.locator('[name=colour_file]').setInputFiles({ name: 'mine.cpt', mimeType: 'text/plain', buffer: Buffer.from('0 red 1 blue') });
    await page.getByText('mine.cpt cannot be read: gone').waitFor();
    const { keyframes } = await status(page);
    await until(page, (s, n) => s.connected && s.keyframes > n, keyframes);
  }));
