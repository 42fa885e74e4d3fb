// Buffers of a mesh between two keyframes, straight on the graphics card: brought up to date when the mesh changes.
import * as THREE from 'three';
import type { Changes } from '../core/core';

export interface Channel {
  buffer: WebGLBuffer;
  attribute: THREE.GLBufferAttribute;
  capacity: number; // bytes on the card
}

// A mesh changes little by little and may grow: its buffers have so much more than it needs.
const kSlack = 1.25;

export function channel(gl: WebGL2RenderingContext, type: number, items: number, bytes: 1 | 2 | 4): Channel {
  const buffer = gl.createBuffer()!;
  return { buffer, attribute: new THREE.GLBufferAttribute(buffer, type, items, bytes, 0), capacity: 0 };
}

export function fill(gl: WebGL2RenderingContext, target: number, channel: Channel, data: ArrayBufferView, count: number): void {
  gl.bindBuffer(target, channel.buffer);
  if (data.byteLength > channel.capacity || kSlack * kSlack * data.byteLength < channel.capacity) {
    channel.capacity = Math.ceil((kSlack * data.byteLength) / 4) * 4;
    gl.bufferData(target, channel.capacity, gl.DYNAMIC_DRAW);
  }
  gl.bufferSubData(target, 0, data);
  channel.attribute.setCount(count);
}

type Elements = Float32Array | Int8Array | Uint32Array;

// Uploads the ranges of an array, `items` numbers for each element of theirs. All of it if it has outgrown its buffer.
export function patch(gl: WebGL2RenderingContext, target: number, channel: Channel, data: Elements, items: number, ranges: Uint32Array,
                      count: number): void {
  if (data.byteLength > channel.capacity) {
    fill(gl, target, channel, data, count);
    return;
  }
  gl.bindBuffer(target, channel.buffer);
  for (let i = 0; i < ranges.length; i += 2) {
    const [begin, end] = [items * ranges[i]!, items * ranges[i + 1]!];
    gl.bufferSubData(target, begin * data.BYTES_PER_ELEMENT, data, begin, end - begin);
  }
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

// `changes` are those since what the buffers hold.
export function patchBlend(gl: WebGL2RenderingContext, c: BlendChannels, index: Channel, mesh: BlendArrays, changes: Changes): void {
  patch(gl, gl.ARRAY_BUFFER, c.from_position, mesh.from_positions, 4, changes.from_positions, mesh.vertices);
  patch(gl, gl.ARRAY_BUFFER, c.to_position, mesh.to_positions, 4, changes.to_positions, mesh.vertices);
  patch(gl, gl.ARRAY_BUFFER, c.from_normal, mesh.from_normals, 4, changes.from_normals, mesh.vertices);
  patch(gl, gl.ARRAY_BUFFER, c.to_normal, mesh.to_normals, 4, changes.to_normals, mesh.vertices);
  patch(gl, gl.ELEMENT_ARRAY_BUFFER, index, mesh.indices, 3, changes.triangles, mesh.indices.length);
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
