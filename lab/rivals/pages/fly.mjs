// Flies one viewer in this page, and lets the judge look at all that was drawn afterwards. Each pose is shown, none before its time, and
// until the next one is due each frame shows a pose between the two; a machine that is too slow for that flies slower (`slowed`), while
// the link keeps its pace. The processor that plays the graphics card draws one triangle of each mesh, for everybody: what the judge reads
// are the meshes.
import { earthOf } from '../earth.mjs';
import { groundOf } from '../ground.mjs';
import { cameraOf, compare, drawnBy, indexMesh } from '../judge.mjs';
import { poseBetween } from '../poses.mjs';

const frame = () => new Promise(requestAnimationFrame);
const kPatience_ms = 60_000, kCalm_ms = 500;

for (const name of ['drawElements', 'drawElementsInstanced', 'drawArrays', 'drawArraysInstanced']) {
  const draw = WebGL2RenderingContext.prototype[name], at = name.startsWith('drawElements') ? 1 : 2;
  WebGL2RenderingContext.prototype[name] = function (...args) { draw.apply(this, args.with(at, Math.min(args[at], 3))); };
}

// Shows a pose until the viewer has said for half a second that all is there. Milliseconds from `begun` to when it first did; null if
// that does not come.
async function settle(viewer, pose, begun) {
  for (let since = null; performance.now() - begun < kPatience_ms;) {
    await frame();
    const now = performance.now();
    viewer.show(pose, now);
    since = viewer.isComplete() ? since ?? now : null;
    if (since !== null && now - since > kCalm_ms) return since - begun;
  }
  return null;
}

async function flyPoses(viewer, poses, poses_per_s) {
  const shown = [], begun = performance.now(), step_ms = 1000 / poses_per_s;
  viewer.beginFlight?.(begun);
  for (let at = 0; at < poses.length;) {
    await frame();
    const step = Math.min((performance.now() - begun) / step_ms, at), is_due = step === at;
    viewer.show(is_due ? poses[at] : poseBetween(poses[at - 1], poses[at], step - (at - 1)), begun + step * step_ms);
    if (!is_due) continue;
    shown.push({ at, is_complete: viewer.isComplete(), snapshot: viewer.snapshot() });
    ++at;
  }
  return { shown, slowed: ((performance.now() - begun) * poses_per_s) / (1000 * (poses.length - 1)) };
}

// `points` of each pose; see measure.mjs.
function judge(viewer, shown, { poses, lens }, points) {
  const sum = { squares: 0, largest: 0, seen: 0, uncovered: 0, jump: 0, triangles: 0 }, settled = { largest: 0, jump: 0 };
  let before = null, was_complete = false;
  for (const { at, is_complete, snapshot } of shown) {
    const camera = cameraOf(poses[at], lens), meshes = viewer.meshesOf(snapshot, indexMesh);
    const drawn = new Map(points[at].map((point) => [point, drawnBy(meshes, point)]));
    const error = compare(camera, points[at], (point) => point.scene, (point) => drawn.get(point));
    sum.squares += error.squares, sum.seen += error.seen, sum.uncovered += error.uncovered;
    sum.largest = Math.max(sum.largest, error.largest);
    const jump = before ? compare(camera, points[at], (point) => drawnBy(before, point), (point) => drawn.get(point)).largest : 0;
    sum.jump = Math.max(sum.jump, jump);
    if (is_complete) settled.largest = Math.max(settled.largest, error.largest);
    if (is_complete && was_complete) settled.jump = Math.max(settled.jump, jump);
    sum.triangles += meshes.reduce((n, mesh) => n + mesh.triangles, 0);
    before = meshes, was_complete = is_complete;
  }
  return { rms_px: Math.sqrt(sum.squares / sum.seen), largest_px: sum.largest, jump_max_px: sum.jump, settled_largest_px: settled.largest, settled_jump_px: settled.jump, uncovered_share: sum.uncovered / (sum.seen + sum.uncovered), triangles: Math.round(sum.triangles / shown.length), judged_points: sum.seen };
}

globalThis.fly = async (name, plan, options, points) => {
  const { open } = await import(`./${name}.mjs`);
  const viewer = await open({ ...options, plan, earth: earthOf(plan.ground), ground: groundOf(plan.ground, null), lens: plan.lens });
  for (let i = 0; i < 5; ++i) await frame();
  await globalThis.mark('begun');
  const begun = performance.now();
  await viewer.begin(plan.poses[0]);
  const complete_ms = await settle(viewer, plan.poses[0], begun);
  await globalThis.mark('complete');
  const { shown, slowed } = await flyPoses(viewer, plan.poses, plan.poses_per_s);
  await globalThis.mark('flown');
  const more = viewer.report?.(shown); // of the flight
  const [goal] = [plan.poses[plan.jump_to]], jumped = performance.now();
  viewer.jump?.();
  const after_jump_ms = await settle(viewer, goal, jumped);
  await globalThis.mark('jumped');
  const after_jump = viewer.reportSince?.(jumped);
  const unsettled = shown.filter(({ is_complete }) => !is_complete).length / shown.length;
  return { complete_ms, after_jump_ms, slowed, unsettled_share: unsettled, ...more, after_jump, ...judge(viewer, shown, plan, points) };
};
globalThis.is_ready = true;
