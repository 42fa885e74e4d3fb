// A terrain that a server streams: the session's end in the thread that draws. Connection, decoding and meshes are in a worker.
import type { Core } from './core/core.js';
import { failureOf } from './core/failure.js';
import { Guard } from './core/guard.js';
import { kNoStatistics, Session, type WorkerLike } from './core/session.js';
import type { Pose, Request, Statistics, Welcome } from './core/values.js';
import type { Screen } from './core/screen.js';
import { errorOf, ForelandError } from './errors.js';
import { Emitter, type TerrainEvents } from './events.js';
import { frameOf, kNoFrame, type Frame } from './frame.js';
import { GroundReach } from './ground_reach.js';
import { HeightQuestions } from './height_questions.js';
import { theHost } from './host.js';
import { MeshFeed } from './mesh_feed.js';
import type { MeshSink } from './mesh_sink.js';
import type { ExactGround } from './core/messages.js';
import type { MeshUpdate } from './core/mesh_update.js';
import { layersOf, type Lens, type Limits, type OpenOptions, type TerrainOptions } from './options.js';
import type { Hit } from './object_triangles.js';
import { awaitSession, loadCore, makeWorker } from './opening.js';
import { Places } from './places.js';
import { bothHeights, sceneOf, type BothHeights, type MapPoint, type Place, type Scene, type Vector } from './scene.js';
import { askViewshed, askVisible, reported, type Sight, type SightOptions, type Viewshed, type ViewshedQuestion } from './sight.js';
import { filesAt, viewersAt } from './server_address.js';
import { Wishes } from './wishes.js';

const kClosing_ms = 2000; // that a worker is given to answer

/** A position and where it looks from: eye in the scene's axes, metres; orientation x, y, z, w of a camera that looks along its -z, y up. */
export type { Pose };

export class Terrain {
  private readonly emitter = new Emitter();
  private readonly guard = new Guard((error) => this.fail(errorOf(failureOf(error))));
  private readonly questions = new HeightQuestions((id, positions) => this.tell({ kind: 'ground', id, positions }));
  private readonly feed = new MeshFeed(() => this.session?.redraw());
  private readonly reach = new GroundReach();
  private readonly wishes: Wishes;
  private readonly viewers: URL;
  private session: Session | null = null;
  private worker: WorkerLike | null = null;
  private unwatch = () => {};
  private is_sized = true;
  private is_document_hidden = false;
  private current: { welcome: Welcome; scene: Scene; places: Places } | null = null;
  private wants_lines = false;
  private may_occlude = false; // this connection's deltas can tell hidden blocks
  private last: Frame | null = null;
  private guaranteed: number | null = null;
  private attributed = '';
  private end: ForelandError | null = null; // why nothing comes any more
  private is_closing = false;
  private onClosedByWorker = () => {};
  private onRecording: ((file: Blob) => void) | null = null;
  private readonly signal: AbortSignal | undefined;
  private readonly abort = () => void this.close();

  /** Settles with the first session: resolves as it begins, rejects if it never will. */
  readonly ready: Promise<void>;
  private resolveReady!: () => void;
  private rejectReady!: (error: ForelandError) => void;

  private constructor(server: string | URL, private readonly opening: OpenOptions) {
    this.viewers = viewersAt(server, opening.token, typeof location === 'undefined' ? undefined : location.href);
    this.wishes = new Wishes(opening);
    this.ready = new Promise((resolve, reject) => ([this.resolveReady, this.rejectReady] = [resolve, reject]));
    this.ready.catch(() => {}); // whoever awaits it is told
    this.signal = opening.signal;
    this.signal?.addEventListener('abort', this.abort, { once: true });
    if (this.signal?.aborted) this.fail(new ForelandError('closed', 'The opening of the terrain was aborted.'));
    else void this.start();
  }

  /** Begins a session and gives the terrain at once; `ready` and the events tell what comes of it. Throws for an address that is none. */
  static connect(server: string | URL, options: OpenOptions = {}): Terrain {
    return new Terrain(server, options);
  }

  /**
   * Begins a session with a server, `wss://host/`, and resolves as it has begun. Rejects with a `ForelandError`. A connection that is lost
   * later is made anew by itself.
   */
  static async open(server: string | URL, options: OpenOptions = {}): Promise<Terrain> {
    const terrain = Terrain.connect(server, options);
    let last_reason = '';
    const off = terrain.on('stall', ({ reason }) => (last_reason = reason || last_reason));
    const stopWaiting = awaitSession(terrain.server, options.patienceMs ?? 30_000, () => last_reason, (error) => terrain.rejectReady(error));
    try {
      await terrain.ready;
      return terrain;
    } catch (error) {
      await terrain.close();
      throw error;
    } finally {
      off();
      stopWaiting();
    }
  }

  // ---- what it is

  /** The address that it connects to, without its token and its area. */
  get server(): string {
    const url = new URL(this.viewers);
    for (const own of ['token', 'area']) url.searchParams.delete(own);
    return url.href;
  }
  /** The address of the server's files, which images of models lie below. */
  get files(): URL {
    return filesAt(this.viewers);
  }
  /** What it was given to take. */
  get limits(): Limits {
    return this.wishes.limits;
  }
  /** Whether a session has begun, so that `scene` is known. */
  get hasScene(): boolean {
    return this.current !== null;
  }
  /** The scene. Throws before a session has begun. */
  get scene(): Scene {
    if (!this.current) throw this.end ?? new ForelandError('closed', 'No session has begun yet.', 'Wait for `ready`, or open with `Terrain.open`.');
    return this.current.scene;
  }
  /** Whether there is a connection with a session now. */
  get isConnected(): boolean {
    return this.session?.is_open ?? false;
  }
  /** Whether nothing comes any more: it was closed, or has failed. */
  get isOver(): boolean {
    return this.end !== null;
  }
  /** Counts of what has come and gone. */
  get stats(): Statistics {
    return this.session?.statistics ?? kNoStatistics;
  }
  /**
   * The area of a large scene that the camera is in: a number of a square of 2,048 samples, or null. Where the terrain connects anew it says
   * so by itself; the address of a first connection may say it (`?area=17`), where a link leads to a place.
   */
  get area(): number | null {
    return this.session?.area ?? null;
  }
  /** The last frame; null before the first. */
  get lastFrame(): Frame | null {
    return this.last;
  }
  /** What is asked of the server now. */
  get request(): Readonly<Request> {
    return this.wishes.request;
  }

  /** Calls `listener` whenever something happens; the function that it gives ends that. */
  on<K extends keyof TerrainEvents>(name: K, listener: (value: TerrainEvents[K]) => void): () => void {
    return this.emitter.on(name, listener);
  }

  // ---- what is wanted

  /** The camera's angle, and the picture's size in pixels. Call it after resizing, not for each step of it. */
  setLens(lens: Lens): void {
    if (this.wishes.setLens(lens)) this.sendRequest();
  }
  /** Changes what is given, and leaves the rest. */
  setOptions(options: TerrainOptions): void {
    const { wishes } = this, { blend } = wishes.options;
    wishes.options = { ...wishes.options, ...options };
    if (wishes.options.blend !== blend) this.tell({ kind: 'blend', blend: wishes.options.blend ?? 'keyframe' });
    this.sendRequest();
    if (this.isConnected && (wishes.options.occlusion ?? true) && !this.may_occlude) this.tell({ kind: 'reopen' });
  }
  /** From now on shows the ground of scene time `at`, milliseconds since 1970, which goes at `rate` scene seconds a second. */
  setSceneTime({ at, rate = 0 }: { at: number; rate?: number }): void {
    this.tell({ kind: 'scene clock', now_ms: performance.now(), scene_ms: at, rate });
  }
  /** Towards the sun whose shadows, of ground on ground, come with the relief; null: none. */
  setSun(towards: Readonly<Vector> | null): void {
    this.tell({ kind: 'sun', towards });
  }
  /** Whether the edges of meshes come with them. */
  setLines(wanted: boolean): void {
    this.wants_lines = wanted;
    this.tell({ kind: 'lines', wants_lines: wanted });
  }
  /** Whether what is drawn has a size, so that it can be seen. A terrain that nobody sees, as in a hidden page, does not connect anew. */
  setSized(is_sized: boolean): void {
    if (is_sized === this.is_sized) return;
    this.is_sized = is_sized;
    this.tellHidden();
  }
  /** For the next connection: a token that replaces one that expires. */
  setToken(token: string): void {
    this.viewers.searchParams.set('token', token);
    this.tell({ kind: 'server', url: this.viewers.href });
  }
  /** Connects anew at once: after `refused`, or where waiting is too long. What is held is resumed from. */
  reconnect(): void {
    this.tell({ kind: 'reopen' });
  }

  // ---- a frame

  /**
   * What to draw at `now`, on the clock of `performance.now()`, with the camera at `pose`. Once for each picture, also while nothing is
   * there yet: it is what tells the server where the camera is. `eye` is where ground is needed, if that is elsewhere.
   */
  frame(now: number, pose: Pose, eye: readonly number[] = pose.eye): Frame {
    if (!this.session || this.end) return this.last ?? { ...kNoFrame, pose, shownTime: now };
    const { session, feed: { sink } } = this;
    const shown = session.screen.frame(now, pose, this.wishes.requestedLens, this.wishes.options.strategy ?? 'predict', sink.ready, sink.coming);
    this.last = frameOf(shown);
    this.tellGuarantee(this.last.guaranteedPx);
    this.feed.want(shown.next_version);
    session.frame(now, pose, eye, this.current ? this.reach.of(this.current.welcome, eye) : 1, sink.staged);
    return this.last;
  }
  /** The camera of the next frame will not have moved there, but jumped. */
  jump(): void {
    this.session?.jump();
  }
  /** The version of the mesh to make ready next; 0: none. */
  get nextVersion(): number {
    return this.session?.screen.next() ?? 0;
  }

  // ---- where the camera will be

  /**
   * Announces that the camera takes these poses in even steps, from `start` on; the server then knows and need not foresee. An empty path
   * ends that.
   */
  announcePath(poses: readonly Pose[], { start, stepMs }: { start: number; stepMs: number } = { start: performance.now(), stepMs: 100 }): void {
    const numbers = this.wishes.setPath(poses, stepMs);
    if (poses.length > 0) this.tell({ kind: 'path', start_ms: start, step_ms: stepMs, poses: numbers });
    this.sendRequest();
  }
  /** Asks the server for one of its tours: survey, canyon, spin, orbit. `hasTour` says when it has come. */
  requestTour(name: string, seconds: number): void {
    if (this.session) this.session.requestTour(name, seconds);
    else this.tell({ kind: 'request tour', name, seconds });
  }
  get hasTour(): boolean {
    return this.session?.hasTour() ?? false;
  }
  /** Begins the tour that has come, and announces it. */
  startTour(start: number): void {
    this.session?.startTour(start);
  }
  /** Where the camera is on the tour; null once that is over. */
  tourPose(now: number): Pose | null {
    return this.session?.screen.tourPose(now) ?? null;
  }

  // ---- where things are

  /** A point of the scene in the coordinates of the data's owner, with the ground there. Null before a session has begun. */
  place(point: Readonly<Vector> | readonly number[]): Place | null {
    return this.current?.places.at(point) ?? null;
  }
  /** Longitude and latitude, or easting and northing, and height of a point of the scene. */
  toGeodetic(point: Readonly<Vector>): Place {
    return this.place(point) ?? this.noScene();
  }
  /** The point of the scene at a place; `height` is 0 where it is not given. */
  toScene(place: MapPoint): Vector {
    return (this.current ?? this.noScene()).places.toScene(place) ?? this.noScene();
  }
  /** Height of the ground that is held at a place, above the zero surface, at once; null where none is known. */
  heightNow(place: MapPoint): number | null {
    return this.place(this.toScene(place))?.ground ?? null;
  }
  /** Exact heights of the ground, of the server, at full resolution; NaN beyond the data. At most 65,536 places at once. */
  async heights(places: readonly MapPoint[]): Promise<Float64Array> {
    return Float64Array.from((await this.exactGround(places)).heights_m);
  }
  /** The same, by both surfaces: above the sea and above the ellipsoid, as far as the scene knows them (`Scene.vertical`). */
  async bothHeights(places: readonly MapPoint[]): Promise<(BothHeights & { height: number })[]> {
    const { heights_m, undulations_m } = await this.exactGround(places);
    const { above } = this.scene.vertical;
    return Array.from(heights_m, (height, i) => ({ height, ...bothHeights(above, height, undulations_m?.[i] ?? null) }));
  }
  private async exactGround(places: readonly MapPoint[]): Promise<ExactGround> {
    HeightQuestions.check(places.length);
    if (this.end) throw this.end;
    if (places.length === 0) return { heights_m: new Float32Array(), undulations_m: null };
    return this.questions.ask(places.map((place) => this.latticeOf(place)));
  }
  /**
   * Whether the second place of each pair is seen from the first, and what hides it: of the server, exactly, over the ground at full
   * resolution and every object. At most 4,096 pairs at once.
   */
  async visible(pairs: readonly (readonly [from: MapPoint, to: MapPoint])[], options: SightOptions = {}): Promise<Sight[]> {
    return askVisible(this.sights(), (place) => this.latticeOf(place), pairs, options);
  }
  /**
   * What of the ground is seen from a place: of the server, cell by cell, each by a line of sight of its own. `onProgress` is called as
   * cells become known, with one and the same viewshed. One at a time: another one ends the one before, which rejects.
   */
  async viewshed(question: ViewshedQuestion, onProgress: (viewshed: Viewshed) => void = () => {}): Promise<Viewshed> {
    return askViewshed(this.sights(), (place) => this.latticeOf(place), question, reported(onProgress));
  }
  private sights(): Session['sights'] {
    return this.end || !this.session ? this.noScene() : this.session.sights;
  }
  private latticeOf(place: MapPoint): [number, number] {
    return (this.current ?? this.noScene()).places.latticeOf(place);
  }
  /** Where an eye comes to that moves from one point of the scene towards another, so far above the ground that is held. */
  sweep(from: readonly number[], to: readonly number[], clearance: number): Vector {
    return this.session ? this.session.screen.sweep(from, to, clearance) : [to[0]!, to[1]!, to[2]!];
  }
  /** Where a ray meets the ground that is held, in the scene's axes; null if it does not. Found to a thousandth of its length. */
  raycast(origin: readonly number[], direction: readonly number[], far = Infinity): Vector | null {
    return this.current?.places.groundOnRay(origin, direction, far) ?? null;
  }
  /**
   * What a ray meets first, ground or an object of the scene, as `raycast` does: of what is held, at once. `visible` tells the same exactly,
   * of the server.
   */
  pick(origin: readonly number[], direction: readonly number[], far = Infinity): Hit | null {
    return this.current?.places.pick(this.feed.objects, origin, direction, far) ?? null;
  }

  // ---- who draws

  /** Gives the meshes to what draws them, instead of to whom they went before. The function that it gives ends that. */
  attach(sink: MeshSink): () => void {
    return this.feed.attach(sink);
  }
  /**
   * What changes in the mesh, for engines other than three. `frame` shows no version that has not been read, and none can be read before it is
   * the next to be shown. One stream at a time.
   */
  get updates(): ReadableStream<MeshUpdate> {
    return this.feed.stream((end) => this.on('closed', end));
  }
  /** @internal What draws was lost: what comes is left out until something is attached. */
  leaveOutMeshes(): void {
    this.session?.leaveOutMeshes();
    this.feed.lose();
  }
  /** @internal */
  get screen(): Screen | null {
    return this.session?.screen ?? null;
  }
  /** @internal */
  get welcome(): Welcome | null {
    return this.current?.welcome ?? null;
  }
  /** @internal Of what is drawn. */
  noteAttributions(texts: readonly string[]): void {
    const text = JSON.stringify(texts);
    if (text === this.attributed) return;
    this.attributed = text;
    this.emitter.emit('attributions', texts);
  }
  /** @internal */
  warn(text: string): void {
    this.emitter.emit('warning', text);
  }

  /** All that has come, as a file that `foreland replay` flies again. Only if opened with `record`. */
  async saveRecording(): Promise<Blob> {
    if (!this.opening.record || !this.session) throw new ForelandError('argument', 'This terrain keeps no recording.', 'Open it with `record: true`.');
    return new Promise((resolve) => {
      this.onRecording = resolve;
      this.session!.tell({ kind: 'save recording' });
    });
  }

  // ---- the end

  /** Ends the session at once, and leaves what is drawn as it is; a recording can still be saved. `close` is still to be called. */
  halt(): void {
    if (this.end) return;
    this.over(new ForelandError('closed', 'The terrain has been halted.'));
    this.session?.close();
  }
  /** Ends the session, the worker and all promises. Resolves as nothing of it runs any more. */
  async close(): Promise<void> {
    if (this.is_closing) return;
    this.is_closing = true;
    const { session, worker } = this;
    this.feed.sink.reset();
    this.over(new ForelandError('closed', 'The terrain has been closed.'));
    if (session && worker) {
      const answered = new Promise<void>((resolve) => (this.onClosedByWorker = resolve));
      session.close();
      let timer: ReturnType<typeof setTimeout> | undefined;
      await Promise.race([answered, new Promise((resolve) => (timer = setTimeout(resolve, kClosing_ms)))]);
      clearTimeout(timer);
    }
    worker?.terminate();
    [this.session, this.worker] = [null, null];
    this.emitter.emit('closed', undefined);
    this.emitter.clear();
  }
  async [Symbol.asyncDispose](): Promise<void> {
    await this.close();
  }

  private over(error: ForelandError): void {
    this.end ??= error;
    this.guard.end();
    this.unwatch();
    this.signal?.removeEventListener('abort', this.abort);
    this.rejectReady(error);
    this.questions.end(error);
    this.session?.sights.end(error);
  }
  private fail(error: ForelandError): void {
    if (this.end) return;
    this.over(error);
    this.session?.close();
    this.emitter.emit('error', error);
  }

  // ---- the session

  private async start(): Promise<void> {
    try {
      const worker = (this.worker = makeWorker(this.opening, (failure) => this.fail(errorOf(failure))));
      const core = await loadCore(this.opening);
      if (this.end) return worker.terminate();
      this.begin(core, worker);
    } catch (error) {
      this.worker?.terminate();
      this.fail(error instanceof ForelandError ? error : errorOf({ ...failureOf(error), part: 'core start' }));
    }
  }

  private begin(core: Core, worker: WorkerLike): void {
    this.session = new Session(core, worker, {
      onOpen: () => (this.may_occlude = this.wishes.options.occlusion ?? true),
      onWaiting: (seconds, reason) => this.emitter.emit('stall', { seconds, reason }),
      onMigrate: () => this.emitter.emit('migrate', undefined),
      onRefused: (reason) => this.refuse(reason),
      onWelcome: (message) => this.enter(message),
      onMesh: (update) => this.feed.add(update),
      onLines: (version, terrain, objects) => this.feed.addLines(version, terrain, objects),
      onGround: (id, ground) => this.questions.answer(id, ground),
      onRecording: (file) => this.onRecording?.(file),
      onDamaged: () => this.warn('A tile of the ground is damaged: a coarser one stays in its place.'),
      onClosed: () => this.onClosedByWorker(),
      onFailure: (failure) => this.fail(errorOf(failure)),
    }, this.guard);
    const request = this.wishes.takeRequest() ?? this.request;
    this.session.tell({
      kind: 'start', module: core.module, server: this.viewers.href, request, blend: this.wishes.options.blend ?? 'keyframe', wants_lines: this.wants_lines,
      texture_layers: layersOf(this.limits), clock_origin_ms: performance.timeOrigin, is_recorded: this.opening.record ?? false,
    });
    this.unwatch = theHost().watchVisibility((is_hidden) => {
      this.is_document_hidden = is_hidden;
      this.tellHidden();
    });
    for (const message of this.untold.splice(0)) this.session.tell(message);
    this.tellHidden();
  }

  private enter(message: Uint8Array): void {
    const welcome = this.session!.screen.enter(message);
    const { screen } = this.session!, scene = sceneOf(welcome, screen);
    this.current = { welcome, scene, places: new Places(screen, welcome, scene) };
    this.resolveReady();
    this.emitter.emit('scene', this.current.scene);
  }
  private refuse(reason: string): void {
    const error = new ForelandError('refused', reason, 'Do what the server says; `reconnect()` tries again.');
    this.rejectReady(error);
    this.emitter.emit('refused', error);
  }

  private readonly untold: Parameters<Session['tell']>[0][] = []; // said before there was a session
  private tell(message: Parameters<Session['tell']>[0]): void {
    if (this.end) return;
    if (this.session) this.session.tell(message);
    else this.untold.push(message);
  }
  private tellHidden(): void {
    if (this.session && !this.end) this.session.setHidden(this.is_document_hidden || !this.is_sized);
  }
  // If it differs from the last one.
  private sendRequest(): void {
    if (!this.session) return;
    const request = this.wishes.takeRequest();
    if (request) this.tell({ kind: 'request', request });
  }

  private tellGuarantee(guaranteed: number | null): void {
    if (guaranteed === this.guaranteed) return;
    this.guaranteed = guaranteed;
    this.emitter.emit('guarantee', guaranteed);
  }
  private noScene(): never {
    throw this.end ?? new ForelandError('closed', 'No session has begun yet.', 'Wait for `ready`.');
  }
}
