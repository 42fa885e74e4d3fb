// Taller heights: what the server is asked for contains what is drawn, and bounds its error.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openSources } from './support.mjs';

let sources, made;
before(async () => {
  sources = await openSources();
  made = await sources.load('draw/exaggeration.ts');
});
after(() => sources?.close());

const kFov_rad = (55 * Math.PI) / 180, kFactors = [0.5, 0.8, 1, 1.5, 2, 3, 5];
const seed = Number(process.env.SEED ?? Date.now() % 1e9);
let state = seed || 1;
const random = () => ((state = (state * 48271) % 2147483647) / 2147483647);
const between = (low, high) => low + (high - low) * random();

const product = ([ax, ay, az, aw], [bx, by, bz, bw]) => [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz];
const turned = ([x, y, z, w], v) => product(product([x, y, z, w], [...v, 0]), [-x, -y, -z, w]).slice(0, 3);
const headed = (heading, pitch) => product([0, 0, Math.sin(heading / 2), Math.cos(heading / 2)], [Math.sin(Math.PI / 4 + pitch / 2), 0, 0, Math.cos(Math.PI / 4 + pitch / 2)]);
const randomPose = () => ({ eye: [1, 2, 3], orientation: headed(between(-3, 3), between(-Math.PI / 2, Math.PI / 2)) });
const seenFrom = ({ orientation: [x, y, z, w] }, v) => turned([-x, -y, -z, w], v); // in the camera's axes
const tall = ([x, y, z], factor) => [x, y, factor * z];

test('a pose that is told and drawn again is the same one', () => {
  console.log(`seed ${seed}`);
  for (let i = 0; i < 1000; ++i) {
    const pose = randomPose(), factor = kFactors[i % kFactors.length];
    const again = made.shownPose(made.askedPose(pose, factor, kFov_rad), factor, kFov_rad);
    assert.ok(Math.abs(pose.orientation.reduce((sum, v, k) => sum + v * again.orientation[k], 0)) > 1 - 1e-9);
    assert.deepEqual(again.eye, pose.eye);
  }
});

test('the lens that is asked for sees all that is drawn, and its pixels bound those that are seen', () => {
  for (const factor of kFactors)
    for (const aspect of [0.5, 1, 16 / 9]) {
      const { tan_x, tan_y, finer } = made.askedLens(kFov_rad, aspect, factor), tall_0 = Math.tan(kFov_rad / 2);
      let most = 0;
      for (let i = 0; i < 3000; ++i) {
        const shown = randomPose(), asked = made.askedPose(shown, factor, kFov_rad);
        const drawn = turned(shown.orientation, [tall_0 * aspect * between(-1, 1), tall_0 * between(-1, 1), -1]), way = tall(drawn, 1 / factor);
        const [x, y, z] = seenFrom(asked, way);
        assert.ok(z < 0 && Math.abs(x / z) <= tan_x && Math.abs(y / z) <= tan_y, `${[x / z, y / z]} is outside of ${[tan_x, tan_y]} at ${factor}`);
        // A point that is off by a little, any way.
        const off = way.map((v) => v + 1e-5 * Math.hypot(...way) * between(-1, 1)), picture = ([px, py, pz]) => [px / -pz, py / -pz];
        const step = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
        const asked_step = step(picture([x, y, z]), picture(seenFrom(asked, off))), drawn_step = step(picture(seenFrom(shown, drawn)), picture(seenFrom(shown, tall(off, factor))));
        assert.ok(drawn_step <= finer * asked_step * 1.001 + 1e-12, `${drawn_step / asked_step} is more than ${finer} at ${factor}`);
        most = Math.max(most, drawn_step / asked_step);
      }
      assert.ok(factor === 1 || finer < 1.3 * most, `${finer} for ${most}`);
      assert.ok(tan_x < 8 && tan_y < 8, `${[tan_x, tan_y]} at ${factor}`);
    }
});
