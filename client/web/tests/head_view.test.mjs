// What is asked of a server for two eyes, against eyes and points drawn at random.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import * as THREE from 'three';
import { openSources } from './support.mjs';

let sources, made;
before(async () => {
  sources = await openSources();
  made = await sources.load('draw/head_view.ts');
});
after(() => sources?.close());

const seed = Number(process.env.SEED ?? Date.now() % 1e9);
let state = seed;
const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
const between = (low, high) => low + (high - low) * random();
const turn = (most) => new THREE.Quaternion().setFromEuler(new THREE.Euler(...[0, 1, 2].map(() => between(-most, most))));

// Two eyes whose frusta are larger outwards, each turned out by `canted` at most.
function headOf(canted) {
  const head = turn(3), at = new THREE.Vector3(between(-1e5, 1e5), between(-1e5, 1e5), between(0, 3000)), apart = between(0.05, 0.08);
  return [-1, 1].map((side) => {
    const [inner, outer, top, bottom] = [between(0.6, 0.9), between(1, 1.4), between(0.9, 1.2), between(0.9, 1.2)], near = 0.1;
    const [left, right] = (side < 0 ? [-outer, inner] : [-inner, outer]).map((tan) => tan * near);
    return {
      position: at.clone().add(new THREE.Vector3((side * apart) / 2, 0, 0).applyQuaternion(head)), turn: head.clone().multiply(turn(canted)),
      projection: new THREE.Matrix4().makePerspective(left, right, top * near, -bottom * near, near, 1e5), width_px: 1600, height_px: 1700,
    };
  });
}
const seenFrom = (turned, way) => way.clone().applyQuaternion(turned.clone().invert());
const pixelOf = ({ turn: turned, projection, width_px, height_px }, way) => {
  const at = seenFrom(turned, way).applyMatrix4(projection);
  return [(at.x * width_px) / 2, (at.y * height_px) / 2];
};

test('the view in the middle sees what each eye sees, and its pixels bound theirs', () => {
  console.log(`seed ${seed}`);
  for (const canted of [0, 0.1])
    for (let i = 0; i < 40; ++i) {
      const eyes = headOf(canted), { pose, lens } = made.headView(eyes), middle = new THREE.Quaternion(...pose.orientation);
      assert.ok(canted > 0 || Math.abs(lens.growth - 1) < 1e-6, `${lens.growth}`);
      for (const eye of eyes) {
        assert.ok(new THREE.Vector3(...pose.eye).distanceTo(eye.position) <= lens.eye_radius_m + 1e-9);
        const inverse = eye.projection.clone().invert();
        for (let k = 0; k < 50; ++k) {
          // A direction within the eye's picture, and one that is off by a little, any way, as the error of a point.
          const way = new THREE.Vector3(between(-1, 1), between(-1, 1), 0).applyMatrix4(inverse).normalize().applyQuaternion(eye.turn);
          const seen = seenFrom(middle, way), [x, y] = [seen.x / -seen.z, seen.y / -seen.z];
          assert.ok(seen.z < 0 && Math.abs(x) <= lens.tan_x * (1 + 1e-6) && Math.abs(y) <= lens.tan_y * (1 + 1e-6), `${[x, y]} is outside of ${[lens.tan_x, lens.tan_y]}`);
          const off = way.clone().add(new THREE.Vector3(...[0, 1, 2].map(() => between(-1e-5, 1e-5)))), off_seen = seenFrom(middle, off);
          const asked_px = lens.focal_px * Math.hypot(off_seen.x / -off_seen.z - x, off_seen.y / -off_seen.z - y);
          const [a, b] = [pixelOf(eye, way), pixelOf(eye, off)], drawn_px = Math.hypot(a[0] - b[0], a[1] - b[1]);
          assert.ok(drawn_px <= lens.growth * asked_px * 1.02 + 1e-6, `${drawn_px} px of ${lens.growth} times ${asked_px}`);
        }
      }
    }
});

test('a view serves again for eyes that are told a little differently, and not for others', () => {
  const { lens } = made.headView(headOf(0)), asked = made.withRoom(lens);
  assert.ok(made.serves(asked, lens) && made.serves(asked, { ...lens, tan_x: 0.99 * lens.tan_x }));
  for (const part of ['eye_radius_m', 'tan_x', 'tan_y', 'focal_px', 'growth'])
    for (const factor of [0.9, 1.1]) assert.ok(!made.serves(asked, { ...lens, [part]: factor * lens[part] }), `${factor} times ${part}`);
});
