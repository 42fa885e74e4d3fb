// The page's parts and what flows between them, frame by frame: camera -> what is shown -> picture -> readout. It owns the drawing
// thread's state: the session's end here, the settings and the camera; the picture has what is drawn. Connection, decoding and meshes
// are in the worker.
import * as THREE from 'three';
import { lookOf } from './ui/camera';
import { ColourMaps, takeFiles } from './ui/colour_maps';
import { Controls } from './ui/controls';
import type { Core } from './core/core';
import { Comeback } from './draw/comeback';
import { canDraw } from './draw/can_draw';
import { failureOf, reasonOf, type Failure } from './core/failure';
import { Guard } from './core/guard';
import { Session } from './core/session';
import type { MapPosition, Pose, Request, ScreenFrame, Welcome } from './core/values';
import { Picture, type Shot } from './draw/picture';
import { wordsOf } from './ui/failure_words';
import { Hint } from './ui/hint';
import { KeptAddress, queryText, viewText } from './ui/kept_address';
import { showNotice } from './ui/notice';
import { Panel } from './ui/panel';
import { PredictionCheck } from './core/prediction_check';
import { Readout } from './ui/readout';
import { adapts, kAdaptive_ms, kLens, type Address, type Settings, type Tour } from './ui/settings';
import { SceneTime } from './ui/scene_time';
import { SightControl } from './ui/sight_control';
import { sunDirection } from './ui/sun';
import { saveFile } from './ui/save_file';
import { startView } from './ui/start_view';
import { Tours } from './ui/tours';

const kResizeQuiet_ms = 200; // a new lens is requested when resizing has paused
// Phones have less to spare.

const kIsPhone = window.matchMedia('(pointer: coarse)').matches;
const kMemoryBytes = (kIsPhone ? 6 : 16) << 20; // for terrain that was flown over
const kTileBytes = (kIsPhone ? 32 : 64) << 20; // of coded tiles
const kTextureLayers = kIsPhone ? { relief: 32, imagery: 96 } : { relief: 64, imagery: 256 };

const kGroundFrames = 8; // so many frames ahead the ground is known

function byId(id: string): HTMLElement {
  return document.getElementById(id)!;
}

export class App {
  private canvas = byId('scene') as HTMLCanvasElement;
  private readonly guard = new Guard((error) => this.fail(failureOf(error)));
  private readonly hint = new Hint(byId('hint'));
  private has_told_missing = false; // images of models
  private picture: Picture;
  private readonly comeback = new Comeback();
  private comeback_timer = 0;
  private card_resets = 0; // after which it draws again
  private readonly kept_address = new KeptAddress((query) =>
    window.history.replaceState(window.history.state, '', `${window.location.pathname}${query}${window.location.hash}`));
  private has_size = false; // since when the session has begun, or is to begin
  private may_occlude = false; // this connection's deltas can tell hidden blocks
  private readonly controls = new Controls(this.canvas);
  private readonly readout = new Readout(byId('readout'));
  private readonly prediction = new PredictionCheck();
  private readonly tours: Tours;
  private readonly scene_time = new SceneTime(byId('time'), (scene_ms, rate) =>
    this.session.tell({ kind: 'scene clock', now_ms: performance.now(), scene_ms, rate }));
  private readonly session: Session;
  readonly sight: SightControl;
  private readonly panel: Panel;
  private readonly settings: Settings;
  private readonly colour_maps = new ColourMaps();
  private welcome: Welcome | null = null;
  private mesh: { triangles: number; to_nodes: number; to_time_ms: number; tau_px: number } | null = null;
  private sent_request = ''; // the last one, as JSON
  private shown_colours = '';
  private sent_sun: readonly number[] | null = null; // the last one
  private lens_timer = 0;
  private above_ground_m: number | null = null; // where it is known
  private scene_time_ms = 0; // of the last frame
  private last_ms = 0;
  private next_ms = 0; // when the next mesh is to be shown
  private readonly last_eye = new THREE.Vector3();

  // The worker is to be core/worker.ts; nothing has been said to it.
  constructor(private readonly core: Core, worker: Worker, private readonly address: Address) {
    this.settings = address.settings;
    this.picture = this.newPicture();
    this.tours = new Tours(byId('tours'), (tour) => this.guard.run(() => this.chooseTour(tour)));
    this.session = new Session(core, worker, {
      onOpen: () => (this.may_occlude = this.settings.occlusion),
      onWaiting: (seconds, reason) => this.showWaiting(seconds, reason),
      onRefused: (reason) => this.stop('The session ended.', reason),
      onWelcome: (message) => this.enterScene(this.session.screen.enter(message)),
      onMesh: (update) => this.picture.add(update),
      onLines: (version, terrain, objects) => {
        this.picture.addLines(version, terrain, objects);
        this.picture.show(this.settings);
      },
      onRecording: (file) => saveFile(file, 'flight.rec'),
      onDamaged: () => this.hint.show('A tile of the ground is damaged: a coarser one stays in its place.'),
      onFailure: (failure) => this.guard.run(() => this.fail(failure)),
    }, this.guard);
    this.controls.onTakeOver = () => this.guard.run(() => this.tours.current && this.chooseTour(null));
    const file = document.createElement('input');
    this.panel = new Panel(byId('panel'), this.settings, this.colour_maps.names, file, () => this.guard.run(() => this.applySettings()));
    takeFiles(file, (name, text) => this.guard.run(() => this.addColours(name, text)),
      (reason) => this.guard.run(() => this.refuseColours(reason)));
    if (address.is_recorded) this.panel.addButton('Save the recording', 'save', () => this.session.tell({ kind: 'save recording' }));
    else this.panel.addButton('Record a flight from here', 'record', () => this.recordFromHere());
    window.addEventListener('resize', () => this.guard.run(() => this.resize()));
    this.sight = new SightControl({
      picture: () => this.picture,
      screen: () => this.session.screen,
      sights: () => this.session.sights,
      welcome: () => this.welcome,
      eye: () => this.controls.eye.toArray(),
      sceneTime: () => this.scene_time_ms,
      say: (text) => this.hint.show(text),
    });
  }

  start(): void {
    if (this.guard.isOver) return;
    this.resize();
    this.showConnecting();
    if (this.address.tour) this.chooseTour(this.address.tour);
    this.beginDrawing();
    this.hint.show(kIsPhone ? 'One finger looks, two fingers fly'
      : 'Drag to look \u00b7 W A S D to fly \u00b7 E Q up and down \u00b7 wheel sets the speed');
  }

  // For tests, and for anyone who opens the console.
  status(): Record<string, unknown> {
    return {
      connected: this.session.is_open,
      ...this.picture.status(),
      card_resets: this.card_resets,
      nodes: this.mesh?.to_nodes ?? 0,
      tau_px: this.mesh?.tau_px ?? 0,
      blend: this.settings.blend,
      touring: this.tours.isFlying,
      frozen: this.picture.frozen_view.pose !== null,
      eye: this.controls.eye.toArray(),
      heading: this.controls.look.heading,
      above_ground_m: this.above_ground_m,
      title: this.welcome?.title ?? null,
      scene_time_ms: this.scene_time_ms,
      ...this.session.statistics,
    };
  }

  // For tests: Picture.compareEnds() and Picture.shadeAt().
  compareEnds(): ReturnType<Picture['compareEnds']> {
    return this.picture.compareEnds(this.session.screen.next(), () => this.showNext());
  }
  shadeAt(positions: readonly number[], footprint: number, weight: number): number[] | null {
    return this.picture.shadeAt(positions, footprint, weight);
  }

  // ---- session

  // Once the page has a size: a server refuses a lens without pixels.
  private startSession(): void {
    const { server, token, is_recorded } = this.address;
    const url = new URL(server);
    if (token !== null) url.searchParams.set('token', token);
    this.session.tell({
      kind: 'start', module: this.core.module, server: url.href, request: this.request(), blend: this.settings.blend,
      wants_lines: this.settings.wireframe, texture_layers: kTextureLayers, clock_origin_ms: performance.timeOrigin, is_recorded,
    });
    this.sent_request = JSON.stringify(this.request());
  }

  private showConnecting(): void {
    showNotice(byId('notice'), { kind: 'wait', title: 'Connecting', text: this.address.server });
  }

  private enterScene(welcome: Welcome): void {
    const is_first = this.welcome === null;
    showNotice(byId('notice'), null);
    this.welcome = welcome;
    this.picture.setScene(welcome, this.session.screen);
    this.showColours();
    this.panel.setScene(welcome.lowest_m, welcome.highest_m, welcome.max_moved_m, welcome.is_geographic);
    this.applyLook();
    this.scene_time.setEpochs(welcome.epochs_ms);
    byId('scene-title').textContent = welcome.title;
    document.title = `${welcome.title} \u00b7 Foreland`;
    if (!is_first) return;
    this.controls.setBox(welcome.low, welcome.high);
    const { eye, look } = startView(welcome);
    this.controls.eye.fromArray(this.address.view?.slice(0, 3) ?? eye);
    const [heading, pitch] = (this.address.view?.slice(3) ?? []).map((degrees) => (degrees * Math.PI) / 180);
    this.controls.look = heading === undefined ? look : { heading, pitch: pitch! };
    this.kept_address.begin(queryText(this.addressHere()));
  }

  private showWaiting(seconds: number, reason: string): void {
    const title = this.welcome ? 'Connection lost' : reason === '' ? 'The server does not answer' : 'The connection does not open';
    const text = `${reason === '' ? '' : `${reason} `}Trying ${this.address.server} again in ${seconds < 1 ? 'a moment' : `${seconds} s`}.`;
    showNotice(byId('notice'), { kind: 'wait', title, text });
  }

  private stop(title: string, text: string): void {
    const action = { label: 'Try again', run: () => window.location.reload() };
    showNotice(byId('notice'), { kind: 'error', title, text, action });
  }

  // An image of a model that did not come is asked for again with the next connection.
  private tellMissing(what: string): void {
    console.warn(`An image of a model did not come: ${what}`);
    if (!this.has_told_missing) this.hint.show('An image of a model did not come: it is drawn in a plain colour.');
    this.has_told_missing = true;
  }

  // ---- the end

  private fail(failure: Failure): void {
    this.end();
    const { title, text } = wordsOf(failure);
    this.offerReload(title, text);
  }

  // Nothing is drawn, sent or chosen any more; only a recording can still be saved.
  private end(): void {
    this.guard.end();
    this.picture.renderer.setAnimationLoop(null);
    window.clearTimeout(this.lens_timer);
    window.clearTimeout(this.comeback_timer);
    this.session.close();
  }

  private offerReload(title: string, text: string): void {
    showNotice(byId('notice'), { kind: 'error', title, text, action: this.reloadHere() });
  }
  private reloadHere(): { label: string; run: () => void } {
    const run = () => {
      window.history.replaceState(null, '', `${window.location.pathname}${queryText(this.addressHere())}${window.location.hash}`);
      window.location.reload();
    };
    return { label: 'Reload the page', run };
  }

  // ---- the graphics card

  private newPicture(): Picture {
    const { anisotropy, server } = this.address;
    const picture = new Picture(this.canvas, { layers: kTextureLayers, anisotropy, models: modelsOf(server) }, (what) => this.tellMissing(what));
    this.canvas.addEventListener('webglcontextlost', () => this.guard.run(() => this.loseCard()), { once: true });
    return picture;
  }

  private beginDrawing(): void {
    this.picture.renderer.setAnimationLoop(() => this.guard.run(() => this.draw(performance.now())));
  }

  // The card was reset, and all that it held is gone. The session goes on.
  private loseCard(): void {
    this.picture.renderer.setAnimationLoop(null);
    this.session.leaveOutMeshes();
    const text = 'The picture comes back as soon as the browser can draw again.';
    showNotice(byId('notice'), { kind: 'wait', title: 'The graphics card was reset', text, action: this.reloadHere() });
    this.waitForCard();
  }
  private waitForCard(): void {
    const wait_ms = this.comeback.next(performance.now());
    this.comeback_timer = window.setTimeout(() => this.guard.run(() => (canDraw() ? this.drawAgain() : this.waitForCard())), wait_ms);
  }

  // On another canvas: that of before may never get its context back.
  private drawAgain(): void {
    const before = this.picture;
    const canvas = this.canvas.cloneNode() as HTMLCanvasElement;
    const has_focus = document.activeElement === this.canvas;
    this.canvas.replaceWith(canvas);
    this.canvas = canvas;
    if (has_focus) canvas.focus({ preventScroll: true });
    this.controls.steerOn(canvas);
    before.renderer.dispose();
    this.picture = this.newPicture();
    this.picture.frames = before.frames;
    this.picture.up.copy(before.up);
    if (this.welcome) this.picture.setScene(this.welcome, this.session.screen);
    this.showColours();
    this.applyLook();
    if (before.frozen_view.pose) this.freezeAt(before.frozen_view.pose);
    this.mesh = null;
    this.resize();
    this.session.redraw();
    if (this.welcome) showNotice(byId('notice'), null);
    else this.showConnecting();
    this.beginDrawing();
    ++this.card_resets;
  }

  // ---- what the user chooses

  // A recording begins with its session, so the page begins anew where the camera is.
  private recordFromHere(): void {
    const query = this.addressHere();
    query.set('record', '1');
    window.location.search = queryText(query);
  }

  // The page's query, with where the camera is once it is in a scene, and without a tour that has ended.
  private addressHere(): URLSearchParams {
    const query = new URLSearchParams(window.location.search);
    if (!this.welcome) return query;
    const { low, high } = this.welcome;
    query.set('view', viewText(this.controls.eye.toArray(), this.controls.look, Math.hypot(high[0] - low[0], high[1] - low[1])));
    if (this.tours.current === null) query.delete('tour');
    return query;
  }

  private request(): Request {
    const { strategy, predictor, tau_px, keyframe_ms, occlusion } = this.settings;
    const adaptive = adapts(this.settings);
    const automatic = this.tours?.current ? 'path' : 'velocity';
    return {
      fov_rad: kLens.fov_rad,
      width_px: this.canvas.width,
      height_px: this.canvas.height,
      strategy,
      predictor: predictor === 'auto' ? automatic : predictor,
      tau_px,
      keyframe_ms: adaptive ? kAdaptive_ms.shortest : keyframe_ms,
      longest_keyframe_ms: adaptive ? kAdaptive_ms.longest : 0,
      occlusion,
      memory_bytes: kMemoryBytes,
      relief: this.settings.relief,
      imagery: this.settings.imagery,
      tile_bytes: kTileBytes,
    };
  }

  private applyLook(): void {
    if (this.settings.colours !== this.shown_colours) this.showColours();
    this.shown_colours = this.settings.colours;
    this.picture.show(this.settings);
    this.picture.sun.set(...sunDirection(this.settings, this.session.screen.slopeFrame()));
    const towards = this.settings.shadows && this.settings.relief ? this.picture.sun.toArray() : null;
    if (JSON.stringify(towards) === JSON.stringify(this.sent_sun)) return;
    this.sent_sun = towards;
    this.session.tell({ kind: 'sun', towards });
  }

  // A colour map from a file, which is shown at once.
  private addColours(name: string, text: string): void {
    try {
      this.colour_maps.add(name, text);
    } catch (error) {
      return this.refuseColours(reasonOf(error));
    }
    showNotice(byId('notice'), null);
    Object.assign(this.settings, { colours: name, ground: 'heights' });
    this.panel.addColours(name);
    this.panel.showChoices();
    this.applySettings();
  }
  private refuseColours(reason: string): void {
    const action = { label: 'Close', run: () => showNotice(byId('notice'), null) };
    showNotice(byId('notice'), { kind: 'error', title: 'This colour map cannot be read', text: reason, action });
  }
  private showColours(): void {
    if (!this.welcome) return;
    const tints = this.colour_maps.tints(this.settings.colours, this.welcome.lowest_m, this.welcome.highest_m);
    this.picture.setTints(tints);
    this.panel?.setHeightsLegend(tints.legend);
  }

  private applySettings(): void {
    this.applyLook();
    if (this.settings.frozen && !this.picture.frozen_view.pose) this.freeze();
    if (!this.settings.frozen && this.picture.frozen_view.pose) {
      this.picture.frozen_view.thaw();
      this.session.jump(); // for the server, from the frozen view to where the camera has gone meanwhile
    }
    this.session.tell({ kind: 'blend', blend: this.settings.blend });
    this.session.tell({ kind: 'lines', wants_lines: this.settings.wireframe });
    this.sendRequest();
    if (this.session.is_open && this.settings.occlusion && !this.may_occlude) this.session.tell({ kind: 'reopen' });
  }

  // Sends the request if it differs from the last one.
  private sendRequest(): void {
    const request = this.request();
    if (!this.has_size || JSON.stringify(request) === this.sent_request) return;
    this.sent_request = JSON.stringify(request);
    this.session.tell({ kind: 'request', request });
  }

  private chooseTour(tour: Tour | null): void {
    if (tour) this.tours.request(tour, this.session);
    else this.tours.stop();
    this.sendRequest();
  }

  private freeze(): void {
    this.freezeAt(this.controls.pose(this.picture.up));
  }
  private freezeAt(pose: Pose): void {
    if (!this.welcome) return;
    const { low, high } = this.welcome;
    const length_m = 0.3 * Math.hypot(high[0] - low[0], high[1] - low[1]);
    this.picture.frozen_view.freeze(pose, kLens.fov_rad, this.picture.aspect, length_m);
  }

  // A page that has no size, as in a frame that is hidden, keeps the lens that it had; its session waits until it has one.
  private resize(): void {
    const is_sized = this.picture.resize(window.innerWidth, window.innerHeight, this.address.sharpness);
    this.session.setSized(is_sized);
    if (!is_sized) return;
    if (!this.has_size) this.startSession();
    this.has_size = true;
    window.clearTimeout(this.lens_timer);
    this.lens_timer = window.setTimeout(() => this.guard.run(() => this.sendRequest()), kResizeQuiet_ms);
  }

  // ---- a frame

  private draw(now_ms: number): void {
    const frame_ms = now_ms - this.last_ms;
    this.last_ms = now_ms;
    const { picture } = this;
    const { screen } = this.session;
    const position = this.welcome ? this.moveCamera(now_ms, Math.min(frame_ms / 1000, 0.25)) : null;
    const own = this.controls.pose(picture.up);
    const sent = picture.frozen_view.pose ?? own; // the server keeps the section of the frozen view
    picture.upload(screen.next(), this.next_ms - now_ms, frame_ms);
    const { ready, coming } = picture.versions();
    const frame = screen.frame(now_ms, sent, this.settings.strategy, ready, coming);
    const had_mesh = this.mesh !== null;
    this.takeMesh(frame, now_ms, sent);
    if (had_mesh) picture.noteUpload();
    this.session.frame(now_ms, sent, own.eye, this.groundReach(), picture.stagedVersion);
    const pose = picture.frozen_view.pose ? own : frame.pose;
    const shot: Shot = { pose, frame, position, camera_eye: this.controls.eye, above_ground_m: this.above_ground_m };
    picture.take(shot);
    this.measure(now_ms, frame, position);
    this.showCredits();
    if (this.welcome) this.kept_address.keep(now_ms, () => queryText(this.addressHere()));
  }

  private moveCamera(now_ms: number, seconds: number): MapPosition | null {
    const mapPositionOf = (eye: readonly number[]) => this.session.screen.mapPosition(eye);
    const touring = this.tours.pose(this.session, now_ms);
    if (touring && !this.picture.frozen_view.pose) {
      this.controls.eye.fromArray(touring.eye);
      this.controls.look = lookOf(touring.orientation, this.picture.up);
    } else {
      this.controls.step(seconds, this.picture.up, (from, to) => this.session.screen.sweep(from, to, this.controls.clearance_m));
    }
    const position = mapPositionOf(this.controls.eye.toArray());
    if (position) this.picture.up.fromArray(position.up);
    this.above_ground_m = position && position.ground_m !== null ? position.height_m - position.ground_m : null;
    if (this.above_ground_m !== null) this.controls.ground_distance_m = Math.max(this.above_ground_m, this.controls.clearance_m);
    return position;
  }

  // How far about the eye, in samples, the ground is needed before the worker tells it again.
  private groundReach(): number {
    if (!this.welcome) return 1;
    const { low, high, samples } = this.welcome;
    const spacing_m = Math.hypot(high[0] - low[0], high[1] - low[1]) / Math.hypot(...samples);
    const step_m = this.controls.eye.distanceTo(this.last_eye);
    this.last_eye.copy(this.controls.eye);
    return Math.min(Math.max(1, (kGroundFrames * step_m) / spacing_m), 4096);
  }

  private takeMesh(frame: ScreenFrame, now_ms: number, sent: Pose): void {
    this.prediction.frame(now_ms, sent.eye);
    this.next_ms = frame.end_ms;
    if (frame.mesh_version > 0) this.scene_time.show(frame.scene_time_ms);
    this.scene_time_ms = frame.scene_time_ms;
    if (frame.mesh_version !== 0 && frame.mesh_version !== this.picture.shownVersion) this.showNext();
    if (this.mesh) this.mesh.tau_px = frame.tau_px;
  }

  private showNext(): void {
    const { update, triangles } = this.picture.showNext();
    this.prediction.expect(update.to_time_ms, update.to_pose.eye);
    this.mesh = { triangles, to_nodes: update.to_nodes, to_time_ms: update.to_time_ms, tau_px: Infinity };
  }

  private showCredits(): void {
    const credits = this.picture.attributions().join(' \u00b7 ');
    if (byId('credits').textContent !== credits) byId('credits').textContent = credits;
  }

  private measure(now_ms: number, frame: ScreenFrame, position: MapPosition | null): void {
    this.readout.update({
      now_ms,
      statistics: this.session.statistics,
      mesh: this.mesh,
      strategy: this.settings.strategy,
      shown_late_ms: now_ms - frame.shown_time_ms,
      is_late: this.mesh !== null && this.settings.strategy === 'predict' && now_ms > this.mesh.to_time_ms + 20,
      prediction_error_m: this.settings.strategy === 'predict' ? this.prediction.error_m : null,
      welcome: this.welcome,
      position,
      heading_rad: this.controls.look.heading,
      eye: this.controls.eye.toArray(),
      set_speed_mps: this.controls.speed_mps,
    });
  }
}

// The address of a server's model images: beside the address that viewers connect to.
function modelsOf(server: string): URL {
  return new URL('models/', server.replace(/^ws/, 'http'));
}
