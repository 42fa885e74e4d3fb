// Whom a terrain's meshes go to: one sink at a time. What has gone to one comes again for the next, made anew by the worker.
import type { MeshUpdate, PartLines } from './core/mesh_update.js';
import { NoSink, StreamSink, type MeshSink } from './mesh_sink.js';
import { ObjectTriangles } from './object_triangles.js';

/** @internal */
export class MeshFeed {
  sink: MeshSink = new NoSink();
  readonly objects = new ObjectTriangles();
  private has_added = false; // to the sink

  // `redraw` makes the worker send all anew.
  constructor(private readonly redraw: () => void) {}

  add(update: MeshUpdate): void {
    this.has_added = true;
    this.objects.add(update);
    this.sink.add(update);
  }
  // The version to make ready next, after each frame.
  want(version: number): void {
    if (this.sink instanceof StreamSink) this.sink.want(version);
  }
  addLines(version: number, terrain: PartLines, objects: PartLines): void {
    this.sink.addLines?.(version, terrain, objects);
  }
  attach(sink: MeshSink): () => void {
    this.sink.reset();
    this.sink = sink;
    if (this.has_added) this.redraw();
    this.has_added = false;
    return () => {
      if (this.sink !== sink) return;
      this.sink = new NoSink();
      this.has_added = true; // what the next one needs has gone to this one
    };
  }
  // `onEnd` is given what ends the stream.
  stream(onEnd: (end: () => void) => void): ReadableStream<MeshUpdate> {
    const sink: StreamSink = new StreamSink(() => detach());
    const detach = this.attach(sink);
    onEnd(() => sink.close());
    return sink.stream;
  }
  // What the sink held is lost.
  lose(): void {
    this.has_added = true;
  }
}
