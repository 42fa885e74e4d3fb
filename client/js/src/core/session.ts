// The drawing thread's end of a session: what comes from the worker, and what it is told.
import type { Core } from './core.js';
import type { Failure } from './failure.js';
import type { Guard } from './guard.js';
import type { PartLines, MeshUpdate } from './mesh_update.js';
import type { ExactGround, FromWorker, ToWorker } from './messages.js';
import { Screen } from './screen.js';
import { Sights } from './sight.js';
import type { Pose, Statistics } from './values.js';

// A worker of a browser, or what stands for one elsewhere.
export interface WorkerLike {
  postMessage(message: unknown): void;
  terminate(): void;
  onmessage: ((event: any) => void) | null;
  onmessageerror: ((event: any) => void) | null;
  onerror: ((event: any) => void) | null;
}

export interface SessionEvents {
  onOpen(): void;
  onWaiting(seconds: number, reason: string): void; // a sentence, or empty
  onRefused(reason: string): void;
  onWelcome(message: Uint8Array): void;
  onMesh(update: MeshUpdate): void;
  onMigrate(): void;
  onClosed(): void;
  onGround(id: number, ground: ExactGround): void;
  onLines(version: number, terrain: PartLines, objects: PartLines): void;
  onRecording(file: Blob): void;
  onDamaged(what: string): void; // the first tile that cannot be decoded
  onFailure(failure: Failure): void; // of the worker, which has logged it; only a recording can still come
}

export const kNoStatistics: Statistics = {
  bytes_down: 0, bytes_up: 0, last_lateness_ms: 0, worst_lateness_ms: 0, nodes_added: 0, nodes_removed: 0, keyframes: 0, late_keyframes: 0,
  tiles: 0, tile_bytes: 0, tiles_received: 0, relief_texel_px: Infinity, imagery_texel_px: Infinity, damaged_tiles: 0,
};

export class Session {
  readonly screen: Screen;
  readonly sights: Sights;
  is_open = false;
  statistics: Statistics = kNoStatistics;
  area: number | null = null; // of a large scene, that the camera is in
  private tour: Uint8Array | null = null; // has come, and has not been started
  private redraws = 0; // how often mesh and tiles were to come again
  private is_redrawn = true; // the meshes that come now are of the last of these

  // What is received is handled under `guard`.
  constructor(core: Core, private readonly worker: WorkerLike, private readonly events: SessionEvents, guard: Guard) {
    this.screen = new Screen(core);
    this.sights = new Sights(core, (message) => this.tell(message));
    worker.onmessage = ({ data }: { data: FromWorker }) => {
      if (data.kind === 'recording') events.onRecording(data.file);
      else if (data.kind === 'closed') events.onClosed();
      else guard.run(() => this.receive(data));
    };
    worker.onmessageerror = () => guard.fail(new Error('A message of its worker could not be read.'));
    worker.onerror = (event) => events.onFailure(failureOfWorker(event));
  }

  // Whether nobody sees what is drawn.
  setHidden(is_hidden: boolean): void {
    this.tell({ kind: 'hidden', is_hidden });
  }

  tell(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  frame(now_ms: number, pose: Pose, eye: readonly number[], ground_reach: number, staged_version: number): void {
    this.tell({ kind: 'frame', now_ms, pose, eye, ground_reach, staged_version });
  }

  // Ends it for good.
  close(): void {
    this.is_open = false;
    this.tell({ kind: 'close' });
  }

  // The camera of the next frame is jumped to.
  jump(): void {
    this.screen.jump();
    this.tell({ kind: 'jump' });
  }

  // All that was handed over is lost: meshes that come are left out, until they come again after redraw().
  leaveOutMeshes(): void {
    this.is_redrawn = false;
  }
  redraw(): void {
    this.is_redrawn = false;
    this.screen.redraw();
    this.tell({ kind: 'redraw', count: ++this.redraws });
  }

  requestTour(name: string, seconds: number): void {
    this.tour = null;
    this.tell({ kind: 'request tour', name, seconds });
  }
  // Whether a tour waits to be started.
  hasTour(): boolean {
    return this.tour !== null;
  }
  startTour(start_ms: number): void {
    this.screen.startTour(this.tour!, start_ms);
    this.tour = null;
    this.tell({ kind: 'start tour', start_ms });
  }

  private receive(message: FromWorker): void {
    switch (message.kind) {
      case 'open': return this.events.onOpen();
      case 'waiting':
        this.is_open = false;
        return this.events.onWaiting(message.seconds, message.reason);
      case 'migrate': return this.events.onMigrate();
      case 'ground': return this.events.onGround(message.id, message.ground);
      case 'closed': case 'recording': return; // above
      case 'refused': return this.events.onRefused(message.reason);
      case 'welcome':
        this.is_open = true;
        return this.events.onWelcome(message.message);
      case 'tour':
        this.tour = message.message;
        return;
      case 'redrawn':
        this.is_redrawn = message.count === this.redraws;
        return;
      case 'mesh':
        if (!this.is_redrawn) return;
        this.screen.add(message.update.interval, message.update.oldest_version);
        return this.events.onMesh(message.update);
      case 'lines': return this.is_redrawn ? this.events.onLines(message.version, message.terrain, message.objects) : undefined;
      case 'sight asked':
      case 'sight':
      case 'sight lost': return this.sights.receive(message);
      case 'damaged': return this.events.onDamaged(message.what);
      case 'failed': return this.events.onFailure(message.failure);
      case 'state':
        this.statistics = message.statistics;
        [this.is_open, this.area] = [message.is_open, message.area];
        if (message.ground) this.screen.setGround(message.ground);
    }
  }
}

// An event without a message is of a worker that cannot be loaded. The browser logs others.
export function failureOfWorker({ message, did_start = true }: { message?: string; did_start?: boolean }): Failure {
  if (message && did_start) return { part: 'page', reason: message };
  console.error('The worker did not load.');
  return { part: 'worker start', reason: message ?? '' };
}
