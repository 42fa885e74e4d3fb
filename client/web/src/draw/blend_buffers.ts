// Buffers of a mesh between two keyframes, straight on the graphics card: filled when the mesh changes.
import * as THREE from 'three';

export interface Channel {
  buffer: WebGLBuffer;
  attribute: THREE.GLBufferAttribute;
}

export function channel(gl: WebGL2RenderingContext, type: number, items: number, bytes: 1 | 2 | 4): Channel {
  const buffer = gl.createBuffer()!;
  return { buffer, attribute: new THREE.GLBufferAttribute(buffer, type, items, bytes, 0) };
}

export function fill(gl: WebGL2RenderingContext, target: number, channel: Channel, data: ArrayBufferView, count: number): void {
  gl.bindBuffer(target, channel.buffer);
  gl.bufferData(target, data, gl.DYNAMIC_DRAW);
  channel.attribute.setCount(count);
}

export type BlendChannels = Record<'from_position' | 'to_position' | 'from_normal' | 'to_normal', Channel>;

export function blendChannels(gl: WebGL2RenderingContext): BlendChannels {
  return {
    from_position: channel(gl, gl.FLOAT, 4, 4),
    to_position: channel(gl, gl.FLOAT, 4, 4),
    from_normal: channel(gl, gl.BYTE, 4, 1),
    to_normal: channel(gl, gl.BYTE, 4, 1),
  };
}

export interface BlendArrays {
  vertices: number;
  from_positions: Float32Array;
  to_positions: Float32Array;
  from_normals: Int8Array;
  to_normals: Int8Array;
  indices: Uint32Array;
}

export function fillBlend(gl: WebGL2RenderingContext, c: BlendChannels, index: Channel, mesh: BlendArrays): void {
  fill(gl, gl.ARRAY_BUFFER, c.from_position, mesh.from_positions, mesh.vertices);
  fill(gl, gl.ARRAY_BUFFER, c.to_position, mesh.to_positions, mesh.vertices);
  fill(gl, gl.ARRAY_BUFFER, c.from_normal, mesh.from_normals, mesh.vertices);
  fill(gl, gl.ARRAY_BUFFER, c.to_normal, mesh.to_normals, mesh.vertices);
  fill(gl, gl.ELEMENT_ARRAY_BUFFER, index, mesh.indices, mesh.indices.length);
}

export function bindBlend(geometry: THREE.BufferGeometry, channels: BlendChannels, index: Channel): void {
  for (const name of ['from_position', 'to_position', 'from_normal', 'to_normal'] as const) {
    geometry.setAttribute(name, channels[name].attribute as unknown as THREE.BufferAttribute);
  }
  geometry.setIndex(index.attribute as unknown as THREE.BufferAttribute);
}

export function shader(vertexShader: string, fragmentShader: string, uniforms: Record<string, THREE.IUniform>): THREE.RawShaderMaterial {
  return new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader, fragmentShader, uniforms });
}
