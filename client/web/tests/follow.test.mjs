// Tracks, flights and the camera that follows them: laws of the curve through the fixes, and of the camera's path.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openSources } from './support.mjs';

let sources, tracks, flights, cameras, basis, ways;
before(async () => {
  sources = await openSources();
  [tracks, flights, cameras, basis, ways] = await Promise.all(['track', 'flight', 'camera_path', 'basis', 'waypoints'].map((name) => sources.load(`follow/${name}.ts`)));
});
after(() => sources?.close());

// Numbers from 0 to 1, of a seed.
function random(seed) {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}
const away = (a, b) => Math.hypot(...a.map((v, k) => v - b[k]));
const lineWith = (coordinates, times) => ({ type: 'Feature', properties: times ? { coordTimes: times } : {}, geometry: { type: 'LineString', coordinates } });
const at = (seconds) => new Date(Date.UTC(2024, 5, 1, 12) + 1000 * seconds).toISOString();
const flat = () => [0, 0, 1];
const degrees = { is_degrees: true, toPlace: (lon, lat) => ({ lon, lat }) }, metres = { is_degrees: false, toPlace: (easting, northing) => ({ easting, northing }) };

// A flight of a seed: fixes at uneven times, which turns and climbs.
function flightOf(seed, count = 200) {
  const next = random(seed), times = [0], points = [[4e5, 5e6, 2000]];
  let heading = 6 * next();
  while (times.length < count) {
    const step = 0.5 + 3 * next(), last = points.at(-1);
    heading += 0.6 * (next() - 0.5);
    times.push(times.at(-1) + step);
    points.push([last[0] + 30 * step * Math.sin(heading), last[1] + 30 * step * Math.cos(heading), last[2] + 6 * step * (next() - 0.5)]);
  }
  return { times, points, flight: flights.flightOf(times, points, points.map(([, , z]) => z)) };
}

test('a flight passes through its fixes, and its speed integrates to its length, its climb to what it gains', () => {
  for (let seed = 1; seed <= 5; ++seed) {
    const { times, points, flight } = flightOf(seed);
    times.forEach((time, i) => assert.ok(away(flights.pointAt(flight, time), points[i]) < 1e-6, `seed ${seed}, fix ${i}`));
    const last = flights.durationOf(flight), steps = 40_000, dt = last / steps;
    let by_speed = 0, by_points = 0, by_climb = 0, before_ = points[0];
    for (let k = 0; k < steps; ++k) {
      by_speed += flights.speedAt(flight, (k + 0.5) * dt) * dt;
      by_climb += flights.climbAt(flight, (k + 0.5) * dt) * dt;
      const point = flights.pointAt(flight, (k + 1) * dt);
      by_points += away(point, before_);
      before_ = point;
    }
    assert.ok(Math.abs(by_speed / by_points - 1) < 1e-5, `seed ${seed}: ${by_speed} m by speed, ${by_points} m long`);
    assert.ok(Math.abs(by_climb - (points.at(-1)[2] - points[0][2])) < 1e-3, `seed ${seed}: climbs ${by_climb} m`);
  }
});

test('instruments show the mean over a while, also at the ends', () => {
  const flight = flights.flightOf([0, 10, 20], [[0, 0, 0], [300, 0, 50], [600, 0, 100]], [0, 50, 100]);
  for (const time of [-5, 0, 3, 10, 20, 40]) {
    assert.ok(Math.abs(flights.meanSpeedAt(flight, time, 4) - Math.hypot(30, 5)) < 1e-6);
    assert.ok(Math.abs(flights.meanClimbAt(flight, time, 4) - 5) < 1e-9);
  }
});

// Where the aircraft is in the picture: how far off the middle of the view, radians.
function offMiddle({ eye, orientation: [x, y, z, w] }, point) {
  const forward = [-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))];
  const to = point.map((v, k) => v - eye[k]), length = Math.hypot(...to);
  return Math.acos(Math.min(1, forward.reduce((sum, v, k) => sum + (v * to[k]) / length, 0)));
}

test('the chase camera looks at the aircraft from behind and above, however fast it is shown', () => {
  for (let seed = 1; seed <= 3; ++seed) {
    const { flight } = flightOf(seed);
    for (const speed of [1, 5, 20]) {
      const course = cameras.courseOf(flight, 'chase', speed, flat), path = cameras.posesOf(course, 'chase', course.eyes.map(() => 0), flat);
      path.poses.forEach((pose, i) => {
        const aircraft = flights.pointAt(flight, Math.min(i * path.step_s, flights.durationOf(flight)));
        const off = offMiddle(pose, aircraft);
        assert.ok(off < (speed === 1 ? 0.04 : 0.2), `seed ${seed}, ${speed} times, pose ${i}: ${off} rad off the middle`);
        assert.ok(pose.eye[2] > aircraft[2] && away(pose.eye, aircraft) > 30);
      });
    }
  }
});

test('a chase camera of a straight flight is behind it', () => {
  const flight = flights.flightOf([0, 60], [[0, 0, 100], [0, 3000, 100]], [100, 100]);
  const { eyes } = cameras.courseOf(flight, 'chase', 1, flat);
  eyes.forEach(([x, y], i) => assert.ok(Math.abs(x) < 1e-9 && y < 50 * i * 0.1 - 50));
});

test('the cockpit looks ahead and a little down from where the aircraft is', () => {
  const flight = flights.flightOf([0, 60], [[0, 0, 100], [3000, 0, 100]], [100, 100]);
  const course = cameras.courseOf(flight, 'cockpit', 1, flat), { poses } = cameras.posesOf(course, 'cockpit', course.eyes.map(() => 7), flat);
  poses.forEach((pose, i) => {
    assert.ok(away(pose.eye, [50 * i * 0.1, 0, 107]) < 1e-6);
    assert.ok(Math.abs(offMiddle(pose, [pose.eye[0] + 1, 0, 107]) - 0.14) < 1e-9);
  });
});

test('eyes are lifted nowhere less than the ground asks, and smoothly', () => {
  const next = random(3), lifts = Array.from({ length: 500 }, () => (next() < 0.05 ? 100 * next() : 0));
  const lifted = cameras.liftsOf(lifts, 10);
  lifted.forEach((lift, i) => {
    assert.ok(lift >= lifts[i]);
    if (i > 0) assert.ok(Math.abs(lift - lifted[i - 1]) <= 100 / 21 + 1e-9, `${lifted[i - 1]}, then ${lift}`);
  });
  assert.deepEqual(cameras.liftsOf([0, 0, 0, 0], 2), [0, 0, 0, 0]);
  assert.deepEqual(cameras.spread([0, 10, 20], 2, 5), [0, 5, 10, 15, 20]);
});

test('a piece of a path is the path, between its second pose and the last but one', () => {
  const { flight } = flightOf(4), course = cameras.courseOf(flight, 'chase', 2, flat), path = cameras.posesOf(course, 'chase', course.eyes.map(() => 0), flat);
  const first = 40, piece = { step_s: path.step_s, poses: path.poses.slice(first, first + 60) };
  for (let t = 1; t < 58; t += 0.13) {
    const [whole, part] = [cameras.poseOn(path, (first + t) * path.step_s), cameras.poseOn(piece, t * path.step_s)];
    assert.ok(away(whole.eye, part.eye) < 1e-6 && away(whole.orientation, part.orientation) < 1e-9, `at ${t}`);
  }
  path.poses.forEach((pose, i) => assert.ok(away(cameras.poseOn(path, i * path.step_s).eye, pose.eye) < 1e-6));
});

// As Catmull-Rom does, by which the server evaluates it (proto/space/path.cpp).
test('a path reproduces a parabola between its poses', () => {
  const path = { step_s: 0.5, poses: Array.from({ length: 8 }, (_, i) => ({ eye: [i * i, 3 * i, 7], orientation: [0, 0, 0, 1] })) };
  for (let t = 1; t < 6; t += 0.07) assert.ok(away(cameras.poseOn(path, 0.5 * t).eye, [t * t, 3 * t, 7]) < 1e-9, `at ${t}`);
});

test('up is away from the ellipsoid, and east, north and up are square', () => {
  assert.deepEqual(basis.upIn({ toEcef: null })([1, 2, 3]), [0, 0, 1]);
  // The axes of a scene at 46 degrees north, 8 east.
  const [lat, lon] = [46, 8].map((d) => (d * Math.PI) / 180), [sf, cf, sl, cl] = [Math.sin(lat), Math.cos(lat), Math.sin(lon), Math.cos(lon)];
  const n = 6378137 / Math.sqrt(1 - 0.00669437999 * sf * sf);
  const toEcef = [-sl, cl, 0, 0, -sf * cl, -sf * sl, cf, 0, cf * cl, cf * sl, sf, 0, n * cf * cl, n * cf * sl, n * (1 - 0.00669437999) * sf, 1];
  const upAt = basis.upIn({ toEcef });
  assert.ok(away(upAt([0, 0, 0]), [0, 0, 1]) < 1e-9);
  assert.ok(away(upAt([0, 0, 20_000]), [0, 0, 1]) < 2e-5);
  const [east, north, up] = basis.basisAt([30_000, -20_000, 1000], upAt);
  for (const [a, b] of [[east, north], [north, up], [up, east]]) assert.ok(Math.abs(a.reduce((sum, v, k) => sum + v * b[k], 0)) < 1e-9);
});

test('tracks have the times and heights that are written, and what is missing is said', () => {
  const timed = tracks.trackOf('a.gpx', lineWith([[8, 46, 1000], [8.01, 46, 1200], [8.02, 46], [8.03, 46, 1400]], [0, 10, 20, 30].map(at)), degrees);
  assert.deepEqual(timed.fixes.map(({ time_s }) => time_s), [0, 10, 20, 30]);
  assert.deepEqual(timed.fixes.map(({ height_m }) => height_m), [1000, 1200, 1300, 1400]);
  assert.equal(new Date(timed.begin_ms).toISOString(), at(0));
  assert.deepEqual(timed.notes, []);
  const odd = tracks.trackOf('b.gpx', lineWith([[8, 46], [8.01, 46], [8.02, 46], [8.03, 46]], [at(0), at(10), at(5), at(20)]), degrees);
  assert.deepEqual(odd.fixes.map(({ time_s, height_m }) => [time_s, height_m]), [[0, null], [10, null], [20, null]]);
  assert.match(odd.notes[0], /1 of 4 places have no time, or one that does not ascend/);
  const untimed = tracks.trackOf('c.gpx', lineWith([[8, 46], [8, 46.09]]), degrees);
  assert.match(untimed.notes[0], /c\.gpx has no times: it is flown at 10 m\/s/);
  assert.ok(Math.abs(untimed.fixes[1].time_s - 1000.8) < 1 && untimed.begin_ms === null);
  assert.deepEqual(tracks.trackOf('d', lineWith([[5, 6], [5, 106]]), metres).fixes.map(({ time_s, place }) => [time_s, place]),
    [[0, { easting: 5, northing: 6 }], [10, { easting: 5, northing: 106 }]]);
  const split = { type: 'Feature', properties: { coordinateProperties: { times: [[at(0), at(1)], [at(9), at(10)]] } }, geometry: { type: 'MultiLineString', coordinates: [[[8, 46], [8, 46.1]], [[8, 46.2], [8, 46.3]]] } };
  assert.deepEqual(tracks.trackOf('e', { type: 'FeatureCollection', features: [split, null, 7] }, degrees).fixes.map(({ time_s }) => time_s), [0, 1, 9, 10]);
  assert.ok(tracks.hasTimes(split) && !tracks.hasTimes(lineWith([[8, 46], [9, 46]])));
});

test('the track of a file is its lines with times, and any of GPX', async () => {
  const { trackIn } = await sources.load('overlay/track_in.ts'), bytesOf = (text) => new TextEncoder().encode(text);
  const placemark = (inside) => `<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Placemark>${inside}</Placemark></kml>`;
  const coords = '<gx:coord>8 46 900</gx:coord><gx:coord>8.1 46 900</gx:coord>', whens = `<when>${at(0)}</when><when>${at(9)}</when>`;
  const files = [
    ['a.gpx', '<gpx xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg><trkpt lat="46" lon="8"/><trkpt lat="46.1" lon="8"/></trkseg></trk></gpx>', true],
    ['a.kml', placemark(`<gx:Track>${whens}${coords}</gx:Track>`), true],
    ['a.kml', placemark('<LineString><coordinates>8,46 8.1,46</coordinates></LineString>'), false],
    ['a.geojson', JSON.stringify(lineWith([[8, 46], [8, 46.1]], [0, 10].map(at))), true],
    ['a.geojson', JSON.stringify(lineWith([[8, 46], [8, 46.1]])), false],
    ['a.geojson', 'no JSON at all', false],
    ['a.csv', 'name,lon,lat\nA,8,46\n', false],
  ];
  for (const [name, text, has_track] of files) assert.equal(trackIn(name, bytesOf(text)) !== null, has_track, `${name}: ${text}`);
  assert.throws(() => trackIn('a.kml', bytesOf('<kml>')), /a\.kml is no XML/);
});

test('what is no track is refused in words', () => {
  assert.throws(() => tracks.trackOf('a', { type: 'FeatureCollection', features: [] }, degrees), /a has no track: no line/);
  assert.throws(() => tracks.trackOf('a', null, degrees), /has no track/);
  assert.throws(() => tracks.trackOf('a', lineWith([[8, 46], [8, 46], [8, 46]]), degrees), /stays at one place/);
  assert.throws(() => tracks.trackOf('a', lineWith([['x', 46], [8, null]]), degrees), /no line of two places/);
  assert.throws(() => tracks.trackOf('a', lineWith(Array.from({ length: 400_001 }, () => [8, 46])), degrees), /more than 400,000 places/);
});

// A camera's waypoints, of a seed; with turns over north, and one on the spot.
function waypointsOf(seed, count = 6) {
  const next = random(seed), waypoints = Array.from({ length: count }, () => ({ eye: [3000 * next(), 3000 * next(), 500 + 500 * next()], heading: 2 * Math.PI * next(), pitch: -0.8 * next() }));
  waypoints[2].eye = [...waypoints[1].eye];
  return waypoints.map((waypoint) => ({ ...waypoint, height_m: waypoint.eye[2] }));
}

test('a way passes through its waypoints, looks where they look, and turns by the shorter way', () => {
  for (let seed = 1; seed <= 20; ++seed) {
    const waypoints = waypointsOf(seed), way = ways.wayThrough(waypoints, 40), { times_s } = way.flight;
    assert.ok(Math.abs(times_s.at(-1) - 40) < 1e-9);
    waypoints.forEach((waypoint, i) => {
      const course = ways.courseOfWay(way, Math.max(times_s[i], 1e-3), flat), k = i === 0 ? 0 : 1;
      assert.ok(away(course.eyes[k], waypoint.eye) < 1e-6, `seed ${seed}, waypoint ${i}`);
      const pose = cameras.poseTowards(course.eyes[k], course.targets[k], flat()), wanted = ways.poseAt(waypoint, flat);
      assert.ok(Math.abs(pose.orientation.reduce((sum, v, j) => sum + v * wanted.orientation[j], 0)) > 1 - 1e-9, `seed ${seed}, waypoint ${i} looks elsewhere`);
      if (i > 0) assert.ok(times_s[i] > times_s[i - 1] && Math.abs(way.looks.points[i][0] - way.looks.points[i - 1][0]) <= Math.PI + 1e-9);
    });
  }
});

test('a tour is read again as it was written, and its way has the waypoints at their times', () => {
  const places = [[8.1, 46.2, 2000, 350, -10], [8.2, 46.3, 2100.5, 20, 5]].map(([lon, lat, height_m, heading_deg, pitch_deg]) => ({ place: { lon, lat }, height_m, heading_deg, pitch_deg }));
  const way = places.map(({ place, height_m }, i) => ({ place, height_m, time_s: 12 * i }));
  const text = ways.tourJson({ name: 'A & <B>', seconds: 12, waypoints: places, way, crs: '' });
  assert.deepEqual(ways.tourIn(JSON.parse(text)), { seconds: 12, waypoints: places });
  assert.deepEqual(tracks.trackOf('a', JSON.parse(text), degrees).fixes, way.map(({ place, height_m, time_s }) => ({ place, height_m, time_s })));
  const kml = ways.tourKml({ name: 'A & <B>', seconds: 12, waypoints: places, way, crs: '' }, [0, 12]);
  assert.match(kml, /<name>A &amp; &lt;B><\/name>/);
  assert.match(kml, /<heading>350<\/heading><tilt>80<\/tilt>/);
  assert.equal(ways.tourIn({ features: [] }), null);
  for (const waypoints of [[{ at: [8, 46, 'x'] }, null], [], 'x'])
    assert.throws(() => ways.tourIn({ features: [{ properties: { foreland_tour: { seconds: 12, waypoints } } }] }) ?? assert.fail('none'), Error);
});
