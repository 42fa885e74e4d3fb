// The sky: one triangle over the whole screen, drawn behind everything.
import type { FrameKind } from '@foreland/client';
import * as THREE from 'three';
import { kSkyFragment, kSkyVertex } from './shaders';

export class Sky {
  readonly object: THREE.Mesh;
  private readonly directions = new THREE.Matrix4();

  // `sun`: towards it; `up`: at the eye.
  constructor(sun: THREE.Vector3, up: THREE.Vector3) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kSkyVertex,
      fragmentShader: kSkyFragment,
      uniforms: { u_sun: { value: sun }, u_up: { value: up }, u_directions: { value: this.directions } },
      depthTest: false,
      depthWrite: false,
    });
    this.object = new THREE.Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.object.renderOrder = -1;
    this.object.onBeforeRender = ({ xr }, _, { matrixWorld, projectionMatrixInverse }) => {
      if (xr.isPresenting) this.directions.extractRotation(matrixWorld).multiply(projectionMatrixInverse); // each eye's
    };
  }

  // Through the air of a globe, once there is some.
  takeAir(fragment: string, uniforms: Record<string, THREE.IUniform>): void {
    const material = this.object.material as THREE.RawShaderMaterial;
    material.fragmentShader = fragment;
    Object.assign(material.uniforms, uniforms);
    material.needsUpdate = true;
  }
  // Over a globe it is black until then.
  setFrame(kind: FrameKind): void {
    const material = this.object.material as THREE.RawShaderMaterial;
    material.defines = kind === 'globe' ? { GLOBE: '' } : {};
    material.needsUpdate = true;
  }
  update(camera: THREE.PerspectiveCamera): void {
    this.directions.makeRotationFromQuaternion(camera.quaternion).multiply(camera.projectionMatrixInverse);
  }
}
