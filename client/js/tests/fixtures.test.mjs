// The package as it is packed, in pages that others' tools have built: Vite, webpack 5, esbuild, an import map without any of them, and the
// one file for pages that have nothing; with this version of three and with the oldest one that is supported.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { complainOfWarnings, makeFolder, makeScene, openBrowser, openPage, startServer } from './support.mjs';
import { pack, projects } from './projects.mjs';
import { serveFolder } from './static_server.mjs';

const kTest = { timeout: 300_000 };
let folder, server, files, browser, packed;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeScene(folder.folder, { size: 257 }));
  files = await serveFolder(folder.folder);
  browser = await openBrowser();
  packed = await pack(folder.folder);
}, kTest);
after(async () => {
  await browser?.close();
  for (const one of [server, files]) await one?.stop();
  await folder?.remove();
});

// The project's page flies; nothing goes wrong in it.
async function flies(name) {
  const path = await projects[name]({ folder: folder.folder, packed });
  const { page, complaints, close } = await openPage(browser, { width: 160, height: 90 });
  complainOfWarnings(page, complaints);
  page.setDefaultTimeout(120_000);
  try {
    await page.goto(new URL(`${path}?server=${encodeURIComponent(server.url.href)}`, files.url).href);
    await page.waitForFunction(() => globalThis.flown, null, { polling: 50 }).catch((error) => assert.fail(`${error.message}\n${complaints.join('\n')}`));
    const flown = await page.evaluate(() => globalThis.flown);
    assert.deepEqual(complaints, []);
    assert.ok(flown.worst <= 1, `${flown.worst} px`);
    assert.ok(flown.ground > 0.3, `ground on ${flown.ground} of the picture`);
    return flown;
  } finally {
    await close();
  }
}

test('esbuild, with the worker and the module copied beside the bundle', kTest, () => flies('esbuild'));
test('Vite finds the worker and the module', kTest, () => flies('vite'));
test('webpack finds the worker and the module', kTest, () => flies('webpack'));
test('an import map is enough, and the oldest three draws the same', kTest, async () => assert.equal((await flies('map')).revision, '167'));
test('the one file asks for nothing else', kTest, () => flies('inline'));
