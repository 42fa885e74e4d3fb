// What pointers do over a globe, as people know it: the ground is grabbed and dragged, the wheel and two fingers near what they point at, the
// other button, or Control or Shift with the first one, tilts about it. Beside the globe the view is turned. Two fingers twist and tilt, too.
import * as THREE from 'three';
import { turned, type Look } from './camera';
import { hold, near, rise, tilt, type Body, type View } from './globe_moves';
import { motionOf, pinchOf, type Finger, type Pinch } from './pinch';

// What is seen where.
export interface Seen {
  pointer(x: number, y: number): THREE.Vector3; // a unit direction in the camera's axes, of a point of the window
  ground(x: number, y: number): THREE.Vector3 | null; // the ground that is drawn there
  size(): { width: number; height: number }; // of the window
}

const kWheel = 0.0016; // of the logarithm of the distance
const kNearing_s = 0.09; // in which most of what the wheel asks is done
export const kTilt_rad = 3; // over the window's height
const kLook_rad = 1.6;
const kFarthest = 7; // heights, of the body's radius
const kRest_m = 4; // from which nothing is neared
const kUpright = [0.3, 2.5] as const; // between such heights, of the radius, a view that leaves becomes one straight down, north up

export class GlobeHands {
  private point: THREE.Vector3 | null = null; // that is held, or tilted about
  private does: 'drag' | 'tilt' | 'look' = 'look';
  private at: [number, number] = [0, 0];
  private nearing = 0; // the logarithm that the wheel still asks for
  private pinch: Pinch | null = null;

  constructor(private readonly view: { eye: THREE.Vector3; look: Look }, private readonly body: Body, private readonly seen: Seen, private readonly radius_m: number) {}

  press(x: number, y: number, tilts: boolean): void {
    this.nearing = 0;
    this.point = this.seen.ground(x, y);
    this.does = !this.point ? 'look' : tilts ? 'tilt' : 'drag';
    this.at = [x, y];
  }
  move(x: number, y: number): void {
    const [dx, dy] = [x - this.at[0], y - this.at[1]], { height } = this.seen.size();
    this.at = [x, y];
    if (this.does === 'look') return this.turn((-dx * kLook_rad) / height, (dy * kLook_rad) / height);
    if (this.does === 'tilt') return this.set(tilt(this.view, this.body, this.point!, (-dx * kTilt_rad) / height, (dy * kTilt_rad) / height));
    this.set(hold(this.view, this.body, this.point!, this.seen.pointer(x, y)));
  }

  // Two fingers.
  pinchFrom(a: Finger, b: Finger): void {
    this.pinch = pinchOf(a, b);
    this.nearing = 0;
    this.point = this.seen.ground(...this.pinch.middle);
  }
  pinchTo(a: Finger, b: Finger): void {
    const now = pinchOf(a, b), { factor, twist, right_px, down_px } = motionOf(this.pinch!, now), { point } = this, { height } = this.seen.size();
    this.pinch = now;
    if (!point) return this.turn((-right_px * kLook_rad) / height, 0);
    this.set(tilt(this.view, this.body, point, twist, (down_px * kTilt_rad) / height));
    this.nearBy(factor, this.seen.pointer(...now.middle));
  }

  // What is pointed at stays the same while the pointer does.
  wheel(x: number, y: number, delta: number): void {
    const has_moved = x !== this.at[0] || y !== this.at[1];
    if (has_moved || Math.abs(this.nearing) < 1e-3) this.point = this.seen.ground(x, y);
    this.at = [x, y];
    this.nearing += Math.min(Math.max(delta, -300), 300) * kWheel;
  }
  // With each frame. Whether it has moved the camera.
  step(seconds: number): boolean {
    if (this.nearing === 0) return false;
    const share = Math.abs(this.nearing) < 1e-3 ? 1 : 1 - Math.exp(-seconds / kNearing_s), by = share * this.nearing;
    this.nearing -= by;
    this.nearBy(Math.exp(by), this.seen.pointer(...this.at));
    return true;
  }
  // Ends what the wheel has begun.
  rest(): void {
    this.nearing = 0;
  }

  private nearBy(factor: number, pointer: THREE.Vector3): void {
    const { view, body, point } = this, height_m = body.height(view.eye), most_m = kFarthest * this.radius_m;
    if (factor > 1 && height_m * factor > most_m) factor = Math.max(most_m / height_m, 1);
    if (point && factor < 1 && point.distanceTo(view.eye) * factor < kRest_m) return;
    this.set(point ? near(view, body, point, pointer, factor) : rise(view, body, height_m * factor));
    if (factor > 1) this.upright(1 - 1 / factor);
  }
  private upright(share: number): void {
    const { view, body, radius_m } = this, t = (body.height(view.eye) / radius_m - kUpright[0]) / (kUpright[1] - kUpright[0]);
    const by = Math.min(Math.max(t, 0), 1) * Math.min(2.5 * share, 1), heading = Math.atan2(Math.sin(view.look.heading), Math.cos(view.look.heading));
    view.look = { heading: heading * (1 - by), pitch: view.look.pitch + (-Math.PI / 2 - view.look.pitch) * by };
  }
  private turn(right_rad: number, up_rad: number): void {
    this.view.look = turned(this.view.look, right_rad, up_rad);
  }
  private set({ eye, look }: View): void {
    this.view.eye.copy(eye);
    this.view.look = look;
  }
}
