// Lines that are draped over the ground, judged: the page flies a tour in headless Chromium over a raster with lines on it, frame by frame as it
// comes, and lab/client/draped_truth.py says how far the lines are drawn from where the raster has them.
//
//   node lab/client/draped.mjs [--raster FILE] [--tour NAME] [--frames N] [--size WxH] [--tau PX] [--samples N] [--seed N] [--keep FOLDER]
//
// The page shows what is known a little late (strategy `delay`), so that a slow machine draws frames between keyframes as a fast one does; where the
// tour ends before there are enough of them, it is flown again. The page tells of each frame its camera and the error that it states; what of the picture has the lines' colour is read of the canvas. The judge takes
// the camera and the raster, as GDAL reads it, and shares no code with what draws. The raster is to be on a map in metres. Prints JSON; exits 1 where a
// sample is off by more than the frame states and a pixel, or where no sample is judged. Programs are those of FORELAND_BIN (default
// build/release/bin), the page client/web/dist; python3 is to have NumPy and GDAL (PYTHON).
import { execFile } from 'node:child_process';
import { existsSync } from 'node:fs';
import { copyFile, writeFile } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs, promisify } from 'node:util';

const here = dirname(fileURLToPath(import.meta.url)), root = resolve(here, '../..'), web = resolve(root, 'client/web');
if (!existsSync(join(web, 'dist'))) throw new Error('The page is not built: run ./check --stage wasm --stage page.');
const { dropFile, makeFolder, openBrowser, openPage, runForeland, startServer, until } = await import(join(web, 'tests/support.mjs'));
const { Terrain } = await import(join(root, 'client/js/dist/node.js'));
const run = promisify(execFile), python = process.env.PYTHON ?? '/usr/bin/python3';

const data = process.env.FORELAND_DATA ?? resolve(root, '../shared/data');
const { values } = parseArgs({
  options: {
    raster: { type: 'string', default: join(data, 'dem/msh/msh_base_utm10_10m.tif') }, tour: { type: 'string', default: 'canyon' }, frames: { type: 'string', default: '600' },
    size: { type: 'string', default: '640x360' }, tau: { type: 'string', default: '1' }, samples: { type: 'string', default: '10000' }, seed: { type: 'string', default: '1' }, keep: { type: 'string' },
  },
});
const kPatience_ms = 3_600_000, kLine_px = 2, kStep_m = 0.01; // heights in finer steps than the raster's would be off by less than it
const [width, height] = values.size.split('x').map(Number), frames = Number(values.frames);

// Runs in the page, before its own scripts: keeps the camera and the lines' pixels of each frame of a tour from another pose than the one before.
function record([frames, kFaintest]) {
  const kept = (window.kept = []), request = window.requestAnimationFrame.bind(window);
  let drawn = '';
  window.unstated = 0;
  window.requestAnimationFrame = (callback) => request((at) => {
    callback(at);
    const status = kept.length < frames && window.is_laid ? window.foreland.status() : null;
    if (!status?.touring || String(status.shown_pose.eye) === drawn) return;
    drawn = String(status.shown_pose.eye);
    if (!Number.isFinite(status.tau_px)) return void ++window.unstated;
    const { canvas } = window, gl = canvas.getContext('webgl2'), { width, height } = canvas, rgba = new Uint8Array(4 * width * height), pixels = [], shares = [];
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    for (let i = 0; i < width * height; ++i) {
      const share = Math.min(rgba[4 * i], rgba[4 * i + 2]) - rgba[4 * i + 1]; // of magenta over grey: what covers the pixel, whatever the grey
      if (share >= kFaintest) {
        pixels.push(i);
        shares.push(share);
      }
    }
    const { shown_pose: { eye, orientation }, tau_px, mesh_version } = status;
    kept.push({ width, height, eye, orientation, tau_px, mesh_version, pixels, shares });
  });
}

const { folder, remove } = await makeFolder(), scene = join(folder, 'scene.fls');
const judge = async (...args) => JSON.parse((await run(python, [join(here, 'draped_truth.py'), ...args], { maxBuffer: 1 << 24 })).stdout);
await runForeland('build', values.raster, '-o', scene, '--vertical-step', `${kStep_m}`);
const server = await startServer(scene), browser = await openBrowser();
let is_right = false;

// Frames of a tour, no more than are wanted, and how many stated nothing.
async function flown(wanted, overlay) {
  const { page, complaints, close } = await openPage(browser, { width, height });
  await page.addInitScript(record, [wanted, 8]);
  await page.goto(new URL(`?sharpness=1&tau=${values.tau}&tour=${values.tour}&strategy=delay&ground=plain&relief=0&imagery=0&fog=0&labels=0`, server.url).href);
  await until(page, (s) => s.triangles > 500 && s.touring, null, kPatience_ms);
  await dropFile(page, 'lines.geojson', overlay);
  await until(page, (s) => s.overlays_laid > 0 && Number.isFinite(s.tau_px), null, kPatience_ms);
  await page.evaluate(() => {
    window.canvas = document.querySelector('#scene');
    window.is_laid = true;
  });
  const kept = [];
  while (kept.length < wanted) {
    await page.waitForTimeout(2000);
    const is_over = !(await page.evaluate(() => window.foreland.status().touring));
    kept.push(...await page.evaluate((from) => window.kept.slice(from), kept.length));
    if (complaints.length > 0) throw new Error(`The page complains: ${complaints.join('; ')}`);
    if (is_over) break;
  }
  const unstated = await page.evaluate(() => window.unstated);
  await close();
  if (kept.length === 0) throw new Error('No frame of a whole tour states its error.');
  return { kept, unstated };
}
try {
  // Where the scene's axes begin on the map: it is the map, moved.
  const terrain = await Terrain.open(server.url.href.replace('http', 'ws'), { lens: { fovY: 1, width: 320, height: 200 } });
  const { easting, northing, height: above } = terrain.place([0, 0, 0]), { crs } = terrain.scene;
  terrain.close();
  if (easting === undefined) throw new Error(`${values.raster} is not on a map in metres.`);
  const lines = await judge('lines', values.raster, values.samples, values.seed), file = join(folder, 'frames.json');
  const features = lines.map((line) => ({ type: 'Feature', properties: { stroke: '#ff00ff', 'stroke-width': kLine_px, 'stroke-opacity': 1 }, geometry: { type: 'LineString', coordinates: [line[0], line[line.length - 1]] } }));
  const overlay = JSON.stringify({ type: 'FeatureCollection', crs: { type: 'name', properties: { name: crs } }, features }), kept = [];
  let unstated = 0, flights = 0;
  for (; kept.length < frames; ++flights) {
    const flight = await flown(frames - kept.length, overlay);
    kept.push(...flight.kept.map((frame) => ({ ...frame, mesh_version: `${flights}:${frame.mesh_version}` })));
    unstated += flight.unstated;
    console.error(`${kept.length} of ${frames} frames.`);
  }
  await writeFile(file, JSON.stringify({ origin: [easting, northing, above], fov_rad: (55 * Math.PI) / 180, line_px: kLine_px, lines, frames: kept }));
  if (values.keep) await copyFile(file, join(values.keep, 'frames.json'));
  const judged = await judge('judge', values.raster, file, values.samples, values.seed);
  is_right = kept.length === frames && judged.over === 0 && judged.places > 0;
  console.log(JSON.stringify({ raster: values.raster, tour: values.tour, size: values.size, tau_px: Number(values.tau), is_right, flights, frames_that_state_nothing: unstated, ...judged }, null, 2));
} finally {
  await browser.close();
  await server.stop();
  await remove();
}
process.exitCode = is_right ? 0 : 1;
