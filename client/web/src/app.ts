// The page's parts and what flows between them, frame by frame: camera -> client core -> graphics card -> readout. It owns the one
// mutable state of the page: the session, the settings and the camera.
import * as THREE from 'three';
import { lookOf } from './ui/camera';
import { Connection } from './core/connection';
import { Controls } from './ui/controls';
import { Core, Viewer, type Frame, type Mesh, type MapPosition, type Pose, type Request, type Welcome } from './core/core';
import { FrozenView } from './draw/frozen_view';
import { showNotice } from './ui/notice';
import { Panel } from './ui/panel';
import { PredictionCheck } from './core/prediction_check';
import { Readout } from './ui/readout';
import { kLens, type Address, type Settings, type Tour } from './ui/settings';
import { SceneTime } from './ui/scene_time';
import { Sky } from './draw/sky';
import { startView } from './ui/start_view';
import { ObjectMesh } from './draw/object_mesh';
import { TerrainMesh } from './draw/terrain_mesh';
import { Tours } from './ui/tours';

const kResizeQuiet_ms = 200; // a new lens is requested when resizing has paused
const kHintShown_ms = 9000;
// For terrain that was flown over. Phones have less to spare.
const kMemoryBytes = (window.matchMedia('(pointer: coarse)').matches ? 6 : 16) << 20;

function byId(id: string): HTMLElement {
  return document.getElementById(id)!;
}

export class App {
  private readonly canvas = byId('scene') as HTMLCanvasElement;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera();
  private readonly up = new THREE.Vector3(0, 0, 1); // at the eye
  private readonly sky = new Sky(this.up);
  private readonly frozen_view = new FrozenView();
  private may_occlude = false; // this connection's deltas can tell hidden blocks
  private readonly terrain: TerrainMesh;
  private readonly objects: ObjectMesh;
  private readonly controls = new Controls(this.canvas);
  private readonly readout = new Readout(byId('readout'));
  private readonly prediction = new PredictionCheck();
  private readonly tours: Tours;
  private readonly scene_time = new SceneTime(byId('time'), (scene_ms, rate) =>
    this.viewer.setSceneClock(performance.now(), scene_ms, rate));
  private readonly connection: Connection;
  private readonly settings: Settings;
  private viewer: Viewer;
  private welcome: Welcome | null = null;
  private mesh: (Pick<Mesh, 'triangles' | 'vertices' | 'to_nodes' | 'to_time_ms' | 'version'> & { tau_px: number }) | null = null;
  private sent_request = ''; // the last one, as JSON
  private lens_timer = 0;
  private above_ground_m: number | null = null; // where it is known
  private scene_time_ms = 0; // of the last frame
  private last_ms = 0;
  private frames = 0;

  constructor(private readonly core: Core, private readonly address: Address) {
    this.settings = address.settings;
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.autoClear = false;
    this.terrain = new TerrainMesh(this.renderer, this.up);
    this.objects = new ObjectMesh(this.renderer, this.terrain.uniforms, modelsOf(address.server));
    this.scene.add(this.sky.object, this.terrain.object, this.objects.object, this.frozen_view.object);
    this.resize();
    this.viewer = new Viewer(core, this.request());
    this.tours = new Tours(byId('tours'), (tour) => this.chooseTour(tour));
    const token = address.token === null ? '' : `?token=${encodeURIComponent(address.token)}`;
    this.connection = new Connection(address.server + token, {
      onOpen: () => this.beginSession(),
      onMessage: (message) => this.receive(message),
      onWaiting: (seconds, reason) => this.showWaiting(seconds, reason),
    });
    this.controls.onTakeOver = () => this.tours.current && this.chooseTour(null);
    new Panel(byId('panel'), this.settings, () => this.applySettings());
    window.addEventListener('resize', () => this.resize());
    this.canvas.addEventListener('webglcontextlost', () => this.stop('The graphics card was reset.', 'Reload the page to continue.'));
  }

  start(): void {
    showNotice(byId('notice'), { kind: 'wait', title: 'Connecting', text: this.address.server });
    this.connection.open();
    this.renderer.setAnimationLoop(() => this.drawOrStop(performance.now()));
    byId('hint').textContent = window.matchMedia('(pointer: coarse)').matches
      ? 'One finger looks, two fingers fly'
      : 'Drag to look \u00b7 W A S D to fly \u00b7 E Q up and down \u00b7 wheel sets the speed';
    window.setTimeout(() => byId('hint').classList.add('gone'), kHintShown_ms);
  }

  // For tests, and for anyone who opens the console.
  status(): Record<string, unknown> {
    return {
      connected: this.connection.isOpen(),
      frames: this.frames,
      mesh_version: this.terrain.version,
      triangles: this.terrain.triangles,
      object_triangles: this.objects.triangles,
      object_images: this.objects.images,
      nodes: this.mesh?.to_nodes ?? 0,
      tau_px: this.mesh?.tau_px ?? 0,
      blend: this.settings.blend,
      touring: this.tours.isFlying,
      frozen: this.frozen_view.pose !== null,
      eye: this.controls.eye.toArray(),
      heading: this.controls.look.heading,
      above_ground_m: this.above_ground_m,
      title: this.welcome?.title ?? null,
      scene_time_ms: this.scene_time_ms,
      ...this.viewer.statistics(),
    };
  }

  // ---- session

  // Begins a session on a new connection. After a lost connection the viewer resumes from the section that it holds.
  private beginSession(): void {
    this.may_occlude = this.settings.occlusion;
    if (this.welcome) {
      this.viewer.reconnect(performance.now());
    } else {
      this.viewer.destroy();
      this.viewer = new Viewer(this.core, this.request());
      this.terrain.forget();
      this.objects.forget();
      this.viewer.setBlend(this.settings.blend);
      this.sent_request = JSON.stringify(this.request());
      if (this.address.tour) this.tours.request(this.address.tour, this.viewer);
    }
    this.sendOutgoing();
  }

  private receive(message: Uint8Array): void {
    const refusal = this.viewer.receive(message, performance.now());
    if (refusal !== null) {
      this.connection.close();
      this.stop('The session ended.', refusal);
      return;
    }
    if (this.welcome && byId('notice').hidden) return;
    const welcome = this.viewer.welcome();
    if (!welcome) return;
    showNotice(byId('notice'), null);
    this.enterScene(welcome);
  }

  private enterScene(welcome: Welcome): void {
    const is_first = this.welcome === null;
    this.welcome = welcome;
    this.terrain.setScene(welcome);
    this.objects.setScene(welcome);
    this.terrain.show(this.settings);
    this.objects.show(this.settings);
    this.scene_time.setEpochs(welcome.epochs_ms);
    byId('scene-title').textContent = welcome.title;
    document.title = `${welcome.title} \u00b7 Foreland`;
    if (!is_first) return;
    this.controls.setBox(welcome.low, welcome.high);
    const { eye, look } = startView(welcome);
    this.controls.eye.fromArray(this.address.view?.slice(0, 3) ?? eye);
    const [heading, pitch] = (this.address.view?.slice(3) ?? []).map((degrees) => (degrees * Math.PI) / 180);
    this.controls.look = heading === undefined ? look : { heading, pitch: pitch! };
  }

  private sendOutgoing(): void {
    for (let message = this.viewer.takeOutgoing(); message; message = this.viewer.takeOutgoing()) this.connection.send(message);
  }

  private showWaiting(seconds: number, reason: string): void {
    const title = this.welcome ? 'Connection lost' : 'The server does not answer';
    const said = reason === '' ? '' : `The server said: ${reason}. `;
    const text = `${said}Trying ${this.address.server} again in ${seconds < 1 ? 'a moment' : `${seconds} s`}.`;
    showNotice(byId('notice'), { kind: 'wait', title, text });
  }

  private stop(title: string, text: string): void {
    const action = { label: 'Try again', run: () => window.location.reload() };
    showNotice(byId('notice'), { kind: 'error', title, text, action });
  }

  // ---- what the user chooses

  private request(): Request {
    const { strategy, predictor, tau_px, keyframe_ms, occlusion } = this.settings;
    const automatic = this.tours?.current ? 'path' : 'velocity';
    return {
      fov_rad: kLens.fov_rad,
      width_px: this.canvas.width,
      height_px: this.canvas.height,
      strategy,
      predictor: predictor === 'auto' ? automatic : predictor,
      tau_px,
      keyframe_ms,
      occlusion,
      memory_bytes: kMemoryBytes,
    };
  }

  private applySettings(): void {
    this.terrain.show(this.settings);
    this.objects.show(this.settings);
    if (this.settings.frozen && !this.frozen_view.pose) this.freeze();
    if (!this.settings.frozen) this.frozen_view.thaw();
    this.viewer.setBlend(this.settings.blend);
    this.sendRequest();
    if (this.settings.occlusion && !this.may_occlude && this.connection.isOpen()) this.connection.open(); // and resumes
  }

  // Sends the request if it differs from the last one.
  private sendRequest(): void {
    const request = this.request();
    if (JSON.stringify(request) === this.sent_request) return;
    this.sent_request = JSON.stringify(request);
    this.viewer.setRequest(request);
  }

  private chooseTour(tour: Tour | null): void {
    if (tour) this.tours.request(tour, this.viewer);
    else this.tours.stop();
    this.sendRequest();
  }

  private freeze(): void {
    if (!this.welcome) return;
    const { low, high } = this.welcome;
    const length_m = 0.3 * Math.hypot(high[0] - low[0], high[1] - low[1]);
    this.frozen_view.freeze(this.controls.pose(this.up), kLens.fov_rad, this.camera.aspect, length_m);
  }

  private resize(): void {
    const [width, height] = [window.innerWidth, window.innerHeight];
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, this.address.sharpness));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.fov = (kLens.fov_rad * 180) / Math.PI;
    this.terrain.setLens(kLens.fov_rad, this.canvas.height);
    window.clearTimeout(this.lens_timer);
    this.lens_timer = window.setTimeout(() => this.sendRequest(), kResizeQuiet_ms);
  }

  // ---- a frame

  private drawOrStop(now_ms: number): void {
    try {
      this.draw(now_ms);
    } catch (error) {
      this.renderer.setAnimationLoop(null);
      this.connection.close();
      this.stop('The page failed.', (error as Error).message);
      throw error;
    }
  }

  private draw(now_ms: number): void {
    const seconds = Math.min((now_ms - this.last_ms) / 1000, 0.25);
    this.last_ms = now_ms;
    const position = this.welcome ? this.moveCamera(now_ms, seconds) : null;
    const own = this.controls.pose(this.up);
    const sent = this.frozen_view.pose ?? own; // the server keeps the section of the frozen view
    const frame = this.viewer.frame(now_ms, sent);
    this.takeMesh(frame, now_ms, sent);
    this.sendOutgoing();
    const shown = this.frozen_view.pose ? own : frame.pose;
    if (this.welcome) this.render(shown, frame, position);
    this.measure(now_ms, frame, position);
  }

  private moveCamera(now_ms: number, seconds: number): MapPosition | null {
    const mapPositionOf = (eye: readonly number[]) => this.viewer.mapPosition(eye);
    const touring = this.tours.pose(this.viewer, now_ms);
    if (touring && !this.frozen_view.pose) {
      this.controls.eye.fromArray(touring.eye);
      this.controls.look = lookOf(touring.orientation, this.up);
    } else {
      this.controls.step(seconds, this.up, mapPositionOf);
    }
    const position = mapPositionOf(this.controls.eye.toArray());
    if (position) this.up.fromArray(position.up);
    this.above_ground_m = position && position.ground_m !== null ? position.height_m - position.ground_m : null;
    return position;
  }

  private takeMesh(frame: Frame, now_ms: number, sent: Pose): void {
    this.prediction.frame(now_ms, sent.eye);
    if (this.mesh) this.mesh.tau_px = frame.tau_px;
    if (frame.mesh_version > 0) this.scene_time.show(frame.scene_time_ms);
    this.scene_time_ms = frame.scene_time_ms;
    if (!this.terrain.needsUpload(frame.mesh_version)) return;
    const changes = this.viewer.takeChanges();
    const mesh = this.viewer.mesh();
    this.terrain.upload(mesh, changes.terrain);
    this.objects.upload(mesh, changes.objects);
    this.prediction.expect(mesh.to_time_ms, mesh.to_pose.eye);
    const { triangles, vertices, to_nodes, to_time_ms, version } = mesh; // the arrays do not outlive this frame
    this.mesh = { triangles, vertices, to_nodes, tau_px: frame.tau_px, to_time_ms, version };
  }

  private render(pose: Pose, frame: Frame, position: MapPosition | null): void {
    this.camera.quaternion.fromArray(pose.orientation);
    this.camera.position.set(0, 0, 0);
    this.setDepthRange();
    this.camera.updateMatrixWorld();
    this.sky.update(this.camera);
    this.terrain.place(frame.weight, pose.eye, position?.height_m ?? pose.eye[2]);
    this.objects.placeFrom(pose.eye);
    this.frozen_view.place(pose.eye);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    ++this.frames;
  }

  // Near enough not to cut into the ground, far enough to keep depths apart to the edge of the scene.
  private setDepthRange(): void {
    const { low, high } = this.welcome!;
    const across_m = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const eye = this.controls.eye;
    const outside_m = Math.hypot(eye.x - 0.5 * (low[0] + high[0]), eye.y - 0.5 * (low[1] + high[1]), eye.z - low[2]);
    const clearance_m = this.above_ground_m ?? 0.002 * across_m;
    this.camera.near = Math.max(0.06 * clearance_m, 1e-5 * across_m);
    this.camera.far = across_m + outside_m;
    this.camera.updateProjectionMatrix();
  }

  private measure(now_ms: number, frame: Frame, position: MapPosition | null): void {
    this.readout.update({
      now_ms,
      statistics: this.viewer.statistics(),
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
