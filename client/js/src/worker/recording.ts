// A flight by hand as a file that `foreland replay` flies again: all that came in, and where the camera was, with times. The format is that
// of client/fly/recording.cpp. It begins with a session; one that has gone on for a while cannot be replayed.
import type { Blend, Pose, Request } from '../core/values.js';

const kFirstLine = 'foreland flight 1\n';
const kHead_bytes = 13; // kind, time, size
const kMax_bytes = 256 << 20;

export class Recording {
  bytes = 0;
  private parts: Uint8Array<ArrayBuffer>[] = [];
  private last_us = 0;
  private is_full = false;

  constructor(request: Request, blend: Blend) {
    this.add(new TextEncoder().encode(kFirstLine));
    this.put('o', 0, new TextEncoder().encode(JSON.stringify({ ...choiceOf(request, blend), steered: true })));
  }

  message(now_ms: number, message: Uint8Array): void {
    this.put('m', now_ms, message);
  }
  reconnect(now_ms: number): void {
    this.put('r', now_ms, new Uint8Array());
  }
  frame(now_ms: number, { eye, orientation }: Pose): void {
    this.put('s', now_ms, new Uint8Array(new Float64Array([...eye, ...orientation]).buffer)); // of a little-endian machine, as WebAssembly is
  }
  // The camera of the next frame is jumped to.
  jump(now_ms: number): void {
    this.put('j', now_ms, new Uint8Array());
  }
  choose(now_ms: number, request: Request, blend: Blend): void {
    this.put('c', now_ms, new TextEncoder().encode(JSON.stringify(choiceOf(request, blend))));
  }

  file(): Blob {
    return new Blob(this.parts, { type: 'application/octet-stream' });
  }

  // Times of the two threads may cross; in the file they do not go back. A file that has become too long ends early.
  private put(kind: string, now_ms: number, bytes: Uint8Array): void {
    this.is_full ||= this.bytes + kHead_bytes + bytes.length > kMax_bytes;
    if (this.is_full) return;
    this.last_us = Math.max(this.last_us, Math.round(now_ms * 1000));
    const record = new Uint8Array(kHead_bytes + bytes.length), view = new DataView(record.buffer);
    view.setUint8(0, kind.charCodeAt(0));
    view.setBigInt64(1, BigInt(this.last_us), true);
    view.setUint32(9, bytes.length, true);
    record.set(bytes, kHead_bytes);
    this.add(record);
  }

  private add(part: Uint8Array<ArrayBuffer>): void {
    this.parts.push(part);
    this.bytes += part.length;
  }
}

// As client/fly/options_json.cpp reads it.
function choiceOf(request: Request, blend: Blend): Record<string, unknown> {
  const { keyframe_ms, longest_keyframe_ms, ...same } = request;
  return {
    request: {
      ...same, keyframe_us: Math.round(keyframe_ms * 1000), longest_keyframe_us: Math.round((longest_keyframe_ms ?? 0) * 1000),
      max_triangles: request.max_triangles ?? 0, max_bytes_per_second: request.max_bytes_per_second ?? 0,
    },
    blend,
  };
}
