// For tests: the light on the ground at lattice positions, by the very functions that shade the terrain, without its mesh.
import * as THREE from 'three';
import { kProbeFragment, kProbeVertex, shader } from './shaders';

export class ShadeProbe {
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.Camera();
  private readonly footprint = { value: 1 };

  // `uniforms` are the terrain's.
  constructor(private readonly renderer: THREE.WebGLRenderer, private readonly uniforms: Record<string, THREE.IUniform>) {}

  // Red, green and blue, from 0 to 255, of each position (x, y, x, y, ...), where a pixel sees `footprint` sample intervals.
  read(positions: readonly number[], footprint: number): number[] {
    const count = positions.length / 2;
    const geometry = new THREE.BufferGeometry();
    const places = Array.from({ length: count }, (_, i) => [(2 * i + 1) / count - 1, positions[2 * i]!, positions[2 * i + 1]!]);
    geometry.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(places.flat()), 3));
    this.footprint.value = footprint;
    const points = new THREE.Points(geometry, shader(kProbeVertex, kProbeFragment, { ...this.uniforms, u_footprint: this.footprint }));
    points.frustumCulled = false;
    this.scene.add(points);
    const target = new THREE.WebGLRenderTarget(count, 1, { depthBuffer: false });
    this.renderer.setRenderTarget(target);
    this.renderer.render(this.scene, this.camera);
    const pixels = new Uint8Array(4 * count);
    this.renderer.readRenderTargetPixels(target, 0, 0, count, 1, pixels);
    this.renderer.setRenderTarget(null);
    this.scene.remove(points);
    geometry.dispose();
    target.dispose();
    return [...pixels].filter((_, i) => i % 4 !== 3);
  }
}
