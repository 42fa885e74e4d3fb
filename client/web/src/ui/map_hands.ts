// What two fingers do over a map: pinching nears what lies between them, twisting turns about it, moving both up or down tilts about it, and
// moving both sideways carries it along. Where there is only sky between them, they turn the view.
import * as THREE from 'three';
import { basisAt, kMapNorth, turned } from './camera';
import { kTilt_rad, type Seen } from './globe_hands';
import { tilt, type Body, type View } from './globe_moves';
import { motionOf, pinchOf, type Finger, type Pinch } from './pinch';
import { kLens } from './settings';

const kNearest = 4; // clearances, from which nothing is neared

// What of the camera it moves.
export interface MapView extends View {
  clearance_m: number; // above the ground
}

export class MapHands {
  private point: THREE.Vector3 | null = null; // that lies between the fingers
  private pinch: Pinch = { apart: 1, angle: 0, middle: [0, 0] };

  constructor(private readonly view: MapView, private readonly body: Body, private readonly seen: Pick<Seen, 'ground' | 'size'>) {}

  pinchFrom(a: Finger, b: Finger): void {
    this.pinch = pinchOf(a, b);
    this.point = this.seen.ground(...this.pinch.middle);
  }
  pinchTo(a: Finger, b: Finger): void {
    const { view, body, point } = this, now = pinchOf(a, b), { factor: wanted, twist, right_px, down_px } = motionOf(this.pinch, now), { height } = this.seen.size();
    this.pinch = now;
    const over_rad = (down_px * kTilt_rad) / height;
    if (!point) {
      view.look = turned(view.look, -twist, -over_rad);
      return;
    }
    const { eye, look } = tilt(view, body, point, twist, over_rad, kMapNorth), away = eye.clone().sub(point);
    const factor = Math.max(wanted, Math.min((kNearest * view.clearance_m) / away.length(), 1));
    view.eye.copy(point).addScaledVector(away, factor);
    view.look = look;
    const pixel_m = (2 * Math.tan(kLens.fov_rad / 2) * factor * away.length()) / height, [east, north] = basisAt(body.up(view.eye), kMapNorth);
    view.eye.addScaledVector(east, -Math.cos(look.heading) * right_px * pixel_m).addScaledVector(north, Math.sin(look.heading) * right_px * pixel_m);
  }
}
