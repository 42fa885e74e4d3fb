// Flies over a served scene without a screen, and says what came: node node-flight.mjs ws://127.0.0.1:8080/ [SECONDS]
import { Terrain } from '@foreland/client';

const [server = 'ws://127.0.0.1:8080/', seconds = '5'] = process.argv.slice(2);
const terrain = await Terrain.open(server, { lens: { fovY: 0.96, width: 1280, height: 720 } });
terrain.on('error', (error) => console.error(error.message, error.advice));

const { title, bounds: { low, high } } = terrain.scene;
const [begin, end] = [performance.now(), performance.now() + 1000 * Number(seconds)];
const poseAt = (now) => {
  const share = (now - begin) / (end - begin);
  const x = low[0] + (0.3 + 0.4 * share) * (high[0] - low[0]);
  return { eye: [x, 0.5 * (low[1] + high[1]), high[2] + 500], orientation: [Math.SQRT1_2, 0, 0, Math.SQRT1_2] }; // north, level
};

// What the server knows it need not foresee.
const step_ms = 100;
terrain.announcePath(Array.from({ length: Number(seconds) * 10 + 1 }, (_, i) => poseAt(begin + i * step_ms)), { start: begin, stepMs: step_ms });
let [frames, guaranteed, worst] = [0, 0, 0];
for (let now = begin; now < end; now = performance.now()) {
  const frame = terrain.frame(now, poseAt(now));
  ++frames;
  if (frame.guaranteedPx !== null) ++guaranteed;
  worst = Math.max(worst, frame.guaranteedPx ?? 0);
  await new Promise((done) => setTimeout(done, 16));
}
const { keyframes, late_keyframes: late, bytes_down: bytes } = terrain.stats;
console.log(`${title}: ${frames} frames, ${guaranteed} of them within ${worst} px; ${keyframes} keyframes, ${late} late; ${bytes} bytes`);
await terrain.close();
