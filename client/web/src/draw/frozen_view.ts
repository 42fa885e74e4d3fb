// The pose whose section is frozen: the outline of what it sees, for a look from outside.
import * as THREE from 'three';
import type { Pose } from '@foreland/client';

export class FrozenView {
  readonly object: THREE.LineSegments;
  pose: Pose | null = null;

  constructor() {
    const material = new THREE.LineBasicMaterial({ color: '#ffb454', transparent: true, opacity: 0.95 });
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  freeze(pose: Pose, fov_rad: number, aspect: number, length_m: number): void {
    this.pose = pose;
    this.object.position.fromArray(pose.eye);
    const tall = Math.tan(0.5 * fov_rad);
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => new THREE.Vector3(x! * tall * aspect, y! * tall, -1));
    const points: THREE.Vector3[] = [];
    for (let i = 0; i < 4; ++i) {
      const [here, next] = [corners[i]!, corners[(i + 1) % 4]!];
      points.push(new THREE.Vector3(), here.clone().multiplyScalar(length_m));
      for (const depth of [0.1, 0.4, 1]) {
        points.push(here.clone().multiplyScalar(depth * length_m), next.clone().multiplyScalar(depth * length_m));
      }
    }
    this.object.geometry.setFromPoints(points);
    this.object.quaternion.fromArray(pose.orientation);
    this.object.visible = true;
  }

  thaw(): void {
    this.pose = null;
    this.object.visible = false;
  }
}
