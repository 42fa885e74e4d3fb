// A client's worker: the connection, the client core's viewer, and the meshes, out of the way of what draws. It sends each mesh as
// soon as it is made, as what changes since the one before, and no more than the drawing thread can hold (kMaxUnstaged).
import { Connection } from './connection.js';
import { Core } from '../core/core.js';
import { failureOf } from '../core/failure.js';
import { Guard } from '../core/guard.js';
import { GroundQueue } from './ground_queue.js';
import { Recording } from './recording.js';
import { Tiles } from './tiles.js';
import { linesOf, memoryOf, updateOf } from '../core/mesh_update.js';
import type { FromWorker, ToWorker } from '../core/messages.js';
import type { Blend, Request, Statistics } from '../core/values.js';
import { Viewer } from './viewer.js';
import { SightAsker } from '../core/sight.js';

const thread = self as unknown as {
  postMessage(message: FromWorker, memory: Transferable[]): void;
  addEventListener<E extends Event>(name: string, listener: (event: E) => void): void;
};

// Meshes that were sent and are not on the graphics card. While there are so many, as behind a page that is not seen, none is sent; the
// next one has all changes since.
const kMaxUnstaged = 8;

// A server ends sessions that say nothing for 30 s. Something is said within ten, though no frame is drawn.
const kQuiet_ms = 5000;

type Start = ToWorker & { kind: 'start' };

class Session {
  private readonly connection: Connection;
  private viewer: Viewer;
  private tiles: Tiles;
  private recording: Recording | null = null;
  private request: Request;
  private blend: Blend;
  private is_scene_running = false;
  private wants_lines: boolean;
  private sun: readonly number[] | null = null; // that casts shadows
  private is_greeted = false; // on this connection
  private was_greeted = false; // on any
  private sent: number[] = []; // versions that are not staged
  private last_version = 0; // that was sent
  private readonly ground = new GroundQueue((positions) => (this.is_greeted ? this.viewer.requestGround(positions) : null),
    (id, ground) => this.post({ kind: 'ground', id, ground },
      ground.undulations_m ? [ground.heights_m.buffer, ground.undulations_m.buffer] : [ground.heights_m.buffer]));
  private tour: string | null = null; // asked for, and has not come; asked for again on a new connection
  private tour_seconds = 0;
  private has_told_damage = false;
  private readonly sights: SightAsker;
  private is_hidden = false;
  private has_spoken = false; // since the last look
  private readonly waker = setInterval(() => guard.run(() => this.keepAwake()), kQuiet_ms);

  constructor(private readonly core: Core, private readonly start: Start) {
    ({ request: this.request, blend: this.blend, wants_lines: this.wants_lines } = start);
    this.viewer = this.newViewer();
    this.tiles = this.newTiles();
    this.sights = new SightAsker(core, () => this.viewer.handle, (answer) => this.post(answer));
    this.connection = new Connection(start.server, {
      onOpen: () => guard.run(() => this.begin()),
      onMessage: (message) => guard.run(() => this.receive(message)),
      onMigrate: () => guard.run(() => this.post({ kind: 'migrate' })),
      onWaiting: (seconds, reason) => guard.run(() => this.post({ kind: 'waiting', seconds, reason })),
      onImpossible: (reason) => guard.run(() => this.post({ kind: 'refused', reason })),
    }, () => this.viewer.area());
    this.connection.open();
  }

  handle(message: ToWorker): void {
    switch (message.kind) {
      case 'start': return;
      case 'frame': return this.frame(message);
      case 'jump':
        this.viewer.jump();
        this.recording?.jump(this.now());
        return;
      case 'request':
        this.request = message.request;
        this.viewer.setRequest(message.request);
        this.recordChoice();
        break;
      case 'blend':
        this.blend = message.blend;
        this.applyBlend();
        break;
      case 'lines': return this.setLines(message.wants_lines);
      case 'scene clock':
        this.viewer.setSceneClock(message.now_ms, message.scene_ms, message.rate);
        this.is_scene_running = message.rate !== 0;
        this.applyBlend();
        break;
      case 'request tour':
        this.requestTour(message.name, message.seconds);
        break;
      case 'start tour':
        this.viewer.startTour(message.start_ms);
        break;
      case 'sun':
        this.sun = message.towards;
        this.viewer.setSun(message.towards);
        break;
      case 'hidden':
        this.is_hidden = message.is_hidden;
        this.connection.setHidden(message.is_hidden);
        break;
      case 'ask sight':
      case 'ask viewshed':
      case 'cancel sight':
      case 'forget sight':
        this.sights.handleMessage(message);
        break;
      case 'redraw': return this.redraw(message.count);
      case 'path':
        this.viewer.announcePath(message.poses, message.start_ms, message.step_ms);
        break;
      case 'ground':
        this.ground.ask(message.id, message.positions);
        break;
      case 'server': return this.connection.setUrl(message.url);
      case 'reopen':
        this.connection.open();
        break;
      case 'save recording': return this.saveRecording();
      case 'close':
        this.end();
        return this.post({ kind: 'closed' });
    }
    this.sendOutgoing();
  }

  // Also after end(), and after a failure.
  saveRecording(): void {
    if (this.recording) this.post({ kind: 'recording', file: this.recording.file() });
  }

  // Calls nothing of the client core, which may have failed.
  end(): void {
    clearInterval(this.waker);
    this.connection.close();
    this.tiles.stop();
  }

  private post(message: FromWorker, memory: Transferable[] = []): void {
    thread.postMessage(message, memory);
  }

  // The drawing thread's.
  private now(): number {
    return performance.now() + performance.timeOrigin - this.start.clock_origin_ms;
  }

  private newViewer(): Viewer {
    const viewer = new Viewer(this.core, this.request);
    viewer.setBlend(this.blendInForce());
    viewer.drawAhead();
    viewer.setTextureLayers(this.start.texture_layers);
    viewer.setSun(this.sun);
    return viewer;
  }
  private newTiles(): Tiles {
    return new Tiles(this.viewer, guard, (what) => this.tellDamage(what));
  }

  // Once: the read-out counts the others.
  private tellDamage(what: string): void {
    if (this.has_told_damage) return;
    this.has_told_damage = true;
    console.warn(`A tile cannot be decoded, and counts as missing: ${what}`);
    this.post({ kind: 'damaged', what });
  }

  // Begins a session on a new connection. After a lost connection the viewer resumes from the section that it holds.
  private begin(): void {
    this.is_greeted = false;
    if (this.was_greeted) {
      const now_ms = this.now();
      this.viewer.reconnect(now_ms);
      this.recording?.reconnect(now_ms);
    } else {
      this.recording = this.start.is_recorded ? new Recording(this.request, this.blend) : null;
      this.tiles.stop();
      this.viewer.destroy();
      this.viewer = this.newViewer();
      this.tiles = this.newTiles();
    }
    if (this.tour !== null) this.viewer.requestTour(this.tour, this.tour_seconds);
    this.sights.begin();
    this.post({ kind: 'open' });
    this.sendOutgoing();
  }

  private requestTour(name: string, seconds: number): void {
    [this.tour, this.tour_seconds] = [name, seconds];
    if (this.connection.isOpen()) this.viewer.requestTour(name, seconds);
  }

  // Splines do not go with scene time that runs (docs/decisions/0015).
  private blendInForce(): Blend {
    const is_spline = this.blend !== 'keyframe' && this.blend !== 'geomorph';
    return is_spline && this.is_scene_running ? 'keyframe' : this.blend;
  }
  private applyBlend(): void {
    this.viewer.setBlend(this.blendInForce());
    this.recordChoice();
  }

  private recordChoice(): void {
    this.recording?.choose(this.now(), this.request, this.blendInForce());
  }

  private receive(message: Uint8Array): void {
    const now_ms = this.now();
    this.recording?.message(now_ms, message);
    const refusal = this.viewer.receive(message, now_ms);
    if (refusal !== null) {
      this.connection.close();
      this.post({ kind: 'refused', reason: refusal });
      return;
    }
    if (!this.is_greeted && this.viewer.isGreeted()) {
      this.is_greeted = this.was_greeted = true;
      this.post({ kind: 'welcome', message });
      this.ground.askAgain();
      this.sendOutgoing();
    } else if (this.viewer.takeTour()) {
      this.tour = null;
      this.post({ kind: 'tour', message });
    }
    const ground = this.ground.request === null ? null : this.viewer.takeGround(this.ground.request);
    if (ground) {
      this.ground.take(ground.id, ground.ground);
      this.sendOutgoing();
    }
    this.sights.received(message);
    this.sendMesh();
  }

  private frame({ now_ms, pose, eye, ground_reach, staged_version }: ToWorker & { kind: 'frame' }): void {
    this.sent = this.sent.filter((version) => version > staged_version);
    this.viewer.frame(now_ms, pose);
    this.recording?.frame(now_ms, pose);
    this.sendOutgoing();
    this.sendMesh();
    const ground = this.is_greeted ? this.viewer.ground(eye, ground_reach) : null;
    this.post({ kind: 'state', statistics: this.statistics(), is_open: this.connection.isOpen(), area: this.viewer.area(), ground });
  }

  private statistics(): Statistics {
    const statistics = this.viewer.statistics();
    if (statistics.damaged_tiles > 0) this.tellDamage('relief');
    return { ...statistics, damaged_tiles: statistics.damaged_tiles + this.tiles.damaged };
  }

  private sendMesh(): void {
    if (this.sent.length >= kMaxUnstaged || !this.viewer.takeNewest()) return;
    const interval = this.viewer.interval();
    const tiles = this.tiles.take();
    const changes = this.viewer.takeChanges();
    const { nodes_added, nodes_removed } = this.viewer.statistics();
    const update = updateOf(this.viewer.mesh(), changes, interval, this.last_version, this.wants_lines, tiles, nodes_added + nodes_removed);
    this.last_version = update.version;
    this.sent.push(update.version);
    this.post({ kind: 'mesh', update }, memoryOf(update));
  }

  // The drawing thread has lost all that it was sent.
  private redraw(count: number): void {
    this.viewer.redraw();
    this.tiles.stop();
    this.tiles = this.newTiles();
    [this.sent, this.last_version] = [[], 0];
    this.post({ kind: 'redrawn', count });
    this.sendMesh();
  }

  private setLines(wants_lines: boolean): void {
    this.wants_lines = wants_lines;
    if (!wants_lines || this.last_version === 0) return;
    const { terrain, objects } = linesOf(this.viewer.mesh(), true);
    this.post({ kind: 'lines', version: this.last_version, terrain, objects }, [terrain.data.buffer, objects.data.buffer]);
  }

  private sendOutgoing(): void {
    for (let message = this.viewer.takeOutgoing(); message; message = this.viewer.takeOutgoing()) {
      this.connection.send(message);
      this.has_spoken = true;
    }
  }

  // For programs that draw no frames. A page that nobody sees may be left by the server.
  private keepAwake(): void {
    if (!this.has_spoken && this.is_greeted && !this.is_hidden) {
      this.viewer.saySomething();
      this.sendOutgoing();
    }
    this.has_spoken = false;
  }
}

let session: Session | null = null;
const early: ToWorker[] = []; // what was said before the session was there

const guard = new Guard((error) => {
  session?.end();
  thread.postMessage({ kind: 'failed', failure: failureOf(error) }, []);
});

async function begin(message: Start): Promise<void> {
  const begun = (session = new Session(await Core.of(message.module), message));
  for (const said of early.splice(0)) guard.run(() => begun.handle(said));
}

function receive(message: ToWorker): void {
  if (message.kind === 'start') void guard.runToEnd(() => begin(message));
  else if (guard.isOver && message.kind === 'save recording') session?.saveRecording();
  else if (guard.isOver && message.kind === 'close') thread.postMessage({ kind: 'closed' }, []);
  else if (message.kind === 'close' && !session) thread.postMessage({ kind: 'closed' }, []);
  else guard.run(() => (session ? session.handle(message) : early.push(message)));
}

thread.addEventListener<MessageEvent<ToWorker>>('message', ({ data }) => receive(data));
thread.addEventListener('messageerror', () => guard.fail(new Error('A message of the page could not be read.')));
// What no guard has seen.
thread.addEventListener<ErrorEvent>('error', (event) => {
  event.preventDefault();
  guard.fail(event.error ?? event.message);
});
thread.addEventListener<PromiseRejectionEvent>('unhandledrejection', (event) => {
  event.preventDefault();
  guard.fail(event.reason);
});
