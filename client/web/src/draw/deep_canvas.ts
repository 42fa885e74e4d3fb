// What is drawn from 40,000 km down to two metres at once: into a target with a depth of 32-bit floats, reversed (EXT_clip_control), which is as
// fine at any distance as positions are; then onto the canvas. Where a browser has no such depth, planes as near to each other as the ground
// allows have to do.
import * as THREE from 'three';
import { shader } from './shaders';

const kCopyVertex = 'precision highp float;\nin vec3 position;\nvoid main() { gl_Position = vec4(position.xy, 0.5, 1.0); }';
const kCopyFragment = 'precision highp float;\nuniform sampler2D u_picture;\nout vec4 o_colour;\nvoid main() { o_colour = texelFetch(u_picture, ivec2(gl_FragCoord.xy), 0); }';
const kSamples = 4;

// How the ground is drawn to be asked how far it is from a point: bits of a float.
const kPickFragment = 'precision highp float;\nprecision highp int;\nin vec3 v_from_eye;\nuniform vec3 u_from;\nout vec4 o_colour;\nvoid main() { uint bits = floatBitsToUint(length(v_from_eye - u_from)); o_colour = vec4(float(bits & 255u), float((bits >> 8) & 255u), float((bits >> 16) & 255u), float(bits >> 24)) / 255.0; }';
const kPick_deg = 0.1, kAhead = new THREE.Vector3(0, 0, -1);

export class DeepCanvas {
  private target: THREE.WebGLRenderTarget | null = null;
  private readonly pixel = new THREE.WebGLRenderTarget(1, 1, { depthTexture: new THREE.DepthTexture(1, 1, THREE.FloatType) });
  private readonly copy: THREE.Mesh;
  private readonly copy_camera = new THREE.OrthographicCamera();
  private readonly pick_camera = new THREE.PerspectiveCamera(kPick_deg, 1);
  private readonly pick_from = { value: new THREE.Vector3() }; // from the eye of what is drawn
  private pick_material: THREE.RawShaderMaterial | null = null;
  private readonly pick_scene = new THREE.Scene();

  constructor(private readonly renderer: THREE.WebGLRenderer) {
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    this.copy = new THREE.Mesh(geometry, shader(kCopyVertex, kCopyFragment, { u_picture: { value: null } }));
    Object.assign(this.copy.material, { depthTest: false, depthWrite: false });
    this.copy.frustumCulled = false;
    if (!renderer.extensions.has('EXT_clip_control')) return;
    renderer.state.buffers.depth.setReversed(true);
    this.target = new THREE.WebGLRenderTarget(1, 1, { samples: kSamples, depthTexture: new THREE.DepthTexture(1, 1, THREE.FloatType) });
    // Materials of three write to it as to the canvas: sRGB. No other property of a target says so.
    Object.assign(this.target, { isXRRenderTarget: true });
    Object.assign(this.target.texture, { colorSpace: THREE.SRGBColorSpace, internalFormat: 'RGBA8' });
  }
  dispose(): void {
    this.target?.depthTexture?.dispose();
    this.target?.dispose();
    this.pixel.depthTexture?.dispose();
    this.pixel.dispose();
    (this.copy.material as THREE.Material).dispose();
    this.pick_material?.dispose();
  }

  get isReversed(): boolean {
    return this.target !== null;
  }

  // What `draw` draws comes to the canvas.
  draw(draw: () => void): void {
    const { renderer, target } = this;
    if (!target) return draw();
    const { x, y } = renderer.getDrawingBufferSize(kSize);
    if (target.width !== x || target.height !== y) target.setSize(x, y);
    renderer.setRenderTarget(target);
    draw();
    renderer.setRenderTarget(null);
    (this.copy.material as THREE.RawShaderMaterial).uniforms.u_picture!.value = target.texture;
    renderer.render(this.copy, this.copy_camera);
  }

  // How far the ground that is drawn is from a point in a unit direction, metres; null where it is not met. `camera` draws it; `vertex` is a
  // shader of its mesh.
  distanceAlong(ground: THREE.Object3D, camera: THREE.PerspectiveCamera, from: THREE.Vector3, direction: THREE.Vector3, vertex: string, uniforms: Record<string, THREE.IUniform>): number | null {
    const { renderer, pixel, pick_camera, pick_from, pick_scene } = this, { parent } = ground, { near, far } = camera;
    this.pick_material ??= shader(vertex, kPickFragment, { ...uniforms, u_from: pick_from });
    pick_from.value.subVectors(from, camera.position);
    pick_camera.position.copy(from);
    pick_camera.quaternion.setFromUnitVectors(kAhead, direction);
    Object.assign(pick_camera, { near, far });
    pick_camera.updateProjectionMatrix();
    pick_scene.overrideMaterial = this.pick_material;
    pick_scene.add(ground);
    renderer.setRenderTarget(pixel);
    renderer.clear();
    renderer.render(pick_scene, pick_camera);
    const bytes = new Uint8Array(4);
    renderer.readRenderTargetPixels(pixel, 0, 0, 1, 1, bytes);
    renderer.setRenderTarget(null);
    parent?.add(ground);
    const distance_m = new DataView(bytes.buffer).getFloat32(0, true);
    return distance_m > 0 ? distance_m : null;
  }
}

const kSize = new THREE.Vector2();
