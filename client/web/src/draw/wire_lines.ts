// The edges of a blended mesh as lines, drawn from the mesh's own vertices.
import * as THREE from 'three';
import { shader, type BufferSet } from './blend_buffers';
import { kWireFragment, kWireVertex } from './shaders';

export class WireLines {
  readonly object: THREE.LineSegments;
  wanted = false;

  // `uniforms` have the mesh's weight and its place before the eye.
  constructor(uniforms: Record<string, THREE.IUniform>) {
    const lines = shader(kWireVertex, kWireFragment, uniforms);
    Object.assign(lines, { transparent: true, depthWrite: false });
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), lines);
    this.object.frustumCulled = false; // the server culls
    this.object.visible = false;
  }

  // Draws those of a set, once it has them.
  show(set: BufferSet): void {
    this.object.geometry = set.lines;
    this.object.visible = this.wanted && set.has_lines;
  }
}
