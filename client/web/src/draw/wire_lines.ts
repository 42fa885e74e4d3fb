// The edges of a blended mesh as lines, drawn from the mesh's own buffers. Uploaded only while they are to be seen.
import * as THREE from 'three';
import { bindBlend, channel, fill, shader, type BlendChannels, type Channel } from './blend_buffers';
import { kWireFragment, kWireVertex } from './shaders';

export class WireLines {
  readonly object: THREE.LineSegments;
  private readonly index: Channel;

  // `channels` are the mesh's; `uniforms` have its weight and its place before the eye.
  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    channels: BlendChannels,
    uniforms: Record<string, THREE.IUniform>,
  ) {
    const geometry = new THREE.BufferGeometry();
    this.index = channel(renderer.getContext() as WebGL2RenderingContext, renderer.getContext().UNSIGNED_INT, 1, 4);
    bindBlend(geometry, channels, this.index);
    const lines = shader(kWireVertex, kWireFragment, uniforms);
    Object.assign(lines, { transparent: true, depthWrite: false });
    this.object = new THREE.LineSegments(geometry, lines);
    this.object.frustumCulled = false; // the server culls
  }

  // After renderer.resetState(). `has_seams`: triangles that share an edge may name its ends differently.
  upload(indices: Uint32Array, has_seams: boolean): void {
    const lines = edgesOf(indices, has_seams);
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    fill(gl, gl.ELEMENT_ARRAY_BUFFER, this.index, lines, lines.length);
  }
}

// Each inner edge is in two triangles, in opposite directions: without seams it is drawn by the one in which it rises.
function edgesOf(indices: Uint32Array, has_seams: boolean): Uint32Array {
  const lines = new Uint32Array(2 * indices.length);
  let count = 0;
  for (let i = 0; i < indices.length; i += 3) {
    for (let k = 0; k < 3; ++k) {
      const a = indices[i + k]!;
      const b = indices[i + ((k + 1) % 3)]!;
      if (a > b && !has_seams) continue;
      lines[count++] = a;
      lines[count++] = b;
    }
  }
  return lines.subarray(0, count);
}
