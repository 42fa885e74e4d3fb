// Headings and orientations. The camera looks along its -z with y up; the scene's z is up at its origin, and `up` is away
// from the zero surface wherever the eye is.
import * as THREE from 'three';
import type { Pose } from '@foreland/client';

export interface Look {
  heading: number; // radians, clockwise from north (the scene's y)
  pitch: number; // radians, positive looks up
}

// East, north and up at the eye, as columns.
export function basisAt(up: THREE.Vector3): [THREE.Vector3, THREE.Vector3, THREE.Vector3] {
  const north = new THREE.Vector3(0, 1, 0).addScaledVector(up, -up.y).normalize();
  return [new THREE.Vector3().crossVectors(north, up), north, up];
}

export function forwardOf(look: Look, up: THREE.Vector3): THREE.Vector3 {
  const [east, north] = basisAt(up);
  const level = Math.cos(look.pitch);
  return new THREE.Vector3()
    .addScaledVector(east, Math.sin(look.heading) * level)
    .addScaledVector(north, Math.cos(look.heading) * level)
    .addScaledVector(up, Math.sin(look.pitch));
}

export function orientationOf(look: Look, up: THREE.Vector3): Pose['orientation'] {
  const forward = forwardOf(look, up);
  const [east, north] = basisAt(up);
  const right = new THREE.Vector3()
    .addScaledVector(east, Math.cos(look.heading))
    .addScaledVector(north, -Math.sin(look.heading));
  const matrix = new THREE.Matrix4().makeBasis(right, new THREE.Vector3().crossVectors(right, forward), forward.negate());
  const q = new THREE.Quaternion().setFromRotationMatrix(matrix);
  return [q.x, q.y, q.z, q.w];
}

export function lookOf(orientation: readonly number[], up: THREE.Vector3): Look {
  const [east, north] = basisAt(up);
  const forward = new THREE.Vector3(0, 0, -1).applyQuaternion(new THREE.Quaternion().fromArray(orientation));
  const heading = Math.atan2(forward.dot(east), forward.dot(north));
  return { heading, pitch: Math.asin(Math.min(Math.max(forward.dot(up), -1), 1)) };
}
