// Who takes meshes from a terrain: what draws them, a reader of `updates`, or nobody.
import type { MeshUpdate, PartLines } from './core/mesh_update.js';

/** What draws a terrain (`ForelandTerrain`, or an engine's own). One at a time takes a terrain's meshes. */
export interface MeshSink {
  /** Takes what changes from the version before. */
  add(update: MeshUpdate): void;
  /** Takes the edges of a mesh that came without. */
  addLines?(version: number, terrain: PartLines, objects: PartLines): void;
  /** Forgets all that was added: it comes again. */
  reset(): void;
  /** The newest version that can be shown. */
  readonly ready: number;
  /** The version that is being made ready; 0: none. */
  readonly coming: number;
  /** The newest version that is where it is drawn from, or on its way. While too many are not, no more come. */
  readonly staged: number;
}

const kAllReady = 0xffffffff; // as in client/schedule.h

/** @internal Of a terrain that nobody draws: what comes is ready whenever its time comes, and forgotten. */
export class NoSink implements MeshSink {
  staged = 0;
  readonly coming = 0;
  get ready(): number {
    return this.staged > 0 ? kAllReady : 0;
  }
  add(update: MeshUpdate): void {
    this.staged = update.version;
  }
  reset(): void {
    this.staged = 0;
  }
}

/**
 * @internal A stream of updates: one that has been read counts as drawn in place of the one before. So none is given before it is the next to
 * be shown: whoever reads as fast as it can would otherwise have replaced a mesh before its time came.
 */
export class StreamSink implements MeshSink {
  readonly stream: ReadableStream<MeshUpdate>;
  ready = 0;
  readonly coming = 0;
  private readonly waiting: MeshUpdate[] = [];
  private controller!: ReadableStreamDefaultController<MeshUpdate>;
  private wants = false;
  private next_version = 0;

  constructor(onCancel: () => void) {
    this.stream = new ReadableStream<MeshUpdate>({
      start: (controller) => void (this.controller = controller),
      pull: () => {
        this.wants = true;
        this.give();
      },
      cancel: onCancel,
    }, { highWaterMark: 0 });
  }
  get staged(): number {
    return this.ready;
  }
  add(update: MeshUpdate): void {
    this.waiting.push(update);
  }
  reset(): void {
    this.waiting.length = 0;
    this.ready = this.next_version = 0;
  }
  // The version to make ready next, after each frame.
  want(version: number): void {
    this.next_version = version;
    this.give();
  }
  close(): void {
    try {
      this.controller.close();
    } catch {
      // It was cancelled.
    }
  }

  private give(): void {
    if (!this.wants || !this.waiting[0] || this.waiting[0].version > this.next_version) return;
    const next = this.waiting.shift()!;
    this.wants = false;
    this.ready = next.version;
    this.controller.enqueue(next);
  }
}
