// What the server is asked for where two eyes of a head see a picture each: one view from the middle between them, which sees all that they
// see, with as many pixels for an angle as the finer one has. Keyframes' regions are wider by how far the eyes are from the middle
// (TerrainOptions.eyeRadius), so what is guaranteed of the one view holds for each eye. Pure.
import type { Pose } from '@foreland/client';
import * as THREE from 'three';
import { growth } from './exaggeration';

export interface Eye {
  position: THREE.Vector3; // in the scene's axes
  turn: THREE.Quaternion;
  projection: THREE.Matrix4; // its frustum need not be symmetric
  width_px: number;
  height_px: number;
}

// What is asked for, but for the pose.
export interface HeadLens {
  eye_radius_m: number; // how far the eyes are from the middle
  tan_x: number; // of half the angles that are seen from there
  tan_y: number;
  focal_px: number; // pixels per unit of tangent, in the eye that has the most
  growth: number; // how much longer a small step is in an eye's picture than in the middle's, both in tangents: 1 where they look the same way
}

const kSteps = 5; // at which an eye's picture is looked at, each way
const kMost = 8; // of tangents: a lens of nearly half a turn

export function headView(eyes: readonly Eye[]): { pose: Pose; lens: HeadLens } {
  const middle = eyes.reduce((sum, { position }) => sum.add(position), new THREE.Vector3()).divideScalar(eyes.length);
  const turn = eyes[0]!.turn.clone().slerp(eyes[eyes.length - 1]!.turn, 0.5), pose = poseOf(middle, turn);
  const lens: HeadLens = { eye_radius_m: 0, tan_x: 0, tan_y: 0, focal_px: 0, growth: 1 };
  for (const eye of eyes) {
    const { elements } = eye.projection, own = poseOf(eye.position, eye.turn), to_middle = turn.clone().invert().multiply(eye.turn);
    lens.eye_radius_m = Math.max(lens.eye_radius_m, middle.distanceTo(eye.position));
    lens.focal_px = Math.max(lens.focal_px, (eye.width_px * elements[0]!) / 2, (eye.height_px * elements[5]!) / 2);
    for (let i = 0; i < kSteps; ++i)
      for (let j = 0; j < kSteps; ++j) {
        const [u, v] = [i, j].map((k) => (2 * k) / (kSteps - 1) - 1) as [number, number];
        const way = new THREE.Vector3((u + elements[8]!) / elements[0]!, (v + elements[9]!) / elements[5]!, -1).applyQuaternion(to_middle);
        const [x, y] = [way.x / Math.max(-way.z, 1e-3), way.y / Math.max(-way.z, 1e-3)];
        [lens.tan_x, lens.tan_y] = [Math.min(Math.max(lens.tan_x, Math.abs(x)), kMost), Math.min(Math.max(lens.tan_y, Math.abs(y)), kMost)];
        lens.growth = Math.max(lens.growth, growth(own, pose, [x, y], 1));
      }
  }
  return { pose, lens };
}

function poseOf(position: THREE.Vector3, turn: THREE.Quaternion): Pose {
  return { eye: position.toArray(), orientation: [turn.x, turn.y, turn.z, turn.w] };
}

const kRoom = 1.01, kLoose = 1.05; // of each number of a lens that is asked for
const kParts = ['eye_radius_m', 'tan_x', 'tan_y', 'focal_px', 'growth'] as const;

// With some room, so that it serves again where a device tells its eyes a little differently.
export function withRoom(lens: HeadLens): HeadLens {
  return Object.fromEntries(kParts.map((part) => [part, kRoom * lens[part]])) as unknown as HeadLens;
}
// Whether what is asked for serves what is seen, and is not much too large for it.
export function serves(asked: HeadLens, seen: HeadLens): boolean {
  return kParts.every((part) => seen[part] <= asked[part] && asked[part] <= kLoose * seen[part]);
}
