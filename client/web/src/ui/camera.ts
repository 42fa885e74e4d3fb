// Headings and orientations. The camera looks along its -z with y up; `up` is away from the zero surface wherever the eye is, and north is
// what of the pole's direction is level there: the scene's y on maps and about an origin, the axis of a globe.
import * as THREE from 'three';
import type { Pose } from '@foreland/client';

export interface Look {
  heading: number; // radians, clockwise from north
  pitch: number; // radians, positive looks up
}

export const kMapNorth = new THREE.Vector3(0, 1, 0), kAxis = new THREE.Vector3(0, 0, 1);

const kHighest_rad = 1.54; // that is looked up

// Straight down at most, and not quite straight up.
export function turned({ heading, pitch }: Look, right_rad: number, up_rad: number): Look {
  return { heading: heading + right_rad, pitch: Math.min(Math.max(pitch + up_rad, -Math.PI / 2), kHighest_rad) };
}

// East, north and up at the eye, as columns. On a pole, where all ways lead from it, as on the meridian of longitude 0.
export function basisAt(up: THREE.Vector3, pole: THREE.Vector3): [THREE.Vector3, THREE.Vector3, THREE.Vector3] {
  const north = pole.clone().addScaledVector(up, -up.dot(pole));
  if (north.lengthSq() < 1e-24) north.set(-Math.sign(up.z), 0, 0);
  north.normalize();
  return [new THREE.Vector3().crossVectors(north, up), north, up];
}

export function forwardOf(look: Look, up: THREE.Vector3, pole: THREE.Vector3): THREE.Vector3 {
  const [east, north] = basisAt(up, pole);
  const level = Math.cos(look.pitch);
  return new THREE.Vector3()
    .addScaledVector(east, Math.sin(look.heading) * level)
    .addScaledVector(north, Math.cos(look.heading) * level)
    .addScaledVector(up, Math.sin(look.pitch));
}

export function turnOf(look: Look, up: THREE.Vector3, pole: THREE.Vector3): THREE.Quaternion {
  const forward = forwardOf(look, up, pole);
  const [east, north] = basisAt(up, pole);
  const right = new THREE.Vector3()
    .addScaledVector(east, Math.cos(look.heading))
    .addScaledVector(north, -Math.sin(look.heading));
  const matrix = new THREE.Matrix4().makeBasis(right, new THREE.Vector3().crossVectors(right, forward), forward.negate());
  return new THREE.Quaternion().setFromRotationMatrix(matrix);
}
export function orientationOf(look: Look, up: THREE.Vector3, pole: THREE.Vector3): Pose['orientation'] {
  const q = turnOf(look, up, pole);
  return [q.x, q.y, q.z, q.w];
}

export function lookOf(orientation: readonly number[], up: THREE.Vector3, pole: THREE.Vector3): Look {
  const [east, north] = basisAt(up, pole);
  const forward = new THREE.Vector3(0, 0, -1).applyQuaternion(new THREE.Quaternion().fromArray(orientation));
  const heading = Math.atan2(forward.dot(east), forward.dot(north));
  return { heading, pitch: Math.asin(Math.min(Math.max(forward.dot(up), -1), 1)) };
}

// The same without what leans to a side, by the camera's right, which tells the heading of one that looks straight down, too.
export function levelLook(turn: THREE.Quaternion, up: THREE.Vector3, pole: THREE.Vector3): Look {
  const [east, north] = basisAt(up, pole);
  const right = new THREE.Vector3(1, 0, 0).applyQuaternion(turn), forward = new THREE.Vector3(0, 0, -1).applyQuaternion(turn);
  return { heading: Math.atan2(-right.dot(north), right.dot(east)), pitch: Math.asin(Math.min(Math.max(forward.dot(up), -1), 1)) };
}
