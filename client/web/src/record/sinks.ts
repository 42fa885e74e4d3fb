// What takes the frames of a recording, one after another, and makes a file of them.
import { Zip, ZipPassThrough } from 'fflate';
import { frameName, kCodecs, type Container, type Take } from './frames';

export interface FrameSink {
  // What the canvas shows now; resolves when the next frame may come.
  add(canvas: HTMLCanvasElement, index: number): Promise<void>;
  finish(): Promise<{ file: Blob; name: string }>;
  cancel(): Promise<void>;
}

const kKeyframes_s = 1; // between frames that stand alone
const kBitsPerPixel = 0.2; // of a frame: ground is full of detail that moves
const kFileTime = new Date(1980, 0, 2); // of files in an archive, so that the same frames make the same bytes

// Whether this browser can encode videos at all.
export const canEncode = (): boolean => typeof VideoEncoder !== 'undefined' && typeof VideoFrame !== 'undefined';

// An Error says in words that this browser cannot.
export function sinkOf(take: Take, count: number): Promise<FrameSink> {
  return take.container === 'png' ? Promise.resolve(pngSink(count)) : videoSink(take, take.container);
}

async function videoSink({ width, height, rate }: Take, container: Exclude<Container, 'png'>): Promise<FrameSink> {
  if (!canEncode()) throw new Error('This browser encodes no video: choose pictures.');
  // Fetched when it is needed.
  const { BufferTarget, Mp4OutputFormat, Output, Quality, VideoSample, VideoSampleSource, WebMOutputFormat, getFirstEncodableVideoCodec } = await import('mediabunny');
  const quality = new Quality({ bitrate: Math.round(kBitsPerPixel * width * height * rate) });
  const codec = await getFirstEncodableVideoCodec([...kCodecs[container]], { width, height, quality });
  if (!codec) throw new Error(`This browser encodes no ${container === 'mp4' ? 'MP4' : 'WebM'} of ${width} \u00d7 ${height}: choose another format or size.`);
  const target = new BufferTarget(), output = new Output({ format: container === 'mp4' ? new Mp4OutputFormat() : new WebMOutputFormat(), target });
  const source = new VideoSampleSource({ codec, quality, keyFrameInterval: kKeyframes_s });
  output.addVideoTrack(source, { frameRate: rate });
  await output.start();
  return {
    add: async (canvas, index) => {
      const sample = new VideoSample(canvas, { timestamp: index / rate, duration: 1 / rate });
      try {
        await source.add(sample);
      } finally {
        sample.close();
      }
    },
    finish: async () => {
      await output.finalize();
      return { file: new Blob([target.buffer!], { type: `video/${container}` }), name: `flight.${container}` };
    },
    cancel: () => output.cancel(),
  };
}

function pngSink(count: number): FrameSink {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let failure: Error | null = null;
  const zip = new Zip((error, part) => {
    if (error) failure = error;
    else parts.push(part as Uint8Array<ArrayBuffer>);
  });
  return {
    add: async (canvas, index) => {
      const picture = await pngOf(canvas), entry = new ZipPassThrough(frameName(index, count));
      entry.mtime = kFileTime;
      zip.add(entry);
      entry.push(new Uint8Array(await picture.arrayBuffer()), true);
      if (failure) throw failure;
    },
    finish: () => {
      zip.end();
      return Promise.resolve({ file: new Blob(parts, { type: 'application/zip' }), name: 'flight.zip' });
    },
    cancel: () => Promise.resolve(),
  };
}

// What the canvas shows as this is called.
export function pngOf(canvas: HTMLCanvasElement): Promise<Blob> {
  return new Promise((resolve, reject) => canvas.toBlob((picture) => (picture ? resolve(picture) : reject(new Error('The browser makes no picture of this size.'))), 'image/png'));
}
