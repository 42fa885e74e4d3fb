// What a terrain tells of itself.
import type { ForelandError } from './errors.js';
import type { Scene } from './scene.js';

/** The events of a `Terrain`, by name, with what a listener is given. */
export interface TerrainEvents {
  /** A session has begun: at first, and on every later connection. */
  scene: Scene;
  /** What a frame's error is guaranteed not to exceed has changed; null: nothing is guaranteed. */
  guarantee: number | null;
  /** There is no connection: it is tried again in so many seconds. `reason` is a sentence, or empty. */
  stall: { seconds: number; reason: string };
  /** The server hands its viewers over to another one: the connection is opened anew at once. */
  migrate: void;
  /** Which credits are due for what is drawn has changed. */
  attributions: readonly string[];
  /** Something is amiss that ends nothing: a tile is damaged, an image of a model did not come. */
  warning: string;
  /** The server has ended the session, and it is not tried again by itself: `reconnect()` does. */
  refused: ForelandError;
  /** The client has failed, and nothing comes any more. */
  error: ForelandError;
  closed: void;
}

type Listener<T> = (value: T) => void;

/** @internal */
export class Emitter {
  private readonly listeners = new Map<keyof TerrainEvents, Set<Listener<any>>>();

  on<K extends keyof TerrainEvents>(name: K, listener: Listener<TerrainEvents[K]>): () => void {
    const set = this.listeners.get(name) ?? new Set();
    this.listeners.set(name, set.add(listener));
    return () => void set.delete(listener);
  }
  // A listener that throws is reported, and stops nobody else.
  emit<K extends keyof TerrainEvents>(name: K, value: TerrainEvents[K]): void {
    for (const listener of [...(this.listeners.get(name) ?? [])]) {
      try {
        listener(value);
      } catch (error) {
        console.error(error);
      }
    }
  }
  clear(): void {
    this.listeners.clear();
  }
}
