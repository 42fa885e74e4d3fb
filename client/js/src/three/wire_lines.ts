// The edges of a blended mesh as lines, drawn from the mesh's own vertices.
import * as THREE from 'three';
import type { BufferSet } from './blend_buffers.js';

export class WireLines {
  readonly object: THREE.LineSegments;
  wanted = false;

  constructor(material: THREE.Material) {
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), material);
    this.object.frustumCulled = false; // the server culls
    this.object.visible = false;
    this.object.raycast = () => {};
  }

  // Draws those of a set, once it has them.
  show(set: BufferSet): void {
    this.object.geometry = set.lines;
    this.object.visible = this.wanted && set.has_lines;
  }
}
