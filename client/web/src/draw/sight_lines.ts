// Lines of sight in the picture: green as far as one sees, red from what hides on; and a mark where the next one begins.
import * as THREE from 'three';
import type { Sight, Vector } from '../core/sight';

const kSeen = '#37e06b';
const kHidden = '#ff4a3d';
const kMark = '#ffd23d';
const kMark_m = 60;

export class SightLines {
  readonly object = new THREE.Group();
  private origin = new THREE.Vector3();
  private readonly lines = [lineOf(kSeen), lineOf(kHidden), lineOf(kMark)] as const;

  constructor() {
    this.object.add(...this.lines);
  }

  show(sight: Sight): void {
    const end = sight.hit ?? sight.to;
    this.origin.fromArray(sight.from);
    this.set(0, sight.from, end);
    this.set(1, end, sight.to);
    this.lines[1].visible = sight.hit !== null;
    this.lines[2].visible = false;
  }
  // Upright above a point.
  mark(point: Vector, up: THREE.Vector3): void {
    this.origin.fromArray(point);
    this.set(2, point, new THREE.Vector3().fromArray(point).addScaledVector(up, kMark_m).toArray());
    this.lines[0].visible = this.lines[1].visible = false;
  }
  clear(): void {
    for (const line of this.lines) line.visible = false;
  }

  place(eye: readonly number[]): void {
    this.object.position.set(this.origin.x - eye[0]!, this.origin.y - eye[1]!, this.origin.z - eye[2]!);
  }

  private set(line: 0 | 1 | 2, from: Vector, to: Vector): void {
    const ends = [from, to].map((p) => new THREE.Vector3().fromArray(p).sub(this.origin));
    this.lines[line].geometry.dispose();
    this.lines[line].geometry = new THREE.BufferGeometry().setFromPoints(ends);
    this.lines[line].visible = true;
  }
}

// Over everything, for what hides a line hides it from most eyes, too.
function lineOf(color: string): THREE.Line {
  const line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color, depthTest: false, transparent: true }));
  line.frustumCulled = false;
  line.visible = false;
  line.renderOrder = 10;
  return line;
}
