// The buffers of a part of the mesh on the graphics card: two sets. One is drawn while the other is brought to the mesh that comes
// next, a little in each frame, and then they change places; so a frame never shows a mesh that is half made. Everything here that
// touches the graphics interface runs inside withOwnState().
import * as THREE from 'three';
import { kChannels, type ChannelName, type ChannelUpdate, type PartUpdate } from '../core/mesh_update.js';

// A mesh changes little by little and may grow: its buffers have so much more than it needs.
const kSlack = 1.25;

interface Channel {
  readonly buffer: WebGLBuffer;
  readonly attribute: THREE.GLBufferAttribute;
  readonly bytes: number; // of a number
  readonly items: number; // numbers of a vertex or an index
  readonly is_index: boolean;
  capacity: number; // bytes on the card
}

function makeChannel(gl: WebGL2RenderingContext, name: ChannelName): Channel {
  const is_index = name === 'index' || name === 'line';
  const is_normal = name === 'from_normal' || name === 'to_normal';
  const [type, bytes] = is_index ? [gl.UNSIGNED_INT, 4 as const] : is_normal ? [gl.BYTE, 1 as const] : [gl.FLOAT, 4 as const];
  const is_single = is_index || name === 'from_moved' || name === 'to_moved';
  const items = is_single ? 1 : name === 'texture_coordinate' ? 2 : name === 'from_bend' || name === 'to_bend' ? 3 : 4;
  const buffer = gl.createBuffer()!;
  // A buffer is of the kind that it is bound to first.
  gl.bindBuffer(is_index ? gl.ELEMENT_ARRAY_BUFFER : gl.ARRAY_BUFFER, buffer);
  return { buffer, attribute: new THREE.GLBufferAttribute(buffer, type, items, bytes, 0), bytes, items, is_index, capacity: 0 };
}

export class BufferSet {
  readonly geometry = new THREE.BufferGeometry();
  readonly lines = new THREE.BufferGeometry(); // the same vertices
  triangles = 0;
  has_lines = false; // that belong to the triangles
  private readonly channels: Record<ChannelName, Channel>;

  constructor(private readonly gl: WebGL2RenderingContext) {
    this.channels = Object.fromEntries(kChannels.map((name) => [name, makeChannel(gl, name)])) as Record<ChannelName, Channel>;
    for (const geometry of [this.geometry, this.lines]) {
      for (const name of ['from_position', 'to_position', 'from_normal', 'to_normal'] as const) geometry.setAttribute(name, this.attribute(name));
      // By these names three's own materials decide what a mesh has.
      geometry.setAttribute('position', this.attribute('from_position'));
      geometry.setAttribute('normal', this.attribute('from_normal'));
      geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), Infinity); // the server culls
    }
    this.geometry.setAttribute('texture_coordinate', this.attribute('texture_coordinate'));
    this.geometry.setAttribute('uv', this.attribute('texture_coordinate'));
    this.geometry.setIndex(this.attribute('index'));
    this.lines.setIndex(this.attribute('line'));
  }

  // Whether vertices tell how far the ground has moved; otherwise shaders read 0.
  set tells_moved(tells: boolean) {
    for (const name of ['from_moved', 'to_moved'] as const) {
      if (tells) this.geometry.setAttribute(name, this.attribute(name));
      else this.geometry.deleteAttribute(name);
    }
  }

  // Whether vertices move on curves; otherwise shaders read 0.
  set tells_bends(tells: boolean) {
    for (const geometry of [this.geometry, this.lines]) {
      for (const name of ['from_bend', 'to_bend'] as const) {
        if (tells) geometry.setAttribute(name, this.attribute(name));
        else geometry.deleteAttribute(name);
      }
    }
  }

  // Makes room for a channel of an update; `is_whole` if nothing that is there is needed.
  reserve(name: ChannelName, update: ChannelUpdate, is_whole: boolean): void {
    const channel = this.channels[name];
    const wanted = update.size * channel.bytes;
    if (wanted > channel.capacity) this.resize(channel, Math.ceil((kSlack * wanted) / 4) * 4, is_whole);
    channel.attribute.setCount(update.size / channel.items);
  }

  // Uploads `count` numbers of `data` from `from` on, to `to`.
  write(name: ChannelName, data: ChannelUpdate['data'], from: number, to: number, count: number): void {
    const { gl } = this;
    const channel = this.channels[name];
    gl.bindBuffer(gl.COPY_WRITE_BUFFER, channel.buffer);
    gl.bufferSubData(gl.COPY_WRITE_BUFFER, to * channel.bytes, data, from, count);
  }

  // The buffers go with the geometries, if the renderer knows them, and else here.
  dispose(): void {
    this.geometry.dispose();
    this.lines.dispose();
    for (const { buffer } of Object.values(this.channels)) this.gl.deleteBuffer(buffer);
  }

  fillLines(lines: ChannelUpdate): void {
    this.reserve('line', lines, true);
    this.write('line', lines.data, 0, 0, lines.size);
    this.has_lines = true;
  }

  private attribute(name: ChannelName): THREE.BufferAttribute {
    return this.channels[name].attribute as unknown as THREE.BufferAttribute;
  }

  // The content goes by way of another buffer, so that the buffer stays the one that the renderer knows.
  private resize(channel: Channel, bytes: number, is_whole: boolean): void {
    const { gl } = this;
    const keep = is_whole ? 0 : channel.capacity;
    const held = keep > 0 ? gl.createBuffer() : null;
    if (held) {
      gl.bindBuffer(channel.is_index ? gl.ELEMENT_ARRAY_BUFFER : gl.ARRAY_BUFFER, held);
      gl.bindBuffer(gl.COPY_WRITE_BUFFER, held);
      gl.bufferData(gl.COPY_WRITE_BUFFER, keep, gl.STREAM_COPY);
      gl.bindBuffer(gl.COPY_READ_BUFFER, channel.buffer);
      gl.copyBufferSubData(gl.COPY_READ_BUFFER, gl.COPY_WRITE_BUFFER, 0, 0, keep);
    }
    gl.bindBuffer(gl.COPY_WRITE_BUFFER, channel.buffer);
    gl.bufferData(gl.COPY_WRITE_BUFFER, bytes, gl.DYNAMIC_DRAW);
    channel.capacity = bytes;
    if (!held) return;
    gl.bindBuffer(gl.COPY_READ_BUFFER, held);
    gl.copyBufferSubData(gl.COPY_READ_BUFFER, gl.COPY_WRITE_BUFFER, 0, 0, keep);
    gl.bindBuffer(gl.COPY_READ_BUFFER, null);
    gl.deleteBuffer(held);
  }
}

// What an upload costs, in bytes: a call of the graphics interface costs about as much as 512 bytes, by measurement in Chromium.
// So the client core joins changes that are closer than that (kUploadGap in client/mesh/patch/blend_patch.h).
export const kCallCost = 512;

export function costOfChannel({ data, ranges }: ChannelUpdate): number {
  return data.byteLength + (kCallCost * ranges.length) / 2;
}
export function costOf(part: PartUpdate): number {
  return Object.values(part.channels).reduce((sum, channel) => sum + costOfChannel(channel), 0);
}
