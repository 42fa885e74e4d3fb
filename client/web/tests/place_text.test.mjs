// Places and views as text, and the sun over a globe.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import * as THREE from 'three';
import { openSources } from './support.mjs';

let sources, text, position, sun;
before(async () => {
  sources = await openSources();
  [text, position, sun] = await Promise.all([sources.load('globe/place_text.ts'), sources.load('globe/sun_position.ts'), sources.load('ui/sun.ts')]);
});
after(() => sources.close());

test('what the address says of a view is read again', () => {
  for (const [lat, lon, height, heading, pitch] of [[46.2712345, -8.0198765, 2200.25, 60, -3], [0, 0, 1, 0, -90], [-89.9999999, 179.9999999, 4e7, -179.9999, 89.5]]) {
    const read = text.readAt(text.atText({ lat, lon, height }, { heading: (heading * Math.PI) / 180, pitch: (pitch * Math.PI) / 180 }));
    assert.deepEqual(Object.values(read).map((v) => v.toFixed(4)), [lat, lon, height, heading, pitch].map((v) => v.toFixed(4)));
  }
  assert.equal(text.atText({ lat: 1, lon: 2, height: 3 }, { heading: 6 * Math.PI + 1, pitch: 0 }), '1,2,3,57.2958,0');
  assert.deepEqual(text.readAt('46.5,8'), { lat: 46.5, lon: 8 });
  for (const wrong of [null, '', '46', '46,', 'a,b', '91,0', '0,0,0,0,91', '1,2,3,4,5,6', '1,,3']) assert.equal(text.readAt(wrong), null, wrong);
});

test('places are read as people write them', () => {
  for (const [written, lat, lon, height] of [
    ['46.5, 8.25', 46.5, 8.25], ['46.5 8.25', 46.5, 8.25], ['46\u00b030\u2032N 8\u00b015\u2032E', 46.5, 8.25], ['8.25E, 46.5N', 46.5, 8.25], ['33.5S;70.25W', -33.5, -70.25], ['46.5N 8.25E 4000', 46.5, 8.25, 4000], ['46.5N8.25E', 46.5, 8.25],
  ]) {
    const found = text.placeOf(written);
    assert.ok(Math.abs(found.lat - lat) < 1e-9 && Math.abs(found.lon - lon) < 1e-9 && found.height === height, `${written}: ${JSON.stringify(found)}`);
  }
  for (const wrong of ['', 'Zermatt', '46', '95N 8E', '46.5 8.25 high', '1 2 3 4']) assert.throws(() => text.placeOf(wrong), Error, wrong);
});

test('the sun stands where an almanac has it', () => {
  const deg = Math.PI / 180, at = (date) => position.sunOverEarth(...Object.values(position.clockOf(new Date(date))), new Date(date).getUTCFullYear());
  // At the equinox and the solstices of 2024: hour angle at Greenwich, of mean time and the equation of time, and declination; degrees.
  for (const [date, hour_angle, declination] of [['2024-03-20T03:06Z', 224.63, 0], ['2024-06-20T20:51Z', 132.3, 23.44], ['2024-12-21T09:21Z', 320.7, -23.44]]) {
    const wanted = new THREE.Vector3(Math.cos(declination * deg) * Math.cos(-hour_angle * deg), Math.cos(declination * deg) * Math.sin(-hour_angle * deg), Math.sin(declination * deg));
    const off = new THREE.Vector3(...at(date)).angleTo(wanted) / deg;
    assert.ok(off < 0.3, `${date}: ${off} degrees off`);
  }
});

test('light as on maps comes from the north-west of the camera, wherever that is', () => {
  const up = new THREE.Vector3(0.5, 0.3, 0.4).normalize(), light = new THREE.Vector3(...sun.sunOverGlobe({ sun: 'map' }, up));
  const east = new THREE.Vector3(0, 0, 1).cross(up).normalize(), north = up.clone().cross(east);
  assert.ok(Math.abs(light.length() - 1) < 1e-9 && light.dot(up) > 0.5 && light.dot(north) > 0.5 && light.dot(east) < -0.5);
});
