// What a recording is of: its frames' times, and the containers and codecs that a video can have.

export type Container = 'mp4' | 'webm' | 'png';

export interface Take {
  width: number;
  height: number;
  rate: number; // frames a second
  container: Container;
  from_s: number; // of the flight
  speed: number; // seconds of the flight in a second of the recording
  seconds: number; // of the recording
}

// The flight's time of each frame: from the first on, in even steps, as many as the recording's time has.
export function timesOf({ rate, from_s, speed, seconds }: Pick<Take, 'rate' | 'from_s' | 'speed' | 'seconds'>): number[] {
  return Array.from({ length: Math.max(1, Math.round(seconds * rate)) }, (_, i) => from_s + (i * speed) / rate);
}

// Codecs that players of a container know, the widest spread first.
export const kCodecs = { mp4: ['avc', 'av1', 'vp9'], webm: ['vp9', 'vp8', 'av1'] } as const;

// Of frames in a row, so that they sort.
export function frameName(index: number, count: number): string {
  return `frame_${String(index).padStart(Math.max(4, String(count - 1).length), '0')}.png`;
}

// How long the rest takes, by how long what is done took.
export function timeLeft_s(done: number, count: number, spent_s: number): number | null {
  return done < 3 ? null : (spent_s / done) * (count - done);
}

// The largest size that is no larger than wanted, of the same shape, and takes no side beyond `most`.
export function sizeWithin(width: number, height: number, most: number): [width: number, height: number] {
  const share = Math.min(1, most / Math.max(width, height));
  return [Math.floor(width * share), Math.floor(height * share)];
}
