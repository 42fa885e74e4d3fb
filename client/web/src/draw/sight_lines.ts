// Lines of sight in the picture: green as far as one sees, red from what hides on; and a mark where the next one begins.
import type { Sight, Vector } from '@foreland/client';
import * as THREE from 'three';

const kSeen = '#37e06b';
const kHidden = '#ff4a3d';
const kMark = '#ffd23d';
const kMark_m = 60;

export class SightLines {
  readonly object = new THREE.Group();
  private readonly lines = { seen: lineOf(kSeen), hidden: lineOf(kHidden), mark: lineOf(kMark) };

  constructor() {
    this.object.add(...Object.values(this.lines));
  }

  clear(): void {
    for (const line of Object.values(this.lines)) line.visible = false;
  }
  show({ from, to, hit }: Sight): void {
    this.clear();
    this.draw(this.lines.seen, from, hit ?? to);
    if (hit) this.draw(this.lines.hidden, hit, to);
  }
  // Upright above a point.
  mark(point: Vector, up: readonly number[]): void {
    this.clear();
    this.draw(this.lines.mark, point, point.map((v, i) => v + kMark_m * up[i]!) as Vector);
  }

  // From its first end on, so that floats are exact enough far from the scene's origin.
  private draw(line: THREE.Line, from: Vector, to: Vector): void {
    const [begin, end] = [new THREE.Vector3(...from), new THREE.Vector3(...to)];
    line.geometry.dispose();
    line.geometry = new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), end.sub(begin)]);
    line.position.copy(begin);
    line.visible = true;
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
