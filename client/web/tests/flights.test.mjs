// Flights in the page, in headless Chromium against the real server.
import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { unzipSync } from 'fflate';
import { ALL_FORMATS, BufferSource, EncodedPacketSink, Input } from 'mediabunny';
import { dropFile, makeFolder, makeSceneOnEarth, runForeland, on_earth, openBrowser, startServer, status, until, visitPage } from './support.mjs';

const kTest = { timeout: 180_000 }, kLongTest = { timeout: 300_000 };
let folder, server, browser;

before(async () => {
  folder = await makeFolder();
  server = await startServer(await makeSceneOnEarth(folder.folder));
  browser = await openBrowser({ has_antialias: true });
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

// A second of a flight from where it stands; what is kept, as bytes.
async function recorded(page, container, size) {
  for (const [name, value] of [['video_format', container], ['video_size', size]]) await page.locator(`[name=${name}]`).selectOption(value);
  await page.locator('[name=video_rate]').selectOption('10');
  await page.locator('[name=video_seconds]').fill('0');
  const [file] = await Promise.all([page.waitForEvent('download', { timeout: 200_000 }), page.locator('[name=save_video]').click()]);
  await until(page, (s) => !s.recording);
  const path = join(folder.folder, file.suggestedFilename());
  await file.saveAs(path);
  return readFile(path);
}
async function standAt(page, time_s) {
  await until(page, (s) => s.follow_playing && !s.follow_lead);
  await page.keyboard.press('KeyK');
  await page.locator('[name=follow_time]').evaluate((slider, at) => {
    slider.value = at;
    slider.dispatchEvent(new Event('input'));
    slider.dispatchEvent(new Event('change'));
  }, time_s);
}

test('a flight is recorded frame by frame, and decodes to as many frames of the size', kLongTest, () =>
  visit('', async (page) => {
    await dropFile(page, 'flight.gpx', gpx());
    await standAt(page, 30);
    await page.locator('[name=record_card]').click();
    const bytes = await recorded(page, 'webm', '640x360');
    const input = new Input({ source: new BufferSource(bytes), formats: ALL_FORMATS }), track = await input.getPrimaryVideoTrack();
    const packets = [];
    for await (const packet of new EncodedPacketSink(track).packets()) packets.push({ type: packet.type, timestamp: Math.round(1e6 * packet.timestamp), data: [...packet.data] });
    assert.equal(packets.length, 10);
    assert.deepEqual(packets.map(({ timestamp }) => Math.round((timestamp * 10) / 1e6)), packets.map((_, i) => i));
    const { codec, codedWidth, codedHeight } = await track.getDecoderConfig();
    const decoded = await page.evaluate(async ([packets, config]) => {
      const sizes = [], decoder = new VideoDecoder({ output: (frame) => {
        sizes.push(`${frame.displayWidth}x${frame.displayHeight}`);
        frame.close();
      }, error: (error) => sizes.push(String(error)) });
      decoder.configure(config);
      for (const { type, timestamp, data } of packets) decoder.decode(new EncodedVideoChunk({ type, timestamp, data: new Uint8Array(data) }));
      await decoder.flush();
      return sizes;
    }, [packets, { codec, codedWidth, codedHeight }]);
    assert.deepEqual(decoded, Array(10).fill('640x360'));
    // A picture twice as large as the window.
    const { width, height } = await page.locator('#scene').evaluate((canvas) => ({ width: canvas.width, height: canvas.height }));
    await page.locator('[name=picture_factor]').selectOption('2');
    const [file] = await Promise.all([page.waitForEvent('download'), page.locator('[name=save_picture]').click()]);
    await file.saveAs(join(folder.folder, 'picture.png'));
    const png = await readFile(join(folder.folder, 'picture.png'));
    assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [2 * width, 2 * height]);
    await until(page, (s, frames) => !s.recording && s.frames > frames, (await status(page)).frames + 2);
  }));

test('the same frames are the same bytes, whatever was seen before', kLongTest, () =>
  visit('', async (page) => {
    await dropFile(page, 'flight.gpx', gpx());
    const archives = [];
    for (const before_s of [10, 90]) {
      await standAt(page, before_s);
      if (archives.length === 0) await page.locator('[name=record_card]').click();
      await page.keyboard.press('KeyK');
      await until(page, (s, from_s) => s.follow_s > from_s + 3, before_s);
      await standAt(page, 40);
      archives.push(unzipSync(await recorded(page, 'png', '640x360')));
      await page.keyboard.press('KeyK'); // a recording pauses the flight
    }
    const [one, other] = archives, names = Object.keys(one);
    assert.equal(names.length, 10);
    assert.equal(names[9], 'frame_0009.png');
    const differing = names.filter((name) => !Buffer.from(one[name]).equals(Buffer.from(other[name])));
    if (process.env.KEEP) for (const name of names) await Promise.all([['a', one], ['b', other]].map(([which, files]) => writeFile(join(process.env.KEEP, `${which}_${name}`), files[name])));
    assert.deepEqual(differing, []);
  }));
