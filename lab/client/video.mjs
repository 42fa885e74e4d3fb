// A recorded flight, judged: the page records a part of a tour in headless Chromium, frame by frame, as a video and twice as pictures.
//
//   node lab/client/video.mjs SCENE [--tour NAME] [--frames N] [--rate N] [--size WxH] [--tau PX] [--format mp4|webm] [--pictures N] [--keep FOLDER]
//
// The recorder keeps a frame once it promises the tolerance; each is judged against the scene at full resolution (`foreland replay --truth`). The
// video is decoded by the browser's VideoDecoder, and the two archives of pictures are compared byte by byte, of N frames, or of all. Prints JSON; exits 1 where a frame is missing, another one than the time before, or off by more than the tolerance. Programs are those
// of FORELAND_BIN (default build/release/bin), the page client/web/dist. --frames divided by --rate is to be a whole number of seconds.
import { createHash } from 'node:crypto';
import { existsSync } from 'node:fs';
import { readFile, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..'), web = resolve(root, 'client/web');
if (!existsSync(join(web, 'dist'))) throw new Error('The page is not built: run ./check --stage wasm --stage page.');
const { dropFile, makeFolder, openBrowser, openSources, openPage, runForeland, startServer, status, until, untilTerrain } = await import(join(web, 'tests/support.mjs'));
const of_page = createRequire(join(web, 'package.json')), { ALL_FORMATS, BufferSource, EncodedPacketSink, Input } = of_page('mediabunny'), { unzipSync } = of_page('fflate');
const { Terrain } = await import(join(root, 'client/js/dist/node.js'));

const usage = 'usage: node lab/client/video.mjs SCENE [--tour NAME] [--frames N] [--rate N] [--size WxH] [--tau PX] [--format mp4|webm] [--pictures N] [--keep FOLDER]';
const { values, positionals: [scene] } = parseArgs({
  allowPositionals: true,
  options: {
    tour: { type: 'string', default: 'canyon' }, frames: { type: 'string', default: '600' }, rate: { type: 'string', default: '60' }, size: { type: 'string', default: '640x360' },
    tau: { type: 'string', default: '1' }, format: { type: 'string', default: 'webm' }, keep: { type: 'string' }, pictures: { type: 'string' },
  },
});
const [frames, rate, tau, pictures] = [values.frames, values.rate, values.tau, values.pictures ?? values.frames].map(Number), seconds = frames / rate;
if (!scene || ![seconds, pictures / rate].every((whole) => Number.isInteger(whole) && whole >= 1)) throw new Error(`${usage}; N frames are to be whole seconds.`);

// A part of the server's tour as a path of the page (client/web/src/follow/waypoints.ts).
const kWaypoint_ms = 500, kTour_s = 180, kSettle_s = 10, kPatience_ms = 600_000;
async function pathOf(server, sources) {
  const [{ lookOf, kMapNorth }, journeys, ways] = await Promise.all(['ui/camera', 'follow/journey', 'follow/waypoints'].map((name) => sources.load(`${name}.ts`)));
  const terrain = await Terrain.open(server.url.href.replace('http', 'ws'), { lens: { fovY: 1, width: 320, height: 200 } });
  try {
    terrain.requestTour(values.tour, kTour_s);
    while (!terrain.hasTour) await new Promise((done) => setTimeout(done, 50));
    terrain.startTour(0);
    const waypoints = [];
    for (let ms = 1000 * kSettle_s; ms <= 1000 * (kSettle_s + seconds + 1); ms += kWaypoint_ms) {
      const { eye, orientation } = terrain.tourPose(ms), place = terrain.toGeodetic(eye);
      const { heading, pitch } = lookOf(orientation, kMapNorth.clone().fromArray(place.up), kMapNorth);
      waypoints.push({ eye, height_m: place.height, heading, pitch });
    }
    return ways.tourJson(journeys.tourOf(terrain, values.tour, waypoints, seconds).tour);
  } finally {
    terrain.close();
  }
}

// What is kept of the flight in one format, and the recording of the session.
async function recorded(browser, server, path, format, count, folder) {
  const { page, complaints, close } = await openPage(browser, { width: 960, height: 640 });
  try {
    page.setDefaultTimeout(kPatience_ms);
    await page.goto(new URL(`?sharpness=0.25&tau=${tau}&record=1`, server.url).href);
    await untilTerrain(page);
    await dropFile(page, 'path.json', path);
    await until(page, (s) => s.follow_view === 'own' && s.follow_playing, null, kPatience_ms);
    // At once: on a slow machine the flight ends before a key is pressed, which would begin it anew.
    await page.evaluate(() => { if (window.foreland.status().follow_playing) document.querySelector('[name=follow_play]').click(); });
    await page.locator('[name=follow_time]').evaluate((slider) => {
      slider.value = 0;
      for (const name of ['input', 'change']) slider.dispatchEvent(new Event(name));
    });
    await until(page, (s) => !s.follow_playing && s.follow_s === 0, null, kPatience_ms);
    await page.locator('[name=record_card]').click();
    for (const [name, value] of [['video_format', format], ['video_size', values.size], ['video_rate', values.rate]]) await page.locator(`[name=${name}]`).selectOption(value);
    await page.locator('[name=video_seconds]').fill(String(Number((Math.log(count / rate) / Math.log(300)).toFixed(3))));
    const kept = await saved(page, '[name=save_video]', join(folder, `flight.${format}`));
    await until(page, (s) => !s.recording);
    const promised = /none more than ([\d.]+) px off/.exec(await page.locator('#hint').textContent());
    const session = await saved(page, 'button:has-text("Save the recording")', join(folder, 'flight.rec'));
    if (complaints.length > 0) throw new Error(`The page complains: ${complaints.join('; ')}`);
    const { recorded_frames } = await status(page);
    return { kept, session, frames: recorded_frames, promised_px: promised ? Number(promised[1]) : null, decoded: format === 'png' ? null : await decoded(page, kept) };
  } finally {
    await close();
  }
}
async function saved(page, button, path) {
  const [file] = await Promise.all([page.waitForEvent('download', { timeout: 0 }), page.locator(button).evaluate((control) => control.click())]);
  await file.saveAs(path);
  return readFile(path);
}

// Sizes and times of all frames that the browser decodes.
async function decoded(page, bytes) {
  const track = await new Input({ source: new BufferSource(bytes), formats: ALL_FORMATS }).getPrimaryVideoTrack(), packets = [];
  for await (const { type, timestamp, data } of new EncodedPacketSink(track).packets()) packets.push({ type, timestamp: Math.round(1e6 * timestamp), data: Buffer.from(data).toString('base64') });
  const { codec, codedWidth, codedHeight, description } = await track.getDecoderConfig();
  return page.evaluate(async ([packets, config, description]) => {
    const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)), frames = [], errors = [];
    const decoder = new VideoDecoder({ output: (frame) => {
      frames.push([frame.displayWidth, frame.displayHeight, frame.timestamp]);
      frame.close();
    }, error: (error) => errors.push(String(error)) });
    decoder.configure(description === null ? config : { ...config, description: bytesOf(description) });
    for (const { type, timestamp, data } of packets) decoder.decode(new EncodedVideoChunk({ type, timestamp, data: bytesOf(data) }));
    await decoder.flush();
    return { codec: config.codec, frames, errors };
  }, [packets, { codec, codedWidth, codedHeight }, description ? Buffer.from(description).toString('base64') : null]);
}

// A session with fewer frames (client/fly/recording.cpp): of those that looked from one place, one after another, the first, the last, which the
// recorder kept, and between them some, since what nobody looks at is dropped. It says no more what it showed.
const kBegin = Buffer.from('foreland flight 1\n'), kHead = 13, kLookEvery_us = 200_000n;
function thinned(session) {
  const records = [];
  for (let at = kBegin.length, size; at + kHead <= session.length; at += kHead + size) {
    size = session.readUInt32LE(at + 9);
    records.push({ kind: String.fromCharCode(session[at]), us: session.readBigInt64LE(at + 1), bytes: session.subarray(at, at + kHead + size) });
  }
  const looks = records.filter(({ kind }) => kind === 's'), poseOf = (look) => look?.bytes.subarray(kHead).toString('latin1');
  const left_out = new Set();
  let last_us = 0n;
  looks.forEach((look, i) => {
    const rests = [looks[i - 1], looks[i + 1]].every((other) => poseOf(other) === poseOf(look));
    if (rests && look.us - last_us < kLookEvery_us) left_out.add(look);
    else last_us = look.us;
  });
  return Buffer.concat([kBegin, ...records.filter((record) => record.kind !== 'e' && !left_out.has(record)).map(({ bytes }) => bytes)]);
}

const { folder, remove } = await makeFolder();
const server = await startServer(resolve(scene)), browser = await openBrowser(), sources = await openSources();
let is_right = false;
try {
  const path = await pathOf(server, sources), began = performance.now();
  const video = await recorded(browser, server, path, values.format, frames, folder), took_s = (performance.now() - began) / 1000;
  console.error(`The video has ${video.decoded.frames.length} frames, after ${Math.round(took_s)} s.`);
  if (values.keep) await Promise.all([['flight.rec', video.session], [`flight.${values.format}`, video.kept]].map(([name, bytes]) => writeFile(join(values.keep, name), bytes)));
  const kept = join(folder, 'kept.rec');
  await writeFile(kept, thinned(video.session));
  const flown = JSON.parse(await runForeland('replay', kept, '--truth', resolve(scene), '--truth-every', '1', '--truth-terms-every', '0', '--json'));
  const judged = { frames: flown.measured_frames - flown.measured_frames_outside, over_tolerance: flown.frames_over_tau - flown.outside_frames_over_tau, frames_px: flown.max_error_px_frames, keyframes_px: flown.max_error_px_keyframes };
  console.error(`Of ${judged.frames} frames that promised something ${judged.over_tolerance} did not keep it.`);
  const archives = [], hashOf = (bytes) => createHash('sha256').update(bytes).digest('hex');
  for (let i = 0; i < 2; ++i) archives.push((await recorded(browser, server, path, 'png', pictures, folder)).kept);
  const [one, other] = archives.map((bytes) => unzipSync(bytes)), [width, height] = values.size.split('x').map(Number);
  const differing = [...new Set([one, other].flatMap((files) => Object.keys(files)))].filter((name) => !one[name] || !other[name] || hashOf(one[name]) !== hashOf(other[name]));
  const { frames: shown, errors, codec } = video.decoded, misplaced = shown.filter(([w, h, at], i) => w !== width || h !== height || Math.round((at * rate) / 1e6) !== i);
  if (values.keep) await writeFile(join(values.keep, 'flight.zip'), archives[0]);
  is_right = shown.length === frames && errors.length === 0 && misplaced.length === 0 && video.promised_px <= tau && judged.over_tolerance === 0 && judged.keyframes_px <= tau
    && judged.frames >= frames && Object.keys(one).length === pictures && differing.length === 0;
  console.log(JSON.stringify({
    scene, tour: values.tour, size: values.size, rate, tau_px: tau, is_right,
    video: { codec, bytes: video.kept.length, frames: shown.length, misplaced: misplaced.length, errors, promised_px: video.promised_px, seconds: Math.round(took_s) },
    judged,
    pictures: { frames: Object.keys(one).length, differing: differing.length, sha256: hashOf(archives[0]) },
  }, null, 2));
} finally {
  await browser.close();
  await server.stop();
  await sources.close();
  await remove();
}
process.exitCode = is_right ? 0 : 1;
