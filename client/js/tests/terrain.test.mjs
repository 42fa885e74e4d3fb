// The package's interface in Node, in sessions with the real server: what is promised of a Terrain, and how it ends. Every wait is for a
// condition.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { writeFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { connect } from 'node:net';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setImmediate } from 'node:timers/promises';
import { promisify } from 'node:util';
import { ForelandError, Terrain } from '@foreland/client';
import { readHeights } from './heights.mjs';
import { freePort, makeFolder, makeGlobe, makeScene, runForeland, startServer } from './support.mjs';

const kTest = { timeout: 180_000 };
const kLens = { fovY: 1.05, width: 640, height: 360 };
let folder, scene, server, address;

before(async () => {
  folder = await makeFolder();
  scene = await makeScene(folder.folder, { size: 257 });
  server = await startServer(scene);
  address = server.url.href.replace('http', 'ws');
}, kTest);
after(async () => {
  await server?.stop();
  await folder?.remove();
});

const codeOf = (promise) => promise.then(() => null, (error) => (assert.ok(error instanceof ForelandError, error), assert.ok(error.message && error.advice !== undefined), error.code));
const middleOf = ({ bounds: { low, high } }, above_m = 500) => [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), high[2] + above_m];

// Frames of a camera that looks down on the scene and moves, until `isDone` of one.
async function fly(terrain, isDone, speed = 0.05) {
  const begun = performance.now();
  for (;; await setImmediate()) {
    const now = performance.now();
    const [x, y, z] = middleOf(terrain.scene);
    const frame = terrain.frame(now, { eye: [x + speed * (now - begun), y, z], orientation: [0, 0, 0, 1] });
    if (isDone(frame)) return frame;
    if (now - begun > kTest.timeout) throw new Error('flown for too long');
  }
}
const isFlown = (terrain, keyframes = 5) => (frame) => frame.version > 0 && frame.guaranteedPx !== null && terrain.stats.keyframes >= keyframes;

test('a scene is told as plain, frozen values', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  const { scene: told } = terrain;
  assert.equal(told.title, 'Example mountains.tif');
  assert.match(told.id, /^[0-9a-f]{16}$/);
  assert.equal(told.frame, 'planar');
  assert.equal(told.toEcef, null);
  assert.ok(told.heights.highest > told.heights.lowest);
  assert.deepEqual(told.samples, [257, 257]);
  assert.throws(() => (told.bounds.low[0] = 0), TypeError);
  assert.deepEqual(JSON.parse(JSON.stringify(told)), told);
  await terrain.close();
});

test('no frame tells a guarantee beyond the tolerance, and a change of it takes effect', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens, tolerancePx: 2 });
  const told = [];
  terrain.on('guarantee', (px) => told.push(px));
  await fly(terrain, (frame) => {
    // A camera that is hard to predict has four times the tolerance at most.
    assert.ok(frame.guaranteedPx === null || frame.guaranteedPx <= 8, `${frame.guaranteedPx} px`);
    return isFlown(terrain, 8)(frame);
  });
  assert.ok(told.includes(2));
  terrain.setOptions({ tolerancePx: 0.5 });
  await fly(terrain, (frame) => frame.guaranteedPx === 0.5);
  await terrain.close();
});

test('what a viewer can draw and take is kept to, at a coarser tolerance that is told', kTest, async () => {
  for (const limits of [{ triangles: 1500 }, { bytesPerSecond: 2000 }]) {
    const terrain = await Terrain.open(address, { lens: kLens, tolerancePx: 0.25, relief: false, limits });
    let most = 0;
    const sink = { coming: 0, staged: 0, get ready() { return terrain.nextVersion; }, reset() {}, add({ version, terrain: { triangles } }) { [this.staged, most] = [version, Math.max(most, triangles)]; } };
    terrain.attach(sink);
    await fly(terrain, (frame) => isFlown(terrain, 12)(frame) && frame.guaranteedPx > 0.25);
    if (limits.triangles) assert.ok(most > 100 && most <= limits.triangles, `${most} triangles`);
    await terrain.close();
  }
});

test('exact heights are those of the raster, and what is held agrees with them by the tolerance', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  const raster = await readHeights(join(folder.folder, 'Example mountains.tif'));
  const { low, high } = terrain.scene.bounds;
  const spacing = (high[0] - low[0]) / (raster.side - 1);
  const samples = Array.from({ length: 500 }, (_, i) => [(i * 97) % raster.side, (i * 61) % raster.side]);
  const places = samples.map(([x, y]) => {
    const { easting, northing } = terrain.toGeodetic([low[0] + x * spacing, low[1] + y * spacing, 0]);
    return { easting, northing };
  });
  const heights = await terrain.heights(places);
  samples.forEach(([x, y], i) => assert.ok(Math.abs(heights[i] - raster.at(x, y)) <= 0.051, `${heights[i]} for ${raster.at(x, y)} m at ${x}, ${y}`));
  assert.ok(Number.isNaN((await terrain.heights([{ easting: places[0].easting - 1e6, northing: 0 }]))[0]), 'beyond the data');
  // Questions at once are answered each by its own.
  const [a, b] = await Promise.all([terrain.heights(places.slice(0, 7)), terrain.heights(places.slice(7, 9))]);
  assert.deepEqual([...a, ...b], [...heights.slice(0, 9)]);
  await fly(terrain, isFlown(terrain, 10));
  const middle = terrain.toGeodetic(middleOf(terrain.scene));
  const [exact] = await terrain.heights([middle]);
  const held = await fly(terrain, () => terrain.heightNow(middle) !== null).then(() => terrain.heightNow(middle));
  assert.ok(Math.abs(held - exact) < 20, `${held} m held, ${exact} m exact`);
  await terrain.close();
});

test('heights by both surfaces differ by the geoid, in what is held and in what the server says', kTest, async () => {
  const [raster, above_sea] = ['Placed mountains.tif', 'above_the_sea.fls'].map((name) => join(folder.folder, name));
  await promisify(execFile)('gdal_translate', ['-q', '-a_srs', 'EPSG:32632', '-a_ullr', '400000', '5150000', '408000', '5142000', join(folder.folder, 'Example mountains.tif'), raster]);
  await runForeland('build', raster, '--vertical', 'egm96', '-o', above_sea);
  const its_server = await startServer(above_sea);
  try {
    const terrain = await Terrain.open(its_server.url.href.replace('http', 'ws'), { lens: kLens });
    const { vertical } = terrain.scene;
    assert.deepEqual([vertical.above, vertical.name, vertical.geoid], ['sea', 'EGM96', 'EGM96']);
    const place = terrain.toGeodetic(middleOf(terrain.scene));
    const [both] = await terrain.bothHeights([place]);
    const undulation = both.aboveEllipsoid - both.aboveSea;
    assert.equal(both.aboveSea, both.height);
    assert.ok(Math.abs(undulation) > 1 && Math.abs(undulation) < 110, `${undulation} m`);
    assert.ok(Math.abs(place.aboveEllipsoid - place.aboveSea - undulation) < vertical.maxError + 1e-3, 'the read-out');
    await terrain.close();
  } finally {
    await its_server.stop();
  }
  const unstated = await Terrain.open(address, { lens: kLens });
  assert.equal(unstated.scene.vertical.above, 'unstated');
  assert.deepEqual((await unstated.bothHeights([unstated.toGeodetic(middleOf(unstated.scene))])).map(({ aboveSea, aboveEllipsoid }) => [aboveSea, aboveEllipsoid]), [[null, null]]);
  await unstated.close();
});

test('places go to the scene and back, and rays meet the ground', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  for (let i = 0; i < 50; ++i) {
    const point = [37.5 * i, -21 * i, 100 + i];
    const back = terrain.toScene(terrain.toGeodetic(point));
    back.forEach((v, axis) => assert.ok(Math.abs(v - point[axis]) < 1e-6, `${back} for ${point}`));
  }
  assert.throws(() => terrain.toScene({ lon: 7, lat: 45 }), (error) => error instanceof ForelandError && error.code === 'argument');
  await fly(terrain, isFlown(terrain, 6));
  const eye = middleOf(terrain.scene);
  const met = terrain.raycast(eye, [0.1, 0.2, -1]);
  const place = terrain.place(met);
  assert.ok(Math.abs(place.height - place.ground) < 0.1, `${place.height - place.ground} m above ground`);
  assert.equal(terrain.raycast(eye, [0, 0, 1]), null);
  const swept = terrain.sweep(eye, [eye[0], eye[1], -1e4], 2);
  assert.ok(terrain.place(swept).height - terrain.place(swept).ground > 1.9);
  await terrain.close();
});

// A place of the scene by its position on the lattice.
function placesOf(terrain) {
  const { low, high } = terrain.scene.bounds;
  const [at, across] = [terrain.place(low), terrain.place(high)];
  const step = [0, 1].map((i) => (high[i] - low[i]) / (across.lattice[i] - at.lattice[i]));
  return (x, y, height) => ({ easting: at.easting + (x - at.lattice[0]) * step[0], northing: at.northing + (y - at.lattice[1]) * step[1], height });
}
const kStraight = { refraction: 1 }; // on a map

test('lines of sight end at the ground where it hides, and nowhere else', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  const placeAt = placesOf(terrain);
  const { highest } = terrain.scene.heights;
  const columns = Array.from({ length: 200 }, (_, i) => [(i * 97) % 256, (i * 61) % 256]);
  const down = await terrain.visible(columns.map(([x, y]) => [placeAt(x, y, highest + 500), placeAt(x, y, -5000)]), kStraight);
  const heights = await terrain.heights(columns.map(([x, y]) => placeAt(x, y)));
  down.forEach((sight, i) => {
    assert.ok(sight.isKnown && !sight.isSeen && sight.object === null);
    assert.ok(Math.abs(terrain.place(sight.hit).height - heights[i]) < 1e-3, `${terrain.place(sight.hit).height} for ${heights[i]} m`);
    terrain.toScene(placeAt(...columns[i], highest + 500)).forEach((v, axis) => assert.ok(Math.abs(v - sight.from[axis]) < 1e-6));
  });
  const level = columns.slice(1).map((column, i) => [placeAt(...columns[i], highest + 500), placeAt(...column, highest + 500)]);
  for (const sight of await terrain.visible(level)) assert.ok(sight.isSeen && sight.hit === null);
  const [near, outside] = await terrain.visible([[placeAt(9, 9, 2), placeAt(9.1, 9, 2)], [placeAt(9, 9, 2), placeAt(1e6, 9, 2)]], { above: 'ground' });
  assert.ok(near.isKnown && Math.abs(terrain.place(near.from).height - 2 - (await terrain.heights([placeAt(9, 9)]))[0]) < 1e-3, 'above the ground');
  assert.deepEqual([outside.isKnown, outside.isSeen, outside.hit], [false, false, null]);
  assert.deepEqual(await terrain.visible([]), []);
  for (const [pairs, options] of [[Array(4097).fill(level[0])], [level, { refraction: 2 }], [[[placeAt(0, 0, NaN), placeAt(1, 1)]]], [[[{ lon: 7, lat: 45 }, placeAt(1, 1)]]]])
    assert.equal(await codeOf(terrain.visible(pairs, options)), 'argument');
  assert.ok(terrain.isConnected);
  await terrain.close();
});

test('ground and lines of sight over a globe are the same by all names of a place, and go over its pole', kTest, async () => {
  const own = await makeFolder(), globe = await startServer(await makeGlobe(own.folder));
  try {
    const terrain = await Terrain.open(globe.url.href.replace('http', 'ws'), { lens: kLens });
    const at = (lat, lon, height = 0) => ({ lat, lon, height }), corner = (Math.atan(Math.SQRT1_2) * 180) / Math.PI;
    const names = [[[90, 0], [90, 77], [90, -180]], [[-90, 10], [-90, -100]], [[-45, 180], [-45, -180], [-45, 179.9999999]], [[12, 180], [12, -180]]];
    for (const lon of [-135, -45, 45, 135]) for (const lat of [-corner, -10, 0, 46, corner]) names.push([[lat, lon], [lat, lon - 1e-7], [lat, lon + 1e-7], [lat - 1e-7, lon]]);
    const heights = await terrain.heights(names.flat().map(([lat, lon]) => at(lat, lon)));
    let first = 0;
    for (const of_place of names) {
      const told = heights.slice(first, (first += of_place.length));
      assert.ok(told.every((height) => Math.abs(height - told[0]) < 0.01), `${of_place[0]}: ${told}`);
    }
    // From 5 degrees beside the island at the north pole to 5 degrees beyond it, so high above the pole.
    const [pole] = await terrain.heights([at(90, 0)]);
    const across = (above) => {
      let [low, high] = [0, 1e5];
      const ends = (height) => [at(85, 20, height), at(85, -160, height)];
      for (let i = 0; i < 60; ++i) {
        const middle = (low + high) / 2, [from, to] = ends(middle).map((end) => terrain.toScene(end));
        if (terrain.toGeodetic(from.map((v, k) => (v + to[k]) / 2)).height < pole + above) low = middle;
        else high = middle;
      }
      return ends(low);
    };
    assert.ok(pole > 2000, `${pole} m`);
    const [below, above] = await terrain.visible([across(-50), across(300)], { refraction: 0 });
    assert.ok(!below.isSeen && below.hit[2] > 6.35e6 && Math.hypot(below.hit[0], below.hit[1]) < 1e5, JSON.stringify(below));
    assert.ok(above.isSeen, JSON.stringify(above));
    await terrain.close();
  } finally {
    await globe.stop();
    await own.remove();
  }
});

test('a viewshed has the cells that lines of sight find seen', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  const placeAt = placesOf(terrain);
  const from = { ...placeAt(130, 120), height: 20 };
  const told = [];
  const whole = await terrain.viewshed({ from, target: 2, radius: 3000, cell: 20 }, (viewshed) => {
    told.push(viewshed.known);
    if (told.length === 1) throw new Error('a listener of the test, which stops nobody');
  });
  assert.ok(told.every((known, i) => known > (told[i - 1] ?? 0)), `${told}`);
  assert.equal(told.at(-1), whole.cells.length);
  assert.equal(whole.cells.length, whole.columns * whole.rows);
  const cells = Array.from({ length: 2000 }, (_, i) => (i * 7919) % whole.cells.length).filter((cell) => whole.cells[cell] !== 2);
  const middleOfCell = (cell) => placeAt(whole.first[0] + (cell % whole.columns) * whole.step[0], whole.first[1] + Math.floor(cell / whole.columns) * whole.step[1], 2);
  const sights = await terrain.visible(cells.map((cell) => [from, middleOfCell(cell)]), { above: 'ground' });
  const differing = cells.filter((cell, i) => (whole.cells[cell] === 1) !== sights[i].isSeen);
  assert.deepEqual(differing, [], `of ${cells.length}`);
  const seen = cells.filter((cell) => whole.cells[cell] === 1).length;
  assert.ok(seen > 0.02 * cells.length && seen < 0.98 * cells.length, `${seen} of ${cells.length} are seen`);
  await terrain.close();
});

test('a viewshed is ended by its signal, by another one and with the terrain, and says why there is none', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  const placeAt = placesOf(terrain);
  const question = { from: placeAt(130, 120, 20), radius: 3000, cell: 3 };
  const ended = new AbortController();
  const reason = new Error('enough');
  await assert.rejects(terrain.viewshed({ ...question, signal: ended.signal }, () => ended.abort(reason)), reason);
  await assert.rejects(terrain.viewshed({ ...question, signal: ended.signal }), reason);
  const replaced = terrain.viewshed(question).catch((error) => error);
  const small = await terrain.viewshed({ ...question, cell: 100 });
  const { code, message } = await replaced;
  assert.deepEqual([code, message], ['unanswered', 'Another viewshed was asked for instead.']);
  assert.equal(small.known, small.cells.length);
  assert.equal(await codeOf(terrain.viewshed({ ...question, from: placeAt(1e6, 0, 20) })), 'unanswered');
  assert.equal(await codeOf(terrain.viewshed({ ...question, cell: 0.01 })), 'unanswered');
  for (const wrong of [{ radius: 0 }, { cell: NaN }, { from: placeAt(130, 120, -1) }, { refraction: -1 }])
    assert.equal(await codeOf(terrain.viewshed({ ...question, ...wrong })), 'argument');
  const closed = codeOf(terrain.viewshed(question));
  await terrain.close();
  assert.equal(await closed, 'closed');
  assert.equal(await codeOf(terrain.viewshed(question)), 'closed');
});

test('updates make up the mesh that a frame names', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  const reader = terrain.updates.getReader();
  let vertices = 0, last = 0, nearest = Infinity, is_done = false;
  const reading = (async () => {
    for (let { value, done } = await reader.read(); !done; { value, done } = await reader.read()) {
      const { version, terrain: { is_whole, channels } } = value;
      assert.ok(version > last);
      assert.ok(version <= terrain.nextVersion, 'none is read before its time');
      assert.ok(last > 0 || is_whole, 'the first one needs nothing');
      for (const { ranges, data } of Object.values(channels))
        for (let i = 2; i < ranges.length; i += 2) nearest = Math.min(nearest, (ranges[i] - ranges[i - 1]) * data.BYTES_PER_ELEMENT);
      [last, vertices] = [version, channels.to_position.size / 4];
    }
    is_done = true;
  })();
  await fly(terrain, (frame) => (assert.ok(frame.version <= last, 'none is shown that was not read'), frame.version > 3 && isFlown(terrain, 12)(frame)));
  assert.ok(vertices > 100);
  assert.ok(nearest >= 512 && nearest < Infinity, `ranges are ${nearest} bytes apart: what is not worth a call of its own is one range`);
  await terrain.close();
  await reading;
  assert.ok(is_done);
});

test('a connection that is lost is made anew, and told of', kTest, async () => {
  const own = await startServer(scene);
  const terrain = await Terrain.open(own.url.href, { lens: kLens }); // http: will do
  const told = [];
  terrain.on('stall', ({ seconds, reason }) => told.push([seconds, reason]));
  let scenes = 0;
  terrain.on('scene', () => ++scenes);
  await fly(terrain, isFlown(terrain));
  await own.stop();
  await fly(terrain, () => told.length > 0 && !terrain.isConnected);
  const again = await startServer(scene, own.port);
  await fly(terrain, () => scenes > 0 && terrain.isConnected);
  assert.equal(terrain.isOver, false);
  await terrain.close();
  await again.stop();
});

// For a proxy before several servers. Between the terrain and the server stands one that keeps the addresses.
test('over a large scene a connection that is made anew says the area that the camera is in, and no other does', kTest, async (t) => {
  const raster = join(folder.folder, 'strip.asc'), strip = join(folder.folder, 'strip.fls');
  const row = Array.from({ length: 5000 }, (_, i) => i % 7).join(' ');
  await writeFile(raster, `ncols 5000\nnrows 3\nxllcenter 0\nyllcenter 0\ncellsize 10\n${`${row}\n`.repeat(3)}`);
  await runForeland('build', raster, '--frame', 'planar', '-o', strip);
  for (const [served, expected] of [[strip, 1], [scene, null]]) {
    const own = await startServer(served), addresses = [], sockets = [], proxy = createServer();
    proxy.on('upgrade', (request, socket) => {
      addresses.push(request.url);
      const far = connect(own.url.port, own.url.hostname);
      const fields = Array.from({ length: request.rawHeaders.length / 2 }, (_, i) => `${request.rawHeaders[2 * i]}: ${request.rawHeaders[2 * i + 1]}\r\n`);
      far.write(`GET ${request.url} HTTP/1.1\r\n${fields.join('')}\r\n`);
      sockets.push(socket.on('error', () => far.destroy()), far.on('error', () => socket.destroy()));
      socket.pipe(far).pipe(socket);
    });
    await new Promise((resolve) => proxy.listen(0, '127.0.0.1', resolve));
    t.after(() => (sockets.forEach((socket) => socket.destroy()), proxy.close(), own.stop()));
    const terrain = await Terrain.open(`ws://127.0.0.1:${proxy.address().port}/?x=y`, { lens: kLens });
    t.after(() => terrain.close());
    await fly(terrain, isFlown(terrain, 2), 0);
    assert.equal(terrain.area, expected);
    sockets.splice(0).forEach((socket) => socket.destroy());
    await fly(terrain, () => addresses.length === 2 && terrain.isConnected, 0);
    assert.deepEqual(addresses, ['/fly?x=y', expected === null ? '/fly?x=y' : `/fly?x=y&area=${expected}`]);
    assert.ok(!terrain.server.includes('area'));
  }
});

test('each way that opening can fail has its name', kTest, async () => {
  assert.equal(await codeOf(Terrain.open('nowhere', {})), 'address');
  assert.equal(await codeOf(Terrain.open('ftp://localhost/')), 'address');
  assert.equal(await codeOf(Terrain.open(`ws://127.0.0.1:${await freePort()}/`, { patienceMs: 400 })), 'unreachable');
  assert.equal(await codeOf(Terrain.open(address, { wasm: new URL('none.wasm', import.meta.url) })), 'start');
  assert.equal(await codeOf(Terrain.open(address, { worker: new URL('none.js', import.meta.url) })), 'worker');
  assert.equal(await codeOf(Terrain.open(address, { lens: { fovY: 7, width: 640, height: 360 } })), 'refused');
  assert.equal(await codeOf(Terrain.open(address, { signal: AbortSignal.abort() })), 'closed');
  const aborting = new AbortController();
  const opening = Terrain.open(`ws://127.0.0.1:${await freePort()}/`, { signal: aborting.signal });
  aborting.abort();
  assert.equal(await codeOf(opening), 'closed');
});

test('what is no server is told of, with what it said', kTest, async () => {
  const other = createServer((_, reply) => reply.writeHead(404, { 'content-type': 'text/plain' }).end('nothing here'));
  await new Promise((done) => other.listen(0, '127.0.0.1', done));
  const error = await Terrain.open(`http://127.0.0.1:${other.address().port}/`, { patienceMs: 1500 }).catch((e) => e);
  assert.equal(error.code, 'unreachable');
  assert.match(error.message, /no server of terrain \(HTTP 404/);
  await new Promise((done) => (other.closeAllConnections(), other.close(done)));
});

test('whoever waits as a terrain is closed is told', kTest, async () => {
  const terrain = await Terrain.open(address, { lens: kLens });
  let closed = 0;
  terrain.on('closed', () => ++closed);
  const asked = codeOf(terrain.heights([{ easting: 0, northing: 0 }]));
  const closing = terrain.close();
  assert.equal(await asked, 'closed');
  await Promise.all([closing, terrain.close()]);
  assert.equal(closed, 1);
  assert.equal(await codeOf(terrain.heights([{ easting: 0, northing: 0 }])), 'closed');
  assert.ok(terrain.isOver);
});

test('what is asked for before there is a session is asked for then', kTest, async () => {
  const terrain = Terrain.connect(address, { lens: kLens });
  terrain.requestTour('orbit', 10);
  terrain.setOptions({ tolerancePx: 3 });
  assert.equal(terrain.hasScene, false);
  await terrain.ready;
  await fly(terrain, (frame) => terrain.hasTour && frame.guaranteedPx === 3);
  const start = performance.now();
  terrain.startTour(start);
  assert.ok(terrain.tourPose(start + 5000));
  assert.equal(terrain.tourPose(start + 11_000), null);
  await terrain.close();
});

test('two terrains fly side by side', kTest, async () => {
  const both = await Promise.all([Terrain.open(address, { lens: kLens }), Terrain.open(address, { lens: kLens, tolerancePx: 3 })]);
  const frames = await Promise.all(both.map((terrain) => fly(terrain, isFlown(terrain))));
  assert.deepEqual(frames.map((frame) => frame.guaranteedPx), [1, 3]);
  for (const terrain of both) await terrain.close();
});

// A worker and a module's memory each would be 100 MB by then.
test('opened and closed fifty times, it holds no more than after the first', kTest, async () => {
  const held = [];
  for (let i = 0; i < 50; ++i) {
    const terrain = await Terrain.open(address, { lens: kLens });
    await fly(terrain, (frame) => frame.version > 0);
    await terrain.close();
    globalThis.gc?.();
    held.push(process.memoryUsage().rss / 2 ** 20);
  }
  assert.ok(Math.min(...held.slice(-5)) < held[9] + 60, `MiB: ${held.map(Math.round)}`);
});
