// How a camera moves over a globe, without a browser: on a ball and on the earth's ellipsoid, for views drawn at random.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import * as THREE from 'three';
import { openSources } from './support.mjs';

const kSeed = Number(process.env.SEED ?? 47);
let sources, moves, camera;

before(async () => {
  sources = await openSources();
  [moves, camera] = await Promise.all([sources.load('ui/globe_moves.ts'), sources.load('ui/camera.ts')]);
});
after(() => sources.close());

// Mulberry32.
function random(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

const kRadius = 6378137;
const ball = { up: (p) => p.clone().normalize(), height: (p) => p.length() - kRadius };
// The nearest point of the ellipsoid by Newton's way along the normal.
function ellipsoid(a, b) {
  const place = (p) => {
    let t = 0;
    for (let i = 0; i < 60; ++i) {
      const [x, z] = [(a * Math.hypot(p.x, p.y)) / (t + a * a), (b * p.z) / (t + b * b)];
      t += (x * x + z * z - 1) / (2 * ((x * x) / (t + a * a) + (z * z) / (t + b * b)));
    }
    const foot = new THREE.Vector3((p.x * a * a) / (t + a * a), (p.y * a * a) / (t + a * a), (p.z * b * b) / (t + b * b));
    return { up: new THREE.Vector3(foot.x / (a * a), foot.y / (a * a), foot.z / (b * b)).normalize(), height: Math.sign(t) * foot.distanceTo(p) };
  };
  return { up: (p) => place(p).up, height: (p) => place(p).height };
}
const earth = ellipsoid(kRadius, 6356752.314245);
const bodies = [['a ball', ball, 1e-6], ['the earth', earth, 2e-3]];

const directionOf = (next) => new THREE.Vector3(next() - 0.5, next() - 0.5, next() - 0.5).normalize();
function viewOf(next, body, low = 3, high = 7.3) {
  const eye = directionOf(next).multiplyScalar(kRadius), height = 10 ** (low + (high - low) * next());
  eye.addScaledVector(body.up(eye), height - body.height(eye));
  return { eye, look: { heading: 6 * next() - 3, pitch: -0.3 - 1.27 * next() } };
}
const turnOf = (view, body) => camera.turnOf(view.look, body.up(view.eye), camera.kAxis);
// Where a point is seen, in the camera's axes.
const seen = (view, body, point) => point.clone().sub(view.eye).applyQuaternion(turnOf(view, body).invert()).normalize();
const pointerOf = (next) => new THREE.Vector3(0.6 * (next() - 0.5), 0.4 * (next() - 0.5), -1).normalize();
// Whether there is ground, not only grazed.
function isOnGround(view, body, pointer) {
  const down = view.eye.clone().negate(), angle = pointer.clone().applyQuaternion(turnOf(view, body)).angleTo(down);
  return angle < 0.9 * Math.asin((kRadius - 20e3) / view.eye.length());
}
const groundAt = (view, body, pointer) => moves.onBall(view.eye, pointer.clone().applyQuaternion(turnOf(view, body)), kRadius - 20e3);

for (const [name, body, slack] of bodies) {
  test(`on ${name} the ground that is held lies under the pointer, and the height stays (seed ${kSeed})`, () => {
    const next = random(kSeed);
    for (let i = 0; i < 300; ++i) {
      const view = viewOf(next, body, 4.5), [from, to] = [pointerOf(next), pointerOf(next)], point = groundAt(view, body, from);
      if (!isOnGround(view, body, from) || !isOnGround(view, body, to)) continue;
      const after = moves.hold(view, body, point, to);
      assert.ok(seen(after, body, point).angleTo(to) < slack, `${seen(after, body, point).angleTo(to)} radians off`);
      assert.ok(Math.abs(body.height(after.eye) - body.height(view.eye)) < 0.1);
    }
  });

  test(`on ${name} what is neared stays under the pointer (seed ${kSeed})`, () => {
    const next = random(kSeed + 1);
    let looked = 0;
    for (let i = 0; i < 300; ++i) {
      const view = viewOf(next, body, 4.5), pointer = pointerOf(next), point = groundAt(view, body, pointer);
      if (!isOnGround(view, body, pointer)) continue;
      const after = moves.near(view, body, point, pointer, 0.5 + next());
      if (!isOnGround(after, body, pointer)) continue; // from farther away it points to the sky
      assert.ok(seen(after, body, point).angleTo(pointer) < slack);
      ++looked;
    }
    assert.ok(looked > 50, `${looked}`);
  });

  test(`on ${name} tilting keeps the distance, the eye stays above, and nothing leans (seed ${kSeed})`, () => {
    const next = random(kSeed + 2);
    for (let i = 0; i < 300; ++i) {
      const view = viewOf(next, body, 3, 5.5), point = groundAt(view, body, new THREE.Vector3(0, 0, -1));
      const after = moves.tilt(view, body, point, 6 * next() - 3, 4 * next() - 2);
      assert.ok(Math.abs(after.eye.distanceTo(point) / view.eye.distanceTo(point) - 1) < 1e-9);
      assert.ok(after.eye.clone().sub(point).dot(body.up(point)) > 0);
      const right = new THREE.Vector3(1, 0, 0).applyQuaternion(turnOf(after, body));
      assert.ok(Math.abs(right.dot(body.up(after.eye))) < 1e-9);
    }
  });

  test(`on ${name} a way ahead is a great circle that keeps its height (seed ${kSeed})`, () => {
    const next = random(kSeed + 3);
    for (let i = 0; i < 60; ++i) {
      let view = viewOf(next, body, 3, 5.5);
      view.look.pitch = 0;
      const normal = view.eye.clone().cross(camera.forwardOf(view.look, body.up(view.eye), camera.kAxis)).normalize(), height = body.height(view.eye);
      for (let k = 0; k < 40; ++k) view = moves.fly(view, body, 0, 250e3, 0);
      assert.ok(Math.abs(body.height(view.eye) - height) < 0.5, `${body.height(view.eye) - height} m`);
      assert.ok(Math.abs(view.eye.clone().normalize().dot(normal)) < 0.02);
    }
  });

  test(`on ${name} a way over the pole goes on to the other side`, () => {
    const start = new THREE.Vector3(kRadius * 0.1, 0, kRadius);
    let view = { eye: start, look: { heading: 0, pitch: 0 } };
    for (let k = 0; k < 100; ++k) view = moves.fly(view, body, 0, 13e3, 0);
    assert.ok(view.eye.x < -0.09 * kRadius && Math.abs(view.eye.y) < 1, view.eye.toArray().join());
    assert.ok(Math.abs(Math.abs(view.look.heading) - Math.PI) < 1e-6, `heading ${view.look.heading}`);
  });
}

test('a look is found again in the orientation that it makes, straight down, too, and on a pole', () => {
  const next = random(kSeed + 4);
  for (let i = 0; i < 200; ++i) {
    const up = i < 2 ? new THREE.Vector3(0, 0, i === 0 ? 1 : -1) : directionOf(next), look = { heading: 6 * next() - 3, pitch: i % 3 === 0 ? -Math.PI / 2 : 3 * next() - 1.5 };
    const found = camera.levelLook(camera.turnOf(look, up, camera.kAxis), up, camera.kAxis);
    assert.ok(Math.abs(found.heading - look.heading) < 1e-6 && Math.abs(found.pitch - look.pitch) < 1e-6, JSON.stringify([look, found]));
  }
});
