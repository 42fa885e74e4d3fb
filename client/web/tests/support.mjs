// What tests of the page need beside what tests of the client do: the page, dist/, and what it says of itself.
import assert from 'node:assert/strict';
import { join, resolve } from 'node:path';
import { createServer } from 'vite';
import { openPage as openPageOf, root, startServer as startServerOf } from '../../js/tests/support.mjs';

export * from '../../js/tests/support.mjs';
export const page_folder = resolve(import.meta.dirname, '../dist');

// As the client's tests start it, with the page.
export const startServer = (scene, port = 0, more = [], web = page_folder) => startServerOf(scene, port, more, web);

// As the client's tests open it, with what the page remembers of who has opened its laboratory and all of its readout, or of nobody.
export async function openPage(browser, { is_first_visit = false, ...options } = {}) {
  const opened = await openPageOf(browser, options);
  if (!is_first_visit)
    await opened.page.addInitScript(() => ['visited', 'laboratory', 'readout'].forEach((name) => localStorage.setItem(`foreland.${name}`, '1')));
  return opened;
}

// Loads modules of the page's sources without a browser. `fresh()` makes them be evaluated anew.
export async function openSources() {
  const vite = await createServer({
    root: join(root, 'client/web'), configFile: false, appType: 'custom', logLevel: 'error', optimizeDeps: { noDiscovery: true },
    server: { middlewareMode: true, hmr: false, ws: false, watch: null },
  });
  return { load: (path) => vite.ssrLoadModule(`/src/${path}`), fresh: () => vite.moduleGraph.invalidateAll(), close: () => vite.close() };
}

export const status = (page) => page.evaluate(() => window.foreland.status());

// Waits until the page's status satisfies a condition, written as a function of the status (and of `value`).
export async function until(page, condition, value = null, timeout = 60_000) {
  const text = `(window.foreland && (${condition})(window.foreland.status(), ${JSON.stringify(value)}))`;
  // Not by waitForFunction, which evaluates text in the page: the page's Content-Security-Policy forbids that.
  for (const end = Date.now() + timeout; !(await page.evaluate(text)); await page.waitForTimeout(50))
    if (Date.now() > end) throw new Error(`waited ${timeout} ms in vain for ${condition}`);
  return status(page);
}

// Terrain of its section is drawn and keyframes go on.
export async function untilTerrain(page) {
  const first = await until(page, (s) => s.triangles > 500 && s.keyframes >= 3 && s.frames > 2);
  return until(page, (s, frames) => s.frames > frames, first.frames + 1);
}

// Runs `body` with a page at `url` once its terrain is drawn; nothing may have gone wrong in it, but what `expected` allows. `prepare` comes before it loads.
export async function visitPage(browser, url, body, { expected, prepare = () => {}, ...options } = {}) {
  const { page, complaints, close } = await openPage(browser, options);
  try {
    await prepare(page);
    await page.goto(url.href);
    await untilTerrain(page);
    await body(page);
    assert.deepEqual(complaints.filter((complaint) => !expected?.test(complaint)), []);
  } finally {
    await close();
  }
}

// Drops a file on the page.
export async function dropFile(page, name, content) {
  const files = await page.evaluateHandle(([base64, file]) => {
    const files = new DataTransfer();
    files.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], file));
    return files;
  }, [Buffer.from(content).toString('base64'), name]);
  await page.dispatchEvent('body', 'drop', { dataTransfer: files });
}

// Fingers of a touch screen, each at x and y: they come down, and go by steps.
export async function fingersOf(page) {
  const client = await page.context().newCDPSession(page);
  const send = (type, points) => client.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  return async (from, to, steps = 4) => {
    await send('touchStart', from);
    for (let k = 1; k <= steps; ++k) await send('touchMove', from.map((at, i) => at.map((v, axis) => v + (k / steps) * (to[i][axis] - v))));
    await send('touchEnd', []);
    await until(page, (s, frames) => s.frames > frames + 1, (await status(page)).frames);
    return status(page);
  };
}

// The middle of the canvas, where no panel lies over it.
export function middleOf(page) {
  const { width, height } = page.viewportSize();
  const clip = { x: 0.36 * width, y: 0.35 * height, width: 0.28 * width, height: 0.4 * height };
  return page.screenshot({ clip });
}

// The share of pixels that differ visibly between two pictures, or between parts of them, of one size.
export function changedShare(page, one, other, parts = [null, null]) {
  const urls = [one, other].map((picture) => `data:image/png;base64,${picture.toString('base64')}`);
  return page.evaluate(async ([pictures, parts]) => {
    const pixelsOf = async (url, i) => {
      const image = await createImageBitmap(new Blob([Uint8Array.from(atob(url.split(',')[1]), (c) => c.charCodeAt(0))]));
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(...(parts[i] ?? [0, 0, image.width, image.height])).data;
    };
    const [a, b] = await Promise.all(pictures.map(pixelsOf));
    let changed = 0;
    for (let i = 0; i < a.length; i += 4) {
      if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 24) ++changed;
    }
    return changed / (a.length / 4);
  }, [urls, parts]);
}

// What a screenshot's pixels say: how many colours, and how the lower half differs from the sky.
export async function pictureOf(page) {
  const picture = await page.screenshot();
  const data = `data:image/png;base64,${picture.toString('base64')}`;
  return page.evaluate(async (url) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(url.split(',')[1]), (c) => c.charCodeAt(0))]));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data: pixels, width, height } = context.getImageData(0, 0, image.width, image.height);
    const colours = new Set();
    const halves = [[0, 0, 0, 0], [0, 0, 0, 0]];
    for (let y = 0; y < height; y += 3) {
      for (let x = Math.floor(width * 0.35); x < width * 0.65; x += 3) {
        const [r, g, b] = pixels.subarray(4 * (y * width + x));
        colours.add((r >> 3) * 1024 + (g >> 3) * 32 + (b >> 3));
        const half = halves[y < height / 4 ? 0 : y > height / 2 ? 1 : -1];
        if (half) [r, g, b, 1].forEach((v, i) => (half[i] += v));
      }
    }
    const mean = ([r, g, b, n]) => [r / n, g / n, b / n];
    return { colours: colours.size, sky: mean(halves[0]), ground: mean(halves[1]) };
  }, data);
}
