// How long a frame keeps the drawing thread, and what it brings to the graphics card: a flight over a scene in headless Chromium, timed about
// `ForelandTerrain.update` and about all that the worker's messages set off. By hand, on a machine that does nothing else:
//
//   [FORELAND_SCENE=alps.fls] node client/js/tests/measure_frames.mjs [SECONDS]
//
// Without a graphics card a processor draws, in a process of its own, so few frames are drawn; their times here are all the same those of
// the client's code.
import { makeFolder, makeScene, openBrowser, openPage, package_folder, startServer } from './support.mjs';
import { serveFolder } from './static_server.mjs';

const seconds = Number(process.argv[2] ?? 20);
const folder = await makeFolder();
const server = await startServer(await makeScene(folder.folder, { size: 2049, spacing_m: 10 }));
const files = await serveFolder(package_folder), browser = await openBrowser();
const { page } = await openPage(browser, { width: 640, height: 360 });

// Adds up what the worker's messages take.
await page.addInitScript(() => {
  globalThis.in_messages_ms = 0;
  const { set, get } = Object.getOwnPropertyDescriptor(Worker.prototype, 'onmessage');
  Object.defineProperty(Worker.prototype, 'onmessage', { get, set(listener) {
    set.call(this, (event) => {
      const begun = performance.now();
      listener(event);
      in_messages_ms += performance.now() - begun;
    });
  } });
});

async function fly(seconds) {
  renderer.setAnimationLoop(null);
  const { low, high } = terrain.scene.bounds, across = high[0] - low[0];
  const frames = [];
  const begun = performance.now();
  for (let now = begun; now - begun < 1000 * (seconds + 5);) {
    now = await new Promise(requestAnimationFrame);
    const t = (now - begun) / 1000, a = 0.06 * t;
    camera.position.set(0.5 * (low[0] + high[0]) + 0.3 * across * Math.cos(a), 0.5 * (low[1] + high[1]) + 0.3 * across * Math.sin(a), high[2] + 200);
    camera.lookAt(camera.position.x - across * Math.sin(a), camera.position.y + across * Math.cos(a), low[2]);
    Object.assign(camera, ground.depthRange(camera.position.toArray()));
    camera.updateProjectionMatrix();
    const from = performance.now();
    const frame = ground.update(camera, now);
    const ms = performance.now() - from + in_messages_ms;
    in_messages_ms = 0;
    renderer.render(scene, camera);
    if (t > 5) frames.push({ ms, bytes: ground.drawn.uploadedBytes, limit: ground.drawn.uploadLimit, px: frame.guaranteedPx, triangles: ground.drawn.triangles });
  }
  return frames;
}

try {
  await page.goto(new URL(`examples/three-basic.html?server=${encodeURIComponent(server.url.href)}`, files.url).href);
  await page.waitForFunction(() => globalThis.ground?.drawn.version > 0, null, { polling: 50 });
  const frames = await page.evaluate(fly, seconds);
  const times = frames.map(({ ms }) => ms).sort((a, b) => a - b), at = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))].toFixed(2);
  const most = (of) => Math.max(...frames.map(of));
  console.log(`${frames.length} frames, up to ${most(({ triangles }) => triangles)} triangles`);
  console.log(`drawing thread: median ${at(0.5)} ms, p99 ${at(0.99)} ms, largest ${at(1)} ms`);
  console.log(`uploads: at most ${(most(({ bytes }) => bytes) / 2 ** 20).toFixed(2)} MiB a frame, ${most(({ bytes, limit }) => bytes / limit).toFixed(2)} of what was allowed`);
} finally {
  await browser.close();
  for (const one of [server, files]) await one.stop();
  await folder.remove();
}
