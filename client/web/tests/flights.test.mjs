// Flights in the page, in headless Chromium against the real server.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { dropFile, makeFolder, makeSceneOnEarth, runForeland, on_earth, openBrowser, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 180_000 };
let folder, server, browser;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeSceneOnEarth(folder.folder));
  browser = await openBrowser();
}, kTest);
after(async () => {
  await browser?.close();
  await server?.stop();
  await folder?.remove();
});

// Due east over the middle of the scene, 3000 m above the sea, 0.001 degrees a second.
const kFrom = { lon: on_earth.west + 0.06, lat: on_earth.south + 0.125 }, kSeconds = 120, kRate = 0.001;
function gpx() {
  const points = Array.from({ length: kSeconds + 1 }, (_, i) =>
    `<trkpt lat="${kFrom.lat}" lon="${(kFrom.lon + i * kRate).toFixed(6)}"><ele>3000</ele><time>${new Date(Date.UTC(2024, 5, 1, 12, 0, i)).toISOString()}</time></trkpt>`);
  return `<?xml version="1.0"?><gpx version="1.1" creator="test" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>${points.join('')}</trkseg></trk></gpx>`;
}
const visit = (query, body, options = {}) =>
  visitPage(browser, new URL(`?sharpness=0.25&tau=2&${query}`, server.url), body, { width: 960, height: 640, prepare: (page) => page.setDefaultTimeout(120_000), ...options });

// A second between keyframes, since a processor that draws takes long for a frame.
test('a track that is dropped is followed: from behind, from inside, and freely, with every frame guaranteed', kTest, () =>
  visit('keyframe=1000', async (page) => {
    await dropFile(page, 'flight.gpx', gpx());
    await until(page, (s) => s.follow_playing && !s.follow_lead && s.follow_s > 2);
    await page.evaluate(() => {
      window.watched = [];
      const look = () => {
        const { follow_playing, follow_lead, tau_px, eye, follow_s, follow_at, frames } = window.foreland.status();
        window.watched.push({ is_followed: follow_playing && !follow_lead, tau_px, eye, follow_s, follow_at, frames });
        requestAnimationFrame(look);
      };
      requestAnimationFrame(look);
    });
    await page.keyboard.press('KeyF');
    await until(page, (s) => s.follow_view === 'cockpit' && s.follow_playing && !s.follow_lead && s.follow_s > 10);
    await until(page, (s, n) => s.frames > n + 20, (await status(page)).frames);
    const watched = await page.evaluate(() => window.watched);
    const followed = watched.filter(({ is_followed }) => is_followed);
    const outside = followed.filter(({ tau_px }) => !Number.isFinite(tau_px));
    assert.ok(followed.length > 20);
    assert.deepEqual(outside, [], `${outside.length} of ${followed.length} frames are not guaranteed`);
    // From the cockpit the camera is where the track says.
    const place = await page.evaluate(() => window.foreland.status());
    assert.ok(Math.hypot(...place.eye.map((v, k) => v - place.follow_at[k])) < 1, `${place.eye} at ${place.follow_at}`);
    const lon = kFrom.lon + kRate * place.follow_s, text = await page.locator('#readout').innerText();
    const shown = Number(/([\d.]+)\u00b0 E/.exec(text)[1]);
    assert.ok(Math.abs(shown - lon) < 0.004, `${shown}, not ${lon}`);
    assert.match(await page.locator('#follow').innerText(), /3,000 m/);
    // Keys: pause, back, faster, and a hand that steers.
    await page.keyboard.press('KeyK');
    const paused = await until(page, (s) => !s.follow_playing);
    await page.keyboard.press('KeyJ');
    await until(page, (s, t) => s.follow_s < t, paused.follow_s);
    await page.keyboard.press('Period');
    await until(page, (s, speed) => s.follow_speed > speed, paused.follow_speed);
    await page.keyboard.press('KeyW');
    await until(page, (s) => s.follow_view === 'free');
    await page.locator('[name=follow_close]').click();
    assert.equal((await status(page)).following, null);
    assert.equal(await page.locator('#follow').isVisible(), false);
  }));

test('a track is followed by the address, and one without times at a constant speed', kTest, () => {
  const untimed = gpx().replaceAll(/<time>[^<]*<\/time>|<ele>[^<]*<\/ele>/g, '');
  return visit('', async (page) => {
    await page.route('**/way.gpx', (route) => route.fulfill({ body: untimed, contentType: 'application/gpx+xml' }));
    await page.goto(new URL('?sharpness=0.25&tau=2&track=way.gpx', server.url).href);
    const s = await until(page, ({ following }) => following === 'way.gpx');
    assert.ok(s.follow_duration_s > 900 && s.follow_duration_s < 950, `${s.follow_duration_s} s`);
    const hint = await page.locator('#hint').innerText();
    assert.match(hint, /has no times: it is flown at 10 m\/s/);
    assert.match(hint, /has no heights: it is flown 50 m above the ground/);
    await page.goto(new URL('?sharpness=0.25&tau=2&track=none.gpx', server.url).href);
    await page.locator('#notice.error').waitFor();
    assert.match(await page.locator('#notice').innerText(), /none\.gpx does not come/);
  }, { expected: /404/ });
});

test('a path through waypoints is flown, kept, read again, and flown by foreland fly', kTest, () =>
  visit('keyframe=1000', async (page) => {
    await page.keyboard.press('KeyP');
    await page.keyboard.down('KeyW');
    const first = await status(page);
    await until(page, (s, eye) => Math.hypot(...s.eye.map((v, k) => v - eye[k])) > 100, first.eye);
    await page.keyboard.up('KeyW');
    await page.keyboard.press('KeyP');
    assert.equal((await status(page)).waypoints, 2);
    const keep = async (kind) => {
      const [file] = await Promise.all([page.waitForEvent('download'), page.locator(`[name=path_${kind}]`).click()]);
      const path = join(folder.folder, file.suggestedFilename());
      await file.saveAs(path);
      return path;
    };
    const files = [await keep('json'), await keep('kml')];
    for (const file of files) assert.match(await runForeland('fly', `ws://${server.url.host}`, '--track', file, '--seconds', '2'), /keyframes/);
    await page.locator('[name=path_clear]').click();
    await dropFile(page, 'path.json', await readFile(files[0], 'utf8'));
    await until(page, (s) => s.waypoints === 2 && s.follow_view === 'own' && s.follow_playing && !s.follow_lead);
    await until(page, (s, eye) => s.follow_s === s.follow_duration_s && Math.hypot(...s.eye.map((v, k) => v - eye[k])) > 90, first.eye);
  }));
