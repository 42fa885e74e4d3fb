// A camera that follows a flight: poses in even steps of time, as a path is announced to the server. What the camera does in between is what
// the server makes of them (proto/space/path.h), so that it knows the camera's way exactly.
import type { Pose, Vector } from '@foreland/client';
import * as THREE from 'three';
import { basisAt, type UpAt } from './basis';
import { durationOf, pointAt, type Flight } from './flight';

export type Seat = 'chase' | 'cockpit';

export const kStep_ms = 100; // between poses, of the time in which the flight is shown
const kMaxPoses = 60_000; // of a camera's path
const kSteady_s = 1.2; // of the time in which it is shown: either side of the mean that the camera's place is
const kGaze_s = 0.3; // likewise, of where it looks
const kAhead_s = 2; // of the way that the direction is taken from
const kBehind_s = 2.2, kNearest_m = 60, kFarthest_m = 1500; // of the flight's way, from behind which it looks
const kAbove = 0.32; // of that distance
const kDownward_rad = 0.14; // of the view from the cockpit

export interface CameraPath {
  readonly poses: readonly Pose[];
  readonly step_s: number; // of the flight, between two of them
}

// `speed` is how many seconds of the flight are shown in a second.
export function stepOf(flight: Flight, speed: number): number {
  return Math.max((kStep_ms / 1000) * speed, durationOf(flight) / kMaxPoses);
}

// The eyes, and what they look at, before the ground is known.
export interface Course {
  readonly eyes: readonly Vector[];
  readonly targets: readonly Vector[];
  readonly step_s: number;
}

export function courseOf(flight: Flight, seat: Seat, speed: number, upAt: UpAt): Course {
  const step_s = stepOf(flight, speed), count = Math.max(Math.ceil(durationOf(flight) / step_s - 1e-9) + 1, 2);
  const exact = Array.from({ length: count }, (_, i) => pointAt(flight, i * step_s));
  const of_steps = (shown_s: number) => Math.round((shown_s * speed) / step_s);
  const steady = smoothed(exact, of_steps(kSteady_s)), gazed = smoothed(exact, of_steps(kGaze_s));
  const ahead = directions(steady, of_steps(kAhead_s), upAt);
  if (seat === 'cockpit') {
    const eyes = smoothed(exact, of_steps(kGaze_s));
    const down = Math.tan(kDownward_rad);
    return { eyes, step_s, targets: eyes.map((eye, i) => {
      const up = upAt(eye);
      return eye.map((v, k) => v + 100 * (ahead[i]![k]! - down * up[k]!)) as Vector;
    }) };
  }
  const behind_m = Math.min(Math.max(kBehind_s * speed * usualSpeed(steady, step_s), kNearest_m), kFarthest_m);
  const eyes = steady.map((at, i) => {
    const up = upAt(at);
    return at.map((v, k) => v + behind_m * (kAbove * up[k]! - ahead[i]![k]!)) as Vector;
  });
  return { eyes, targets: gazed, step_s };
}

// Lifts each eye, and turns it to what it looks at, which is lifted as well in the cockpit.
export function posesOf({ eyes, targets, step_s }: Course, seat: Seat, lifts: readonly number[], upAt: UpAt): CameraPath {
  const poses = eyes.map((eye, i): Pose => {
    const up = upAt(eye), raised = (at: Vector) => at.map((v, k) => v + lifts[i]! * up[k]!) as Vector;
    return poseTowards(raised(eye), seat === 'cockpit' ? raised(targets[i]!) : targets[i]!, up);
  });
  return { poses, step_s };
}

// The largest value within `reach`, then the mean of those: smooth, and nowhere below what it is made of.
export function liftsOf(lifts: readonly number[], reach: number): number[] {
  const largest = lifts.map((_, i) => Math.max(...lifts.slice(Math.max(i - reach, 0), i + reach + 1)));
  const extended = (i: number) => largest[Math.min(Math.max(i, 0), largest.length - 1)]!;
  let sum = 0;
  for (let i = -reach; i <= reach; ++i) sum += extended(i);
  return largest.map((_, i) => {
    const mean = sum / (2 * reach + 1);
    sum += extended(i + reach + 1) - extended(i - reach);
    return Math.max(mean, lifts[i]!);
  });
}

// Values at each of `count` steps, of those at every `stride`-th of them.
export function spread(sparse: readonly number[], stride: number, count: number): number[] {
  return Array.from({ length: count }, (_, i) => {
    const at = Math.floor(i / stride), next = Math.min(at + 1, sparse.length - 1), share = i / stride - at;
    return sparse[at]! + share * (sparse[next]! - sparse[at]!);
  });
}

// The camera looks along its -z with y up.
export function poseTowards(eye: Vector, target: Vector, up: Vector): Pose {
  const matrix = new THREE.Matrix4().lookAt(new THREE.Vector3(...eye), new THREE.Vector3(...target), new THREE.Vector3(...up));
  const { x, y, z, w } = new THREE.Quaternion().setFromRotationMatrix(matrix);
  return { eye: [...eye], orientation: [x, y, z, w] };
}

// As Path::at (proto/space/path.cpp): Catmull-Rom through the eyes, slerp between the orientations.
export function poseOn({ poses, step_s }: CameraPath, time_s: number): Pose {
  const last = poses.length - 1, at = time_s / step_s, i = Math.floor(at);
  if (i < 0) return poses[0]!;
  if (i >= last) return poses[last]!;
  const u = at - i, [p0, p1, p2, p3] = [poses[Math.max(i - 1, 0)]!.eye, poses[i]!.eye, poses[i + 1]!.eye, poses[Math.min(i + 2, last)]!.eye];
  const eye = p1.map((v, k) => {
    const first = p2[k]! - p0[k]!, second = 2 * p0[k]! - 5 * v + 4 * p2[k]! - p3[k]!, third = 3 * (v - p2[k]!) + p3[k]! - p0[k]!;
    return v + 0.5 * u * (first + u * (second + u * third));
  }) as Vector;
  const turn = new THREE.Quaternion(...poses[i]!.orientation).slerp(new THREE.Quaternion(...poses[i + 1]!.orientation), u);
  return { eye, orientation: [turn.x, turn.y, turn.z, turn.w] };
}

// The mean of up to 2 `half` + 1 neighbours, taken twice; of fewer near the ends, so that the ends stay where they are.
export function smoothed(points: readonly Vector[], half: number): Vector[] {
  return meanOf(meanOf(points, half), half);
}
function meanOf(points: readonly Vector[], half: number): Vector[] {
  if (half < 1) return points.map((point) => [...point]);
  const first = points[0]!, sums: Vector[] = [[0, 0, 0]];
  for (const point of points) sums.push(point.map((v, k) => sums[sums.length - 1]![k]! + v - first[k]!) as Vector);
  return points.map((_, i) => {
    const h = Math.min(half, i, points.length - 1 - i);
    return [0, 1, 2].map((k) => first[k]! + (sums[i + h + 1]![k]! - sums[i - h]![k]!) / (2 * h + 1)) as Vector;
  });
}

// Level unit directions of the way; where it stands still, that of before.
function directions(points: readonly Vector[], ahead: number, upAt: UpAt): Vector[] {
  const last = points.length - 1;
  const out: (Vector | null)[] = [];
  let current: Vector | null = null;
  points.forEach((point, i) => {
    const up = upAt(point), from = points[Math.max(i - (ahead >> 1), 0)]!, to = points[Math.min(i + ahead, last)]!;
    const chord = to.map((v, k) => v - from[k]!), rise = chord.reduce((sum, v, k) => sum + v * up[k]!, 0);
    const level = chord.map((v, k) => v - rise * up[k]!), length = Math.hypot(...level);
    if (length > 1) current = level.map((v) => v / length) as Vector;
    out.push(current);
  });
  const first = out.find((direction) => direction !== null) ?? basisAt(points[0]!, upAt)[1];
  return smoothed(out.map((direction) => direction ?? first), ahead).map((direction) => {
    const length = Math.hypot(...direction);
    return (length > 1e-6 ? direction.map((v) => v / length) : first) as Vector;
  });
}

// In the middle of all speeds.
function usualSpeed(points: readonly Vector[], step_s: number): number {
  const speeds = points.slice(1).map((point, i) => Math.hypot(...point.map((v, k) => v - points[i]![k]!)) / step_s).sort((a, b) => a - b);
  return speeds[speeds.length >> 1] ?? 0;
}
