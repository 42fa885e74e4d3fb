// Flies one tour in headless Chromium, by us and by each rival at some of its own qualities, over the same link and on the same poses
// by time, and lets one judge say what was drawn. Prints JSON.
//
//   node lab/rivals/measure.mjs PLAN.json
//
// PLAN.json is what `foreland bench rivals` writes (lab/README.md says what is measured, and how).
import { existsSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { countTraffic, openBrowser } from './browser.mjs';
import { earthOf } from './earth.mjs';
import { readGround } from './ground.mjs';
import { cameraOf, pointsSeen } from './judge.mjs';
import { between, processorTimes } from './processor_times.mjs';
import { startLink, startNginx, startServer } from './programs.mjs';
import { coarserTolerance, kRivals, overForeland } from './rivals.mjs';
import { rgbSource } from './terrain_rgb.mjs';
import { serveFiles, serveTiles } from './serve_tiles.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const client = resolve(process.env.FORELAND_CLIENT ?? join(here, '../../client/js/dist'));
const size = { width: 240, height: 135 };
const kPointsEvery = 5; // poses
const kTries = 3; // to come up to a rival's error: ours grows more slowly than the tolerance

// Of each pose the points by which it is judged: what is seen from the last pose and the next one of those that were looked from.
function pointsOf(plan, ground, earth) {
  const seen = [];
  for (let i = 0; i < plan.poses.length + kPointsEvery; i += kPointsEvery) seen.push(pointsSeen(cameraOf(plan.poses[Math.min(i, plan.poses.length - 1)], plan.lens), ground, earth));
  return plan.poses.map((_, i) => { const at = Math.floor(i / kPointsEvery); return [...seen[at], ...seen[at + 1]]; });
}

async function flyOne(browser, context, { name, page: page_name, quality, port, options }) {
  const { page, pages_url, plan, points } = context;
  const traffic = await countTraffic(page, port);
  const processors = {};
  await page.exposeFunction('mark', async (name) => {
    processors[name] = await processorTimes();
    traffic.mark(name);
  });
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  await page.goto(pages_url);
  await page.waitForFunction(() => globalThis.is_ready);
  const figures = await page.evaluate(([name, plan, options, points]) => fly(name, plan, options, points), [page_name, plan, { size, quality, ...options }, points])
    .catch((error) => { throw new Error(`${name}: ${error.message}; ${complaints.join('; ')}`); });
  const { begun, complete, flown, jumped } = traffic.marks;
  return {
    rival: name, quality,
    bytes: flown.bytes - begun.bytes, bytes_first_view: complete.bytes - begun.bytes, bytes_after_jump: jumped.bytes - flown.bytes,
    requests: flown.requests + flown.messages_up - begun.requests - begun.messages_up, from_cache: flown.from_cache, failed: flown.failed,
    processor_s: between(processors.complete, processors.flown),
    ...figures, complaints,
  };
}

const plan = JSON.parse(await readFile(process.argv[2] ?? '', 'utf8'));
plan.jump_to = Math.floor(plan.poses.length / 4);
const earth = earthOf(plan.ground), ground = await readGround(plan.ground);
plan.terrain_rgb = rgbSource(ground);
const points = pointsOf(plan, ground, earth);
if (!existsSync(join(client, 'index.js'))) throw new Error(`the client package is not built: ${client} is missing; run ./check --stage wasm --stage page`);
const stops = [];
const keep = (one) => (stops.push(() => one.stop()), one);
try {
  const browser = await openBrowser();
  stops.push(() => browser.close());
  const files = keep(await serveFiles({ rivals: here, packages: join(here, 'node_modules'), client }));
  const pages_url = `http://127.0.0.1:${files.port}/rivals/pages/index.html`;
  const fly = async (flight) => {
    const context = await browser.newContext({ viewport: { width: size.width, height: size.height }, ignoreHTTPSErrors: true });
    try {
      const flown = await flyOne(browser, { page: await context.newPage(), pages_url, plan, points }, flight);
      const { complaints, ...figures } = flown;
      process.stderr.write(`${JSON.stringify(figures)}\n`);
      return flown;
    } finally {
      await context.close();
    }
  };
  const server = keep(await startServer(plan.programs, plan.scene)), our_link = keep(await startLink(plan.programs, server.port, plan.link));
  const flyOurs = (quality) => fly({ name: 'foreland', page: 'foreland', quality, port: our_link.port, options: { server: `ws://127.0.0.1:${our_link.port}/`, predictor: plan.predictor } });
  const ours = [await flyOurs(plan.tau_px)];
  const tiles = new Map();
  for (const cut of new Set(plan.rivals.map((name) => kRivals[name].cut))) for (const [path, tile] of await cut(ground, earth)) tiles.set(path, tile);
  const is_http2 = plan.protocol === 'http2', tile_server = keep(await serveTiles(tiles));
  const front = is_http2 ? keep(await startNginx(dirname(resolve(process.argv[2])), tile_server.port)) : tile_server;
  const link = keep(await startLink(plan.programs, front.port, plan.link)), tiles_url = `${is_http2 ? 'https' : 'http'}://127.0.0.1:${link.port}/`;
  const rivals = [];
  for (const name of plan.rivals) {
    const { page, qualities } = kRivals[name], flights = [];
    for (const quality of plan.qualities.length > 0 ? plan.qualities : qualities)
      flights.push(await fly({ name, page, quality, port: link.port, options: { tiles: tiles_url } }));
    for (let tolerance_px, tries = 0; tries < kTries && (tolerance_px = coarserTolerance(flights, ours)) !== null; ++tries) ours.push(await flyOurs(tolerance_px));
    rivals.push({ rival: name, ...overForeland(flights, ours), flights });
  }
  console.log(JSON.stringify({ predictor: plan.predictor, protocol: plan.protocol, poses_per_s: plan.poses_per_s, canvas: `${size.width}x${size.height}`, foreland: ours, rivals }, null, 2));
} finally {
  for (const stop of stops.reverse()) await stop();
}
