// The sky: one triangle over the whole screen, drawn behind everything.
import * as THREE from 'three';
import { kSkyFragment, kSkyVertex } from './shaders';

// Towards the sun: from the north-west, 36 degrees high, as maps are lit by custom.
export const kSun = new THREE.Vector3(-Math.SQRT1_2 * Math.cos(0.63), Math.SQRT1_2 * Math.cos(0.63), Math.sin(0.63));

export class Sky {
  readonly object: THREE.Mesh;
  private readonly directions = new THREE.Matrix4();

  constructor(up: THREE.Vector3) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kSkyVertex,
      fragmentShader: kSkyFragment,
      uniforms: { u_sun: { value: kSun }, u_up: { value: up }, u_directions: { value: this.directions } },
      depthTest: false,
      depthWrite: false,
    });
    this.object = new THREE.Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
  }

  // The camera stands at the origin: everything is drawn relative to the eye.
  update(camera: THREE.PerspectiveCamera): void {
    this.directions.multiplyMatrices(camera.matrixWorld, camera.projectionMatrixInverse);
  }
}
