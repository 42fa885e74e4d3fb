// The worker's end of relief and imagery: tiles are decoded a few at a time, between messages, and those that come with a mesh are
// handed over with it. The client core decides which (client/imagery/residency.h).
import { reasonOf } from '../core/failure.js';
import type { Guard } from '../core/guard.js';
import type { TileUpdate, TileUpload } from '../core/tile_update.js';
import { kContents, type Content, type TileArrival, type TileSelection } from '../core/values.js';
import type { Viewer } from './viewer.js';

const kMaxDecoding = 4; // images at a time

type Key = readonly [number, number];
const nameOf = ([low, high]: Key) => `${high} ${low}`;

export class Tiles {
  private readonly images = new Map<string, ImageBitmap>(); // decoded, and not handed over
  private decoding = 0;
  private is_scheduled = false;
  private is_stopped = false;
  damaged = 0; // images that could not be decoded

  // What fails beside an image ends the guard's thread. `onDamaged` is told of each damaged image.
  constructor(private readonly viewer: Viewer, private readonly guard: Guard, private readonly onDamaged: (what: string) => void) {}

  // What is drawn with the mesh that was taken.
  take(): Record<Content, TileUpdate | null> {
    const [relief, imagery] = kContents.map((content) => this.updateOf(content, this.viewer.tiles(content)));
    this.schedule();
    return { relief: relief!, imagery: imagery! };
  }

  // The viewer is not to be used any more.
  stop(): void {
    this.is_stopped = true;
    for (const image of this.images.values()) image.close();
    this.images.clear();
  }

  private updateOf(content: Content, selection: TileSelection | null): TileUpdate | null {
    if (!selection) return null;
    const { scene, shown, page_table } = selection;
    const uploads = selection.arrivals.map((arrival) => this.uploadOf(content, arrival));
    for (const key of selection.dropped) {
      this.images.get(nameOf(key))?.close();
      this.images.delete(nameOf(key));
    }
    return { scene, shown, page_table, uploads };
  }

  private uploadOf(content: Content, { key, layer, parent_layer, is_relit }: TileArrival): TileUpload {
    const image = this.images.get(nameOf(key)) ?? null;
    this.images.delete(nameOf(key));
    const is_odd = [(key[0] & 1) === 1, ((key[0] >>> 24) & 1) === 1] as const;
    const upload = { layer, parent_layer, is_odd, image, slopes: null, ground: null };
    if (content === 'imagery') return upload;
    const ground = [this.viewer.groundTexels(key, false), this.viewer.groundTexels(key, true)] as const;
    return { ...upload, ground, slopes: is_relit ? null : [this.viewer.slopes(key, false), this.viewer.slopes(key, true)] };
  }

  private schedule(): void {
    if (this.is_scheduled || this.is_stopped) return;
    this.is_scheduled = true;
    setTimeout(() => this.guard.run(() => {
      this.is_scheduled = false;
      if (!this.is_stopped && this.decodeSome()) this.schedule();
    }), 0);
  }

  // Whether there may be more.
  private decodeSome(): boolean {
    while (this.decoding < kMaxDecoding) {
      const next = this.viewer.nextImage();
      if (!next) break;
      ++this.decoding;
      void this.guard.runToEnd(() => this.decodeImage(next.key, next.coded));
    }
    return this.viewer.decodeRelief();
  }

  // An image that is damaged never becomes ready, as if it had not come: its parent stays in its place.
  private async decodeImage(key: Key, coded: Uint8Array<ArrayBuffer>): Promise<void> {
    const image = await bitmapOf(coded).catch((error: unknown) => {
      ++this.damaged;
      this.onDamaged(`imagery ${nameOf(key)}: ${reasonOf(error)}`);
      return null;
    });
    --this.decoding;
    if (this.is_stopped) return image?.close();
    if (image) {
      this.images.set(nameOf(key), image);
      this.viewer.imageReady(key);
    }
    this.schedule();
  }
}

async function bitmapOf(coded: Uint8Array<ArrayBuffer>): Promise<ImageBitmap> {
  return createImageBitmap(new Blob([coded], { type: 'image/webp' }), { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}
