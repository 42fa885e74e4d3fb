// The page's parts and what flows between them, frame by frame: camera -> terrain -> picture -> readout. The terrain (@foreland/client) has
// the session, the picture what is drawn; app/ has the parts that need more than a few lines.
import { Terrain, type Frame, type Place, type Scene, type Vector } from '@foreland/client';
import { addressHere, linkOf, reloadAt, writeQuery } from './app/page_address';
import { kIsPhone, kLimits, kResting, lensOf, optionsOf } from './app/asked';
import { CardLoss } from './app/card_loss';
import { Steering } from './app/steering';
import { askSea, takeAir, takeGlobe, takeMap, viewAt } from './app/globe_flight';
import { takeAddressed, takeFiles } from './app/taken_files';
import { Tools } from './app/tools';
import { Picture, type Shot } from './draw/picture';
import type { PlaceView } from './globe/place_text';
import { clockOf } from './globe/sun_position';
import { ColourMaps } from './ui/colour_maps';
import { Compass } from './ui/compass';
import { Controls } from './ui/controls';
import type { DroppedFiles } from './ui/dropped_files';
import { wordsOf } from './ui/failure_words';
import { boundTo } from './ui/form';
import { Guard } from './ui/guard';
import { Hint } from './ui/hint';
import { KeptAddress, queryText } from './ui/kept_address';
import { showNotice, type Notice } from './ui/notice';
import { MapInset } from './ui/map_inset';
import { Panel } from './ui/panel';
import { PlaceSearch } from './ui/place_search';
import { PredictionCheck } from './ui/prediction_check';
import { Readout } from './ui/readout';
import { saveFile } from './ui/save_file';
import { SceneTime } from './ui/scene_time';
import { kLens, type Address, type Settings, type Tour } from './ui/settings';
import type { Stage } from './ui/stage';
import { sunDirection, sunOverGlobe } from './ui/sun';
import { Tours } from './ui/tours';
import { wordsOnMoving } from './ui/welcome_words';
import { reasonOf } from './ui/words';

function byId(id: string): HTMLElement {
  return document.getElementById(id)!;
}
const kSunStep_rad = 0.01, kRadians = Math.PI / 180;
const kGlobeSettings = { exaggeration: 1, map: false }; // what there is not on globes

function notify(notice: Notice | null): void {
  showNotice(byId('notice'), notice);
}

export class App {
  private canvas = byId('scene') as HTMLCanvasElement;
  private readonly guard = new Guard((error) => this.fail(error));
  private readonly hint = new Hint(byId('hint'));
  private readonly kept_address = new KeptAddress(writeQuery);
  private readonly readout = new Readout(byId('readout'));
  private readonly prediction = new PredictionCheck();
  private readonly colour_maps = new ColourMaps();
  private readonly tours = new Tours(byId('tours'), (tour) => this.guard.run(() => this.chooseTour(tour)), (pose) => this.picture.shown(pose));
  private readonly steering = new Steering(new Controls(this.canvas), () => [this.tours, this.tools.follow], (place) => this.picture.sea.heightAt(place));
  private readonly scene_time = new SceneTime(byId('time'), (at, ms_rate) => this.terrain?.setSceneTime({ at, rate: ms_rate }));
  private readonly card_loss = new CardLoss((work) => this.guard.run(work), () => this.drawAgain());
  private readonly stage: Stage = {
    picture: () => this.picture, terrain: () => this.terrain, sceneTime: () => this.scene_time_ms, say: (text) => this.hint.show(text),
  };
  private readonly compass = new Compass(byId('compass'), () => this.guard.run(() => this.turnNorth()));
  private readonly map = new MapInset(byId('map'), (x, y) => this.guard.run(() => this.goTo(x, y)));
  private readonly tools: Tools;
  private readonly search: PlaceSearch;
  private readonly files: DroppedFiles;
  private readonly panel: Panel;
  private readonly settings: Settings;
  private picture: Picture;
  private terrain: Terrain | null = null; // once the page has a size: a server refuses a lens without pixels
  private scene: Scene | null = null;
  private mesh: { triangles: number; to_nodes: number; to_time_ms: number; tau_px: number } | null = null;
  private has_told_missing = false; // images of models
  private card_resets = 0; // after which it draws again
  private shown_colours = '';
  private has_failed = false;
  private scene_time_ms = 0; // of the last frame
  private last_ms = 0;

  constructor(private readonly address: Address) {
    this.settings = address.settings;
    this.picture = this.newPicture();
    this.steering.controls.onTakeOver = () => this.guard.run(() => this.takeOver());
    const file = document.createElement('input');
    const { controls } = this.steering;
    this.panel = new Panel(byId('panel'), this.settings, this.colour_maps.names, file, boundTo(controls, 'speed_mps'),
      () => this.guard.run(() => this.applySettings()));
    controls.onSpeed = () => this.guard.run(() => this.panel.showChoices());
    this.tools = new Tools(byId, {
      stage: this.stage, controls, refuse: (title, reason) => this.refuseFile(title, reason), needs_token: address.token !== null, link: () => linkOf(this.addressHere()), guide: () => this.guard.run(() => this.ask()),
      beginFrames: () => this.guard.run(() => this.beginFrames()), endFrames: () => this.guard.run(() => this.endFrames()),
    });
    this.search = new PlaceSearch(byId('tools'), (place) => this.guard.run(() => this.goToPlace(place)), (text) => this.hint.show(text));
    this.files = takeFiles({ tools: this.tools, refuse: (title, reason) => this.refuseFile(title, reason), addColours: (name, text) => this.guard.run(() => this.addColours(name, text)) });
    this.files.listen(file);
    this.files.listen(byId('overlay-file') as HTMLInputElement);
    if (address.is_recorded) this.panel.addButton('Save the recording', 'save', () => void this.saveRecording());
    else this.panel.addButton('Record a flight from here', 'record', () => this.recordFromHere());
    window.addEventListener('resize', () => this.guard.run(() => this.resize()));
  }

  start(): void {
    this.resize();
    this.showConnecting();
    this.beginDrawing();
  }

  // For tests, and for anyone who opens the console.
  status(): Record<string, unknown> {
    const { controls, above_ground_m } = this.steering;
    return {
      connected: this.terrain?.isConnected ?? false,
      ...this.picture.status(),
      card_resets: this.card_resets,
      nodes: this.mesh?.to_nodes ?? 0,
      tau_px: this.mesh?.tau_px ?? 0,
      blend: this.settings.blend,
      touring: this.tours.isFlying,
      frozen: this.picture.frozen_view.pose !== null,
      eye: controls.eye.toArray(),
      heading: controls.look.heading,
      pitch: controls.look.pitch,
      above_ground_m,
      title: this.scene?.title ?? null,
      scene_time_ms: this.scene_time_ms,
      ...this.terrain?.stats,
      ...this.tools.status(),
      ...this.map.status(),
    };
  }

  // For tests: what a picture shows at a point of the window, and where it shows a point of the scene.
  groundAt(x: number, y: number): readonly number[] | null {
    return this.picture.metAt(x, y)?.point ?? null;
  }
  onScreen(point: Vector): Vector | null {
    return this.picture.pointOnScreen(point);
  }
  // For tests: Picture.compareEnds() and Picture.shadeAt().
  compareEnds(): ReturnType<Picture['compareEnds']> {
    return this.picture.compareEnds();
  }
  shadeAt(positions: readonly number[], footprint: number, weight: number): number[] | null {
    return this.picture.shadeAt(positions, footprint, weight);
  }

  // ---- the terrain

  private connect(): void {
    const { server, area, token, is_recorded } = this.address;
    const at = new URL(server);
    if (area !== null) at.searchParams.set('area', area);
    const terrain = (this.terrain = Terrain.connect(at, {
      ...this.options(), lens: lensOf(this.canvas), limits: kLimits, record: is_recorded, patienceMs: Infinity,
      ...(token === null ? {} : { token }),
    }));
    terrain.on('scene', (scene) => this.guard.run(() => this.enterScene(scene)));
    terrain.on('stall', ({ seconds, reason }) => this.guard.run(() => this.showWaiting(seconds, reason)));
    terrain.on('refused', (error) => this.guard.run(() => this.stop('The session ended.', error.message)));
    terrain.on('error', (error) => this.fail(error)); // the client has logged it
    terrain.on('warning', (text) => this.guard.run(() => this.warn(text)));
    terrain.on('attributions', (texts) => (byId('credits').textContent = texts.join(' \u00b7 ')));
    this.showTerrain(terrain);
    if (this.address.tour) this.chooseTour(this.address.tour);
  }

  private showTerrain(terrain: Terrain): void {
    this.picture.show(terrain);
    this.picture.ground!.onMesh = (update) => {
      this.prediction.expect(update.to_time_ms, update.to_pose.eye);
      this.mesh = { triangles: this.picture.triangles, to_nodes: update.to_nodes, to_time_ms: update.to_time_ms, tau_px: Infinity };
    };
    this.applyLook();
  }

  private showConnecting(): void {
    notify({ kind: 'wait', title: 'Connecting', text: this.address.server });
  }

  private enterScene(scene: Scene): void {
    const is_first = this.scene === null;
    if (!is_first && scene.frame !== this.scene!.frame) return this.beginAnew(); // hands, shaders and light are those of the first
    notify(null);
    this.scene = scene;
    this.setPictureScene(scene);
    this.showColours();
    this.applyLook();
    this.scene_time.setEpochs(scene.epochs);
    byId('scene-title').textContent = scene.title;
    document.title = `${scene.title} \u00b7 Foreland`;
    if (is_first) this.enterFirst(scene);
    this.panel.setScene(scene);
    this.tools.headset.setScene(scene);
    if (!is_first) return;
    this.hint.show(wordsOnMoving(kIsPhone, scene.frame === 'globe'));
    void this.tools.cut.read(this.address.cut);
    this.kept_address.begin(queryText(this.addressHere()));
    void takeAddressed(this.files, this.address.tracks, (title, reason) => this.refuseFile(title, reason));
    void this.tools.overlays.open(this.address.overlays);
  }

  private beginAnew(): void {
    this.picture.renderer.setAnimationLoop(null);
    window.location.reload();
  }

  private goToPlace(place: PlaceView): void {
    this.takeOver();
    const [x, y, z, heading, pitch] = viewAt(this.terrain!, place)!;
    this.steering.controls.jumpTo([x!, y!, z!], { heading: heading! * kRadians, pitch: pitch! * kRadians });
    this.terrain!.jump();
  }
  private setPictureScene(scene: Scene): void {
    this.picture.setScene(scene);
    if (scene.frame !== 'globe') return;
    takeAir(this.terrain!, this.picture).catch((error: unknown) => console.warn(error));
    this.takeSea(this.terrain!, this.picture).catch((error: unknown) => console.warn(error));
  }
  private async takeSea(terrain: Terrain, picture: Picture): Promise<void> {
    const sea = await askSea(terrain);
    if (!sea) return;
    picture.takeSea(sea);
    this.panel.setSea(sea.isDrawn);
  }
  private enterFirst(scene: Scene): void {
    const { controls } = this.steering;
    this.steering.enter(scene, this.address.view ?? viewAt(this.terrain!, this.address.at));
    if (scene.frame !== 'globe') return takeMap(controls, this.terrain!, () => this.picture);
    takeGlobe(controls, this.terrain!, () => this.picture);
    this.search.setOn(true);
    if (!this.address.tells_clock) Object.assign(this.settings, clockOf(new Date()));
    Object.assign(this.settings, kGlobeSettings);
    this.applyLook();
  }

  private showWaiting(seconds: number, reason: string): void {
    const title = this.scene ? 'Connection lost' : reason === '' ? 'The server does not answer' : 'The connection does not open';
    const text = `${reason === '' ? '' : `${reason} `}Trying ${this.address.server} again in ${seconds < 1 ? 'a moment' : `${seconds} s`}.`;
    notify({ kind: 'wait', title, text });
  }

  private stop(title: string, text: string): void {
    notify({ kind: 'error', title, text, action: { label: 'Try again', run: () => window.location.reload() } });
  }

  // An image of a model that did not come is asked for again with the next connection, and is said once.
  private warn(text: string): void {
    if (!text.startsWith('An image of a model')) return this.hint.show(text);
    console.warn(text);
    if (!this.has_told_missing) this.hint.show('An image of a model did not come: it is drawn in a plain colour.');
    this.has_told_missing = true;
  }

  // ---- the end: nothing is drawn, sent or chosen any more; only a recording can still be saved

  private fail(error: unknown): void {
    if (this.has_failed) return;
    this.has_failed = true;
    this.guard.end();
    this.picture.renderer.setAnimationLoop(null);
    this.card_loss.end();
    this.terrain?.halt();
    notify({ kind: 'error', ...wordsOf(error), action: this.reloadHere() });
  }
  private reloadHere(): { label: string; run: () => void } {
    return { label: 'Reload the page', run: () => reloadAt(this.addressHere()) };
  }

  // ---- the graphics card

  private newPicture(): Picture {
    const picture = new Picture(this.canvas, this.address.anisotropy);
    picture.headset.onLens = () => this.guard.run(() => this.ask());
    picture.headset.onTurn = () => this.guard.run(() => this.turnHeadset());
    this.canvas.addEventListener('webglcontextlost', () => this.guard.run(() => this.loseCard()), { once: true });
    return picture;
  }

  private beginDrawing(): void {
    this.picture.renderer.setAnimationLoop(() => this.guard.run(() => this.draw(performance.now())));
  }

  // The card was reset, and all that it held is gone. The session goes on.
  private loseCard(): void {
    this.tools.record.cancel('the graphics card was reset.');
    this.picture.renderer.setAnimationLoop(null);
    const text = 'The picture comes back as soon as the browser can draw again.';
    notify({ kind: 'wait', title: 'The graphics card was reset', text, action: this.reloadHere() });
    this.card_loss.wait();
  }

  // On another canvas: that of before may never get its context back.
  private drawAgain(): void {
    const before = this.picture;
    const canvas = this.canvas.cloneNode() as HTMLCanvasElement;
    const has_focus = document.activeElement === this.canvas;
    this.canvas.replaceWith(canvas);
    this.canvas = canvas;
    if (has_focus) canvas.focus({ preventScroll: true });
    this.steering.controls.steerOn(canvas);
    before.dispose();
    this.picture = this.newPicture();
    this.picture.frames = before.frames;
    this.picture.up.copy(before.up);
    if (this.terrain) this.showTerrain(this.terrain);
    if (this.scene) this.setPictureScene(this.scene);
    this.showColours();
    if (before.frozen_view.pose) this.freezeAt(before.frozen_view.pose);
    this.tools.show();
    this.mesh = null;
    this.resize();
    if (this.scene) notify(null);
    else this.showConnecting();
    this.beginDrawing();
    ++this.card_resets;
  }

  // ---- a headset

  private turnHeadset(): void {
    const { controls } = this.steering, { headset } = this.picture;
    controls.heldInHands = () => headset.session?.inputSources ?? [];
    if (headset.isOn) controls.look.pitch = 0;
    else this.resize();
    this.ask();
  }

  // ---- frames that are recorded

  private beginFrames(): void {
    this.picture.renderer.setAnimationLoop(null);
    this.terrain?.setOptions({ ...this.options(), ...kResting });
  }
  private endFrames(): void {
    this.resize();
    this.terrain?.jump();
    this.ask();
    this.beginDrawing();
  }

  // ---- what the user chooses

  // A recording begins with its session, so the page begins anew where the camera is.
  private recordFromHere(): void {
    const query = this.addressHere();
    query.set('record', '1');
    window.location.search = queryText(query);
  }
  private async saveRecording(): Promise<void> {
    const file = await this.terrain?.saveRecording();
    if (file) saveFile(file, 'flight.rec');
  }
  private addressHere(): URLSearchParams {
    const query = addressHere(this.terrain, this.steering.controls, this.settings, this.tours.current !== null);
    if (this.scene) this.tools.cut.write(query);
    return query;
  }

  private applyLook(): void {
    if (this.settings.colours !== this.shown_colours) this.showColours();
    const is_globe = this.scene?.frame === 'globe';
    this.picture.setLook(this.settings, is_globe ? sunOverGlobe(this.settings, this.picture.up) : sunDirection(this.settings, this.scene));
    this.tools?.labels.setOn(this.settings.labels);
    this.map.setOn(this.settings.map);
  }

  private refuseFile(title: string, reason: string): void {
    notify({ kind: 'error', title, text: reason, action: { label: 'Close', run: () => notify(null) } });
  }
  // A colour map from a file, which is shown at once.
  private addColours(name: string, text: string): void {
    try {
      this.colour_maps.add(name, text);
    } catch (error) {
      return this.refuseFile('This colour map cannot be read', reasonOf(error));
    }
    notify(null);
    Object.assign(this.settings, { colours: name, ground: 'heights' });
    this.panel.addColours(name);
    this.panel.showChoices();
    this.applySettings();
  }
  private showColours(): void {
    if (!this.scene) return;
    this.shown_colours = this.settings.colours;
    const { tints, legend } = this.colour_maps.tints(this.settings.colours, this.scene.heights.lowest, this.scene.heights.highest);
    this.picture.ground?.setStyle({ tints });
    this.panel.setHeightsLegend(legend);
  }

  private applySettings(): void {
    this.applyLook();
    const { frozen_view } = this.picture;
    if (this.settings.frozen && !frozen_view.pose) this.freezeAt(this.steering.controls.pose(this.picture.up));
    if (!this.settings.frozen && frozen_view.pose) {
      frozen_view.thaw();
      this.picture.ground!.frozenPose = null;
      this.terrain?.jump(); // for the server, from the frozen view to where the camera has gone meanwhile
    }
    this.ask();
  }
  private ask(): void {
    this.terrain?.setOptions(this.options());
  }
  private options(): ReturnType<typeof optionsOf> {
    const { picture, settings, picture: { headset } } = this;
    if (!headset.isOn) return optionsOf(settings, this.isGuided, picture.exaggerate(settings.exaggeration), 0);
    return optionsOf({ ...settings, strategy: 'predict' }, false, picture.exaggerate(1), headset.lens?.eye_radius_m ?? 0); // heads go where nothing else does
  }
  // Along a path that the server knows.
  private get isGuided(): boolean {
    return this.tours.current !== null || this.tools.follow.isGuiding;
  }

  private takeOver(): void {
    this.tools.follow.release();
    if (this.tours.current) this.chooseTour(null);
  }
  private chooseTour(tour: Tour | null): void {
    if (tour) this.tools.follow.release();
    if (tour && this.terrain) this.tours.request(tour, this.terrain);
    else this.tours.stop();
    this.ask();
  }

  // The server keeps the section of the frozen view.
  private freezeAt(pose: ReturnType<Controls['pose']>): void {
    if (!this.scene || !this.picture.ground) return;
    const { low, high } = this.scene.bounds;
    const length_m = 0.3 * Math.hypot(high[0] - low[0], high[1] - low[1]);
    this.picture.frozen_view.freeze(pose, kLens.fov_rad, this.picture.aspect, length_m);
    this.picture.ground.frozenPose = this.picture.asked(pose);
  }

  // A page that has no size, as in a frame that is hidden, keeps the lens that it had; its session waits until it has one.
  private resize(): void {
    if (this.tools.record.isOn || this.picture.headset.isOn) return;
    const is_sized = this.picture.resize(window.innerWidth, window.innerHeight, this.address.sharpness);
    this.terrain?.setSized(is_sized);
    if (this.settings.exaggeration !== 1) this.ask(); // which depends on the lens
    if (is_sized && !this.terrain) this.connect();
  }

  // There, as high above the ground as before; what is known of the ground there comes with the next frames.
  private goTo(x: number, y: number): void {
    this.takeOver();
    const { controls } = this.steering, { eye, look } = controls;
    const [before, there] = [eye.toArray(), [x, y, eye.z]].map((point) => this.terrain?.place(point)?.ground ?? null);
    controls.jumpTo([x, y, eye.z + (before !== null && there !== null ? there! - before! : 0)], look);
    this.terrain?.jump();
  }
  private turnNorth(): void {
    this.takeOver();
    this.steering.controls.look.heading = 0;
  }

  // ---- a frame

  private draw(now_ms: number): void {
    const seconds = Math.min((now_ms - this.last_ms) / 1000, 0.25);
    this.last_ms = now_ms;
    const { picture, steering, terrain } = this;
    if (!this.scene) return; // there is no view yet, and the first one that is told is paid for
    const frozen = picture.frozen_view.pose;
    const position = steering.step(terrain!, now_ms, seconds, picture.up, frozen !== null);
    if (this.scene.frame === 'globe') this.followSun();
    const own = picture.headset.isOn ? picture.headset.look(steering.controls.level(picture.up)) : steering.controls.pose(picture.up);
    this.prediction.frame(now_ms, (frozen ?? own).eye);
    const frame = picture.update(now_ms, own);
    if (!frame) return;
    this.takeFrame(frame);
    const shot: Shot = { frame, pose: frozen ? own : frame.pose, camera_eye: own.eye, above_ground_m: steering.above_ground_m };
    picture.take(shot, position);
    this.tools.labels.update(now_ms);
    this.measure(now_ms, frame, position);
    this.kept_address.keep(now_ms, () => queryText(this.addressHere()));
  }

  // Over a globe, where light comes from as seen from the camera: in steps, for shadows are made anew with each.
  private followSun(): void {
    const sun = sunOverGlobe(this.settings, this.picture.up);
    if (Math.hypot(...sun.map((v, i) => v - this.picture.sunDirection[i]!)) > kSunStep_rad) this.applyLook();
  }

  private takeFrame(frame: Frame): void {
    if (frame.version > 0) this.scene_time.show(frame.sceneTime);
    this.scene_time_ms = frame.sceneTime;
    if (this.mesh) this.mesh.tau_px = frame.guaranteedPx ?? Infinity;
  }

  private measure(now_ms: number, frame: Frame, position: Place | null): void {
    const { controls } = this.steering;
    const predicts = this.settings.strategy === 'predict';
    this.map.update(this.terrain!, controls.eye.toArray(), controls.look.heading, this.picture.aspect);
    this.compass.update({ now_ms, heading_rad: controls.look.heading, pixelAtGround_m: () => this.picture.pixelAtGround_m() });
    this.readout.update({
      now_ms,
      statistics: this.terrain!.stats,
      mesh: this.mesh,
      strategy: this.settings.strategy,
      shown_late_ms: now_ms - frame.shownTime,
      is_late: this.mesh !== null && predicts && now_ms > this.mesh.to_time_ms + 20,
      prediction_error_m: predicts ? this.prediction.error_m : null,
      scene: this.scene,
      position,
      heading_rad: controls.look.heading,
      eye: controls.eye.toArray(),
      set_speed_mps: controls.speed_mps,
    });
  }
}
