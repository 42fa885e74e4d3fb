// Our own client in a three scene, with ground alone: no relief, no imagery.
import * as THREE from 'three';
import { Terrain } from '@foreland/client';
import { ForelandTerrain } from '@foreland/client/three';
import { MeshJournal } from './mesh_journal.mjs';

export async function open({ plan, ground, lens, size, quality, server, predictor }) {
  const renderer = new THREE.WebGLRenderer();
  renderer.setPixelRatio(1);
  renderer.setSize(size.width, size.height);
  document.body.append(renderer.domElement);
  const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera((lens.fov_rad * 180) / Math.PI, size.width / size.height);
  scene.add(new THREE.HemisphereLight());
  const tolerance_px = (quality * size.height) / lens.height_px; // the canvas is so much smaller than the lens
  const updates = [], wasm = await WebAssembly.compileStreaming(fetch('/client/foreland.wasm'));
  const held = { version: 0, arrays: {}, origin: null, next: 0 };
  const journal = new MeshJournal();
  let terrain = null, drawn = null, frame = null, card = null, begun_ms = 0;
  return {
    async begin() {
      terrain = await Terrain.open(server, { tolerancePx: tolerance_px, predictor, wasm, worker: new URL('timed_worker.mjs', import.meta.url), keyframeMs: plan.keyframe_ms, relief: false, imagery: false, lens: { fovY: lens.fov_rad, ...size } });
      const attach = terrain.attach.bind(terrain);
      // What is drawn is kept, to be judged afterwards.
      const add = (update) => (journal.add(update, performance.now()), updates.push(update), card.add(update));
      terrain.attach = (sink) => attach(new Proxy((card = sink), { get: (to, name) => (name === 'add' ? add : typeof to[name] === 'function' ? to[name].bind(to) : to[name]) }));
      drawn = new ForelandTerrain(terrain, { renderer });
      scene.add(drawn);
    },
    beginFlight(start) {
      begun_ms = start;
      if (predictor === 'path') terrain.announcePath(plan.poses, { start, stepMs: 1000 / plan.poses_per_s });
    },
    show({ eye, orientation }, now) {
      if (!drawn) return;
      const begun = performance.now();
      drawn.poseCamera(camera, { eye, orientation });
      Object.assign(camera, drawn.depthRange(eye));
      camera.updateProjectionMatrix();
      camera.updateMatrixWorld();
      frame = drawn.update(camera, now);
      renderer.render(scene, camera);
      const over = performance.now();
      journal.frame(card.ready, frame, over, over - begun);
    },
    jump: () => terrain.jump(),
    isComplete: () => frame !== null && frame.guaranteedPx !== null && frame.guaranteedPx <= 1.001 * tolerance_px,
    snapshot: () => ({ version: frame.version, weight: frame.weight, guaranteed_px: frame.guaranteedPx }),
    reportSince: (time) => journal.reportSince(time),
    report: (shown) => ({ stages: journal.report(begun_ms), outside_share: shown.filter(({ snapshot }) => snapshot.guaranteed_px === null).length / shown.length }),
    meshesOf,
  };

  function meshesOf({ version, weight }, index) {
    const mesh = meshOf(version);
    if (!mesh) return [];
    const { from_position: from, to_position: to, texture_coordinate: lattice, index: indices } = mesh.arrays;
    const count = from.length / 4, [places, points] = [new Float64Array(2 * count), new Float64Array(3 * count)];
    for (let v = 0; v < count; ++v) {
      for (let i = 0; i < 3; ++i) points[3 * v + i] = from[4 * v + i] * (1 - weight) + to[4 * v + i] * weight + mesh.origin[i];
      places[2 * v] = ground.west + lattice[2 * v] * ground.dx;
      places[2 * v + 1] = ground.south + lattice[2 * v + 1] * ground.dy;
    }
    return [index({ places, scene: points, indices })];
  }

  // Snapshots are asked for in the order in which they were taken, or the one before again.
  function meshOf(version) {
    while (held.version < version && held.next < updates.length) {
      const update = updates[held.next++];
      for (const [name, { size: length, ranges, data }] of Object.entries(update.terrain.channels)) {
        if (!['from_position', 'to_position', 'texture_coordinate', 'index'].includes(name)) continue;
        const array = new data.constructor(length);
        if (!update.terrain.is_whole) array.set(held.arrays[name].subarray(0, length));
        for (let i = 0, at = 0; i < ranges.length; at += ranges[i + 1] - ranges[i], i += 2) array.set(data.subarray(at, at + ranges[i + 1] - ranges[i]), ranges[i]);
        held.arrays[name] = array;
      }
      held.version = update.version, held.origin = update.origin;
    }
    return held.version === version ? held : null;
  }
}
