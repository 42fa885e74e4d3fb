// How a camera moves over a globe: it holds a point of the ground under the pointer, nears it, tilts about it and flies level. Everywhere up is
// the ellipsoid's normal, and the camera never leans to a side. Pure; positions from the body's middle, metres.
import * as THREE from 'three';
import { forwardOf, kAxis, levelLook, turnOf, type Look } from './camera';

export interface Body {
  up(point: THREE.Vector3): THREE.Vector3; // the ellipsoid's normal
  height(point: THREE.Vector3): number; // above it, or another surface whose distance from it hardly changes
}

export interface View {
  eye: THREE.Vector3;
  look: Look;
}

const kRepeats = 4; // of what is exact but for the leaning that is taken away
const kSteepest_rad = 0.03; // above the horizon of the point that is tilted about

const turnIn = ({ eye, look }: View, body: Body, pole = kAxis) => turnOf(look, body.up(eye), pole);

function atHeight(body: Body, point: THREE.Vector3, height_m: number): THREE.Vector3 {
  return point.clone().addScaledVector(body.up(point), height_m - body.height(point));
}

// Where a ray first meets a ball about the middle, or leaves it from inside; of one that passes, the place of the ball that it comes nearest to.
export function onBall(eye: THREE.Vector3, direction: THREE.Vector3, radius_m: number): THREE.Vector3 {
  const along_m = eye.dot(direction), inside = along_m * along_m - eye.lengthSq() + radius_m * radius_m;
  const reach_m = Math.sqrt(Math.max(inside, 0)), first_m = -along_m - reach_m;
  const way_m = inside < 0 ? Math.max(-along_m, 0) : first_m > 0 ? first_m : Math.max(reach_m - along_m, 0);
  return eye.clone().addScaledVector(direction, way_m).setLength(radius_m);
}

// About the middle, at the same height.
function turned(view: View, body: Body, by: THREE.Quaternion): View {
  const eye = atHeight(body, view.eye.clone().applyQuaternion(by), body.height(view.eye));
  return { eye, look: levelLook(turnIn(view, body).premultiply(by), body.up(eye), kAxis) };
}

// Turns the globe below the camera until a point lies where the pointer is, whose direction has the camera's axes.
export function hold(view: View, body: Body, point: THREE.Vector3, pointer: THREE.Vector3): View {
  const wanted = point.clone().normalize();
  for (let i = 0; i < kRepeats; ++i) {
    const there = onBall(view.eye, pointer.clone().applyQuaternion(turnIn(view, body)), point.length()).normalize();
    if (there.distanceToSquared(wanted) < 1e-30) break;
    view = turned(view, body, new THREE.Quaternion().setFromUnitVectors(there, wanted));
  }
  return view;
}

// Changes the distance from a point, which stays under the pointer.
export function near(view: View, body: Body, point: THREE.Vector3, pointer: THREE.Vector3, factor: number): View {
  const eye = point.clone().addScaledVector(view.eye.clone().sub(point), factor);
  return hold({ eye, look: view.look }, body, point, pointer);
}

// Rises or sinks, straight up.
export function rise(view: View, body: Body, height_m: number): View {
  return { eye: atHeight(body, view.eye, height_m), look: view.look };
}

// Walks around a point, and over it; on maps, too, which have another pole.
export function tilt(view: View, body: Body, point: THREE.Vector3, around_rad: number, over_rad: number, pole = kAxis): View {
  const up = body.up(point), arm = view.eye.clone().sub(point), before = turnIn(view, body, pole);
  const around = new THREE.Quaternion().setFromAxisAngle(up, around_rad);
  const right = new THREE.Vector3(1, 0, 0).applyQuaternion(before).applyQuaternion(around);
  const elevation_rad = Math.asin(Math.min(arm.clone().normalize().dot(up), 1));
  const over = Math.max(Math.min(over_rad, Math.max(Math.PI / 2 - elevation_rad, 0)), Math.min(kSteepest_rad - elevation_rad, 0));
  const all = new THREE.Quaternion().setFromAxisAngle(right, -over).multiply(around);
  const eye = point.clone().add(arm.applyQuaternion(all));
  return { eye, look: levelLook(before.premultiply(all), body.up(eye), pole) };
}

// To the right, along the view and straight up. What is level of that keeps its height, and the way ahead stays straight, over a pole, too.
export function fly(view: View, body: Body, right_m: number, ahead_m: number, up_m: number): View {
  const up = body.up(view.eye), turn = turnIn(view, body);
  const way = forwardOf(view.look, up, kAxis).multiplyScalar(ahead_m).addScaledVector(new THREE.Vector3(1, 0, 0).applyQuaternion(turn), right_m);
  const rise_m = way.dot(up), level_m = way.addScaledVector(up, -rise_m).length(), height_m = body.height(view.eye) + rise_m + up_m;
  let turned_way = new THREE.Quaternion();
  if (level_m > 0) turned_way = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3().crossVectors(view.eye, way).normalize(), level_m / view.eye.length());
  const eye = atHeight(body, view.eye.clone().applyQuaternion(turned_way), height_m), now = body.up(eye);
  return { eye, look: levelLook(turn.premultiply(new THREE.Quaternion().setFromUnitVectors(up, now)), now, kAxis) };
}
