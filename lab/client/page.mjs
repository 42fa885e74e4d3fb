// What the page's drawing thread does in a flight, in headless Chromium: the time of each animation callback, tasks that block it for
// more than 50 ms, and how long the first picture takes. The figures are of the page itself: after the first picture the graphics
// card, which a processor plays here, draws one triangle of each mesh. The picture is small and the tolerance, too, so
// the sections are those of 1920 x 1080 at 1 pixel.
//
//   node lab/client/page.mjs SCENE [--tour NAME] [--seconds N] [--page FOLDER] [--strategy NAME] [--query MORE] [--overlay VERTICES] [--lines N]
//
// MORE goes to the page's address: imagery=0, shadows=1. With --overlay a file of that many vertices, in N lines, is dropped once the flight has
// begun. Prints JSON. Programs are those of FORELAND_BIN (default build/release/bin), the page client/web/dist. Nothing else should run.
import { existsSync } from 'node:fs';
import { dirname, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
if (!existsSync(resolve(root, 'client/web/node_modules'))) throw new Error('The page is not built: run ./check --stage wasm --stage page.');
const { openBrowser, openPage, startServer, until } = await import(resolve(root, 'client/web/tests/support.mjs'));
const { Terrain } = await import(resolve(root, 'client/js/dist/node.js'));

const { values, positionals: [scene] } = parseArgs({
  allowPositionals: true,
  options: {
    tour: { type: 'string', default: 'canyon' },
    seconds: { type: 'string', default: '60' },
    strategy: { type: 'string', default: 'predict' },
    page: { type: 'string' },
    query: { type: 'string', default: '' },
    overlay: { type: 'string' },
    lines: { type: 'string', default: '100' },
  },
});
if (!scene) throw new Error('usage: node lab/client/page.mjs SCENE [--tour NAME] [--seconds N] [--page FOLDER] [--strategy NAME] [--query MORE] [--overlay VERTICES] [--lines N]');

// Runs in the page, before its own scripts.
function record() {
  const log = (window.recorded = { callbacks_ms: [], long_tasks: [], first_picture_ms: null, triangles: 0, begun: 0 });
  const request = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (callback) => request((at) => {
    const begin = performance.now();
    callback(at);
    const end = performance.now();
    if (log.first_picture_ms !== null) return void log.callbacks_ms.push(end - begin);
    const status = window.foreland?.status();
    if (!status || status.triangles === 0 || status.frames === 0) return;
    log.first_picture_ms = end;
    const draw = WebGL2RenderingContext.prototype.drawElements;
    WebGL2RenderingContext.prototype.drawElements = function (mode, count, type, offset) {
      draw.call(this, mode, Math.min(count, 3), type, offset);
    };
    log.triangles = status.triangles;
  });
  new PerformanceObserver((list) => {
    for (const { startTime, duration } of list.getEntries()) log.long_tasks.push({ at_ms: startTime, ms: duration });
  }).observe({ type: 'longtask', buffered: true });
}

// Lines from the west to the east of a scene, as GeoJSON.
async function linesOver(server, vertices, count) {
  const terrain = await Terrain.open(server.url.href.replace('http', 'ws'), { lens: { fovY: 1, width: 320, height: 200 } }), { scene } = terrain;
  const corners = scene.frame === 'globe' ? [[-179, -80], [179, 80]] : [scene.bounds.low, scene.bounds.high].map((corner) => {
    const { easting, northing, lon, lat } = terrain.toGeodetic(corner);
    return scene.frame === 'planar' ? [easting, northing] : [lon, lat];
  });
  terrain.close();
  const [[west, south], [east, north]] = corners, each = Math.round(vertices / count), step = (north - south) / (count + 1);
  const features = Array.from({ length: count }, (_, k) => ({
    type: 'Feature', properties: { stroke: '#ff00ff' },
    geometry: { type: 'LineString', coordinates: Array.from({ length: each }, (_, i) => [west + ((i + 0.5) / each) * (east - west), south + (k + 1 + 0.4 * Math.sin(i)) * step]) },
  }));
  return JSON.stringify({ type: 'FeatureCollection', ...(scene.frame === 'planar' ? { crs: { type: 'name', properties: { name: scene.crs } } } : {}), features });
}

// As people drop a file, which the page reads when it will: piece by piece, so that no task of this program is a long one of the page's.
async function dropText(page, name, text) {
  await page.evaluate(() => (window.pieces = []));
  for (let begin = 0; begin < text.length; begin += 1 << 16) await page.evaluate((piece) => void window.pieces.push(piece), text.slice(begin, begin + (1 << 16)));
  const files = await page.evaluateHandle((name) => {
    const files = new DataTransfer();
    files.items.add(new File(window.pieces, name));
    return files;
  }, name);
  await page.dispatchEvent('body', 'drop', { dataTransfer: files });
}

const quantile = (sorted, q) => (sorted.length === 0 ? null : sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))]);
const rounded = (value) => (value === null ? null : Math.round(100 * value) / 100);

const server = await startServer(resolve(scene), 0, [], values.page && resolve(values.page));
const browser = await openBrowser();
try {
  const { page, complaints } = await openPage(browser, { width: 480, height: 270 });
  await page.addInitScript(record);
  await page.goto(new URL(`?sharpness=1&tau=0.25&tour=${values.tour}&strategy=${values.strategy}&${values.query}`, server.url).href);
  await until(page, (s) => s.triangles > 0 && s.touring).catch((error) => { throw new Error(`${error.message}; ${complaints}`); });
  const begun = await page.evaluate(() => ({ status: window.foreland.status(), at_ms: performance.now() }));
  const lines = values.overlay && await linesOver(server, Number(values.overlay), Number(values.lines));
  await browser.startTracing(page, { categories: ['-*', 'devtools.timeline', 'disabled-by-default-devtools.timeline'] });
  let laid_after_ms = null;
  if (lines) {
    const dropped = performance.now();
    await dropText(page, 'lines.geojson', lines);
    await until(page, (s) => s.overlays_laid > 0, null, 600_000);
    laid_after_ms = performance.now() - dropped;
  }
  await page.waitForTimeout(1000 * Number(values.seconds));
  const trace = JSON.parse(await browser.stopTracing()).traceEvents.filter((event) => event.ph === 'X' && event.tdur !== undefined);
  const { log, status } = await page.evaluate(() => ({ log: window.recorded, status: window.foreland.status() }));
  const drawn = trace.filter(({ name }) => name === 'FireAnimationFrame');
  const cpu = drawn.map(({ tdur }) => tdur / 1000).sort((a, b) => a - b);
  const of_thread = trace.filter(({ name, pid, tid }) => name === 'RunTask' && pid === drawn[0]?.pid && tid === drawn[0]?.tid);
  const callbacks = log.callbacks_ms.sort((a, b) => a - b);
  const long = log.long_tasks.filter(({ at_ms }) => at_ms > log.first_picture_ms);
  console.log(JSON.stringify({
    scene, tour: values.tour, strategy: values.strategy, seconds: Number(values.seconds),
    first_picture_ms: rounded(log.first_picture_ms),
    first_triangles: log.triangles,
    triangles: status.triangles,
    object_triangles: status.object_triangles,
    keyframes: status.keyframes - begun.status.keyframes,
    late_keyframes: status.late_keyframes - begun.status.late_keyframes,
    frames: callbacks.length,
    callback_cpu_ms_p50: rounded(quantile(cpu, 0.5)),
    callback_cpu_ms_p99: rounded(quantile(cpu, 0.99)),
    callback_cpu_ms_max: rounded(quantile(cpu, 1)),
    callback_ms_p50: rounded(quantile(callbacks, 0.5)),
    callback_ms_p99: rounded(quantile(callbacks, 0.99)),
    callback_ms_max: rounded(quantile(callbacks, 1)),
    largest_upload: rounded(status.largest_upload), // share of 2 MiB for each 16 ms of the frame before
    overlay_vertices: lines ? Number(values.overlay) : 0,
    overlay_laid_after_ms: rounded(laid_after_ms),
    relief_shown: status.relief_shown,
    imagery_shown: status.imagery_shown,
    long_tasks: long.length,
    longest_task_ms: rounded(Math.max(0, ...long.map(({ ms }) => ms))),
    longest_task_cpu_ms: rounded(Math.max(0, ...of_thread.map(({ tdur }) => tdur / 1000))),
    complaints,
  }, null, 2));
} finally {
  await browser.close();
  await server.stop();
}
