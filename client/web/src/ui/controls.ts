// Flying by hand. Mouse: drag looks, wheel sets the speed. Keys: W A S D or arrows move, E and Q rise and sink, Shift is faster.
// Over a globe pointers do what GlobeHands says, and speed follows the height.
// Touch: one finger looks, two do what MapHands says, three carry the viewer along. A gamepad flies and looks. Motion ends at the ground; nothing else moves the eye.
import * as THREE from 'three';
import { basisAt, forwardOf, kAxis, kMapNorth, orientationOf, type Look } from './camera';
import type { Pose, Scene } from '@foreland/client';
import { headsetPad, padState } from './gamepad';
import type { GlobeHands } from './globe_hands';
import { fly, type Body } from './globe_moves';
import type { MapHands } from './map_hands';
import { isForPage, isOnButton } from './stage';

const kKeys: Record<string, [axis: 0 | 1 | 2, sign: number]> = {
  KeyW: [1, 1], ArrowUp: [1, 1], KeyS: [1, -1], ArrowDown: [1, -1],
  KeyD: [0, 1], ArrowRight: [0, 1], KeyA: [0, -1], ArrowLeft: [0, -1],
  KeyE: [2, 1], Space: [2, 1], KeyQ: [2, -1], KeyC: [2, -1],
};
const kRadiansPerScreen = 1.6; // of dragging over the canvas' height
const kSteepest_rad = 1.54;
const kSmoothing_s = 0.22; // of velocity
const kStill = window.matchMedia('(prefers-reduced-motion: reduce)'); // who wants that does not glide
const kPadTurn_radps = 1.3;
// The ground is known for eight of the last frame's steps ahead, and told again some frames later. So the first step from rest is short,
// and none is longer than so many times the one before.
const kFirstStep_m = 8, kGrowth = 1.5;
const kClearance_m = 2;
const kHeights_ps = 0.7, kSlowest_mps = 12, kFastest_mps = 8e6; // over a globe: heights above the ground in a second

export class Controls {
  eye = new THREE.Vector3();
  look: Look = { heading: 0, pitch: 0 };
  pole = kMapNorth; // towards which headings are 0
  speed_mps = 150;
  clearance_m = kClearance_m;
  onTakeOver: () => void = () => {}; // the user steers
  onSpeed: () => void = () => {}; // the user has chosen another speed, by the wheel
  heldInHands: () => Iterable<XRInputSource> = () => []; // of a headset

  private globe: { hands: GlobeHands; body: Body } | null = null;
  private map_hands: MapHands | null = null;
  private readonly settled = new THREE.Vector3(); // where the last frame left the eye
  private readonly velocity = new THREE.Vector3(); // right, ahead, up
  private pad: ReturnType<typeof padState> = null;
  private stepped_m = 0; // in the last frame
  private readonly held = new Set<string>();
  private readonly fingers = new Map<number, [number, number]>();
  private carry = new THREE.Vector2(); // metres to move, from three fingers: right, ahead
  ground_distance_m = 100; // by which their way is scaled
  private low = new THREE.Vector3(-1e7, -1e7, -1e7);
  private high = new THREE.Vector3(1e7, 1e7, 1e7);

  constructor(private canvas: HTMLCanvasElement) {
    this.steerOn(canvas);
    window.addEventListener('keydown', (e) => this.key(e));
    window.addEventListener('keyup', (e) => this.held.delete(e.code));
    window.addEventListener('blur', () => this.held.clear());
  }

  // On another canvas, which takes the first one's place.
  steerOn(canvas: HTMLCanvasElement): void {
    this.canvas = canvas;
    this.fingers.clear();
    canvas.addEventListener('pointerdown', (e) => this.press(e));
    canvas.addEventListener('pointermove', (e) => this.drag(e));
    for (const name of ['pointerup', 'pointercancel', 'lostpointercapture'] as const) {
      canvas.addEventListener(name, (e) => this.release(e));
    }
    canvas.addEventListener('wheel', (e) => this.turnWheel(e), { passive: false });
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  }

  // The eye stays in the scene's box grown by its own width on each side.
  setScene({ frame, bounds: { low, high } }: Scene): void {
    if (frame === 'globe') return this.setGlobe();
    const grow = Math.max(high[0]! - low[0]!, high[1]! - low[1]!);
    this.low.fromArray([...low]).subScalar(grow);
    this.high.fromArray([...high]).addScalar(grow);
    this.speed_mps = Math.min(Math.max(grow / 180, 0.02), 400);
    this.clearance_m = Math.min(kClearance_m, grow / 2000);
  }

  private setGlobe(): void {
    this.pole = kAxis;
    this.low.setScalar(-Infinity);
    this.high.setScalar(Infinity);
  }
  // From now on it flies over a globe.
  takeGlobe(hands: GlobeHands, body: Body): void {
    this.globe = { hands, body };
  }
  // From now on it flies over a map.
  takeMap(hands: MapHands): void {
    this.map_hands = hands;
  }
  // To another place, at once.
  jumpTo(eye: readonly number[], look: Look): void {
    this.globe?.hands.rest();
    this.velocity.set(0, 0, 0);
    this.settled.copy(this.eye.fromArray([...eye]));
    this.look = look;
  }
  get isOnGlobe(): boolean {
    return this.globe !== null;
  }

  pose(up: THREE.Vector3): Pose {
    return { eye: this.eye.toArray(), orientation: orientationOf(this.look, up, this.pole) };
  }

  // The same, looking neither up nor down.
  level(up: THREE.Vector3): Pose {
    return { eye: this.eye.toArray(), orientation: orientationOf({ ...this.look, pitch: 0 }, up, this.pole) };
  }

  // Moves the camera for `seconds`. `sweep` limits a motion by the ground (Terrain.sweep).
  step(seconds: number, up: THREE.Vector3, sweep: (from: number[], to: number[]) => [number, number, number]): void {
    const from = this.settled.toArray();
    if (this.globe) this.speed_mps = Math.min(Math.max(kHeights_ps * this.ground_distance_m, kSlowest_mps), kFastest_mps);
    const wanted = new THREE.Vector3();
    for (const code of this.held) {
      const key = kKeys[code];
      if (key) wanted.setComponent(key[0], wanted.getComponent(key[0]) + key[1]);
    }
    const { pad } = this;
    if (pad) wanted.add(new THREE.Vector3(...pad.move));
    const faster = pad?.is_faster || this.held.has('ShiftLeft') || this.held.has('ShiftRight') ? 4 : 1;
    wanted.clampLength(0, 1).multiplyScalar(this.speed_mps * faster);
    this.velocity.lerp(wanted, kStill.matches ? 1 : 1 - Math.exp(-seconds / kSmoothing_s));
    if (wanted.lengthSq() === 0 && this.velocity.length() < 1e-4 * this.speed_mps) this.velocity.set(0, 0, 0);
    const wanted_m = this.velocity.length() * seconds;
    const share = Math.min(1, Math.max(kFirstStep_m, kGrowth * this.stepped_m) / wanted_m); // of nothing: 1
    this.move(this.velocity.x * seconds * share, this.velocity.y * seconds * share, this.velocity.z * seconds * share, up);
    this.carryOn(up);
    this.globe?.hands.step(seconds);
    this.eye.clamp(this.low, this.high);
    this.eye.fromArray(sweep(from, this.eye.toArray()));
    this.settled.copy(this.eye);
    this.stepped_m = Math.hypot(...from.map((v, i) => this.eye.getComponent(i) - v));
  }

  // With each frame, before step(). A gamepad takes the camera where it is used.
  readPad(seconds: number): void {
    const pad = headsetPad(this.heldInHands()) ?? padState(navigator.getGamepads?.() ?? []);
    if (pad && !this.pad) this.onTakeOver();
    if (pad) this.turnBy(pad.look[0] * kPadTurn_radps * seconds, pad.look[1] * kPadTurn_radps * seconds);
    this.pad = pad;
  }

  private move(right_m: number, ahead_m: number, up_m: number, up: THREE.Vector3): void {
    const [east, north] = basisAt(up, this.pole);
    const { heading } = this.look;
    if (right_m === 0 && ahead_m === 0 && up_m === 0) return;
    if (this.globe) return this.setView(fly(this, this.globe.body, right_m, ahead_m, up_m));
    this.eye
      .addScaledVector(east, Math.cos(heading) * right_m)
      .addScaledVector(north, -Math.sin(heading) * right_m)
      .addScaledVector(forwardOf(this.look, up, this.pole), ahead_m)
      .addScaledVector(up, up_m);
  }

  private setView({ eye, look }: { eye: THREE.Vector3; look: Look }): void {
    this.eye.copy(eye);
    this.look = look;
  }

  private carryOn(up: THREE.Vector3): void {
    if (this.carry.lengthSq() === 0) return;
    const pitch = this.look.pitch;
    this.look.pitch = 0; // over the ground, level
    this.move(this.carry.x, this.carry.y, 0, up);
    this.look.pitch = pitch;
    this.carry.set(0, 0);
  }

  private press(event: PointerEvent): void {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    this.onTakeOver();
    if (this.globe) this.pressGlobe(this.globe.hands, event);
    else this.beginPinch();
  }
  private beginPinch(): void {
    const [one, other] = [...this.fingers.values()];
    if (this.fingers.size === 2) (this.globe?.hands ?? this.map_hands)?.pinchFrom(one!, other!);
  }

  private drag(event: PointerEvent): void {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const now: [number, number] = [event.clientX, event.clientY];
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    if (this.globe) return this.dragGlobe(this.globe.hands, event.pointerId, now);
    this.fingers.set(event.pointerId, now);
    const [one, other] = [...this.fingers.values()];
    if (this.fingers.size === 1) this.turn(dx, dy);
    if (this.fingers.size === 2) this.map_hands?.pinchTo(one!, other!);
    if (this.fingers.size === 3) this.carryBy(dx, dy);
  }

  // Of two fingers that pinched, the other one drags.
  private release(event: PointerEvent): void {
    if (!this.fingers.delete(event.pointerId)) return;
    const [rest] = [...this.fingers.values()];
    if (this.fingers.size === 2) this.beginPinch();
    else if (this.globe && rest) this.globe.hands.press(...rest, false);
  }
  private pressGlobe(hands: GlobeHands, event: PointerEvent): void {
    const [one, other] = [...this.fingers.values()];
    if (other) hands.pinchFrom(one!, other);
    else hands.press(event.clientX, event.clientY, event.button !== 0 || event.ctrlKey || event.shiftKey);
  }
  private dragGlobe(hands: GlobeHands, id: number, now: [number, number]): void {
    this.fingers.set(id, now);
    const [one, other] = [...this.fingers.values()];
    if (other) hands.pinchTo(one!, other);
    else hands.move(...now);
  }

  private turn(dx: number, dy: number): void {
    const scale = kRadiansPerScreen / this.canvas.clientHeight;
    this.turnBy(-dx * scale, dy * scale);
  }
  private turnBy(right_rad: number, up_rad: number): void {
    this.look.heading += right_rad;
    this.look.pitch = Math.min(Math.max(this.look.pitch + up_rad, -kSteepest_rad), kSteepest_rad);
  }

  // By one of three fingers.
  private carryBy(dx: number, dy: number): void {
    const metres = (1.6 * this.ground_distance_m) / this.canvas.clientHeight / 3;
    this.carry.x -= dx * metres;
    this.carry.y += dy * metres;
  }

  private turnWheel(event: WheelEvent): void {
    event.preventDefault();
    if (this.globe) {
      this.onTakeOver();
      return this.globe.hands.wheel(event.clientX, event.clientY, event.deltaMode === 1 ? 33 * event.deltaY : event.deltaY);
    }
    this.speed_mps = Math.min(Math.max(this.speed_mps * 1.0012 ** -event.deltaY, 0.01), 20000);
    this.onSpeed();
  }

  private key(event: KeyboardEvent): void {
    if (!isForPage(event) || isOnButton(event)) return;
    if (!kKeys[event.code] && !event.code.startsWith('Shift')) return;
    event.preventDefault();
    this.held.add(event.code);
    if (kKeys[event.code]) this.onTakeOver();
  }
}
