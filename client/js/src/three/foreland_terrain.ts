// A terrain as an object of a three scene. update() before each render takes the camera, brings the next mesh to the graphics card in
// slices, and sets the weight by which the mesh that is drawn is blended.
import * as THREE from 'three';
import type { MeshUpdate, PartLines } from '../core/mesh_update.js';
import type { FrameKind, Pose } from '../core/values.js';
import { ForelandError } from '../errors.js';
import type { MeshSink } from '../mesh_sink.js';
import type { Place, Scene, Vector } from '../scene.js';
import type { Frame } from '../frame.js';
import type { Terrain } from '../terrain.js';
import { layersOf } from '../options.js';
import { Card } from './card.js';
import { kStandardMaterials, type GroundMaterials, type Uniforms } from './materials.js';
import type { Undulations } from './sea.js';
import { kDefaultStyle, type Style } from './style.js';

const kResizeQuiet_ms = 200; // a new lens is asked for when resizing has paused
const kBytesPerFrame = 2 << 20; // at 60 frames a second

export interface ForelandTerrainOptions {
  renderer: THREE.WebGLRenderer;
  /**
   * How the scene lies in the group: `local` (default) as its axes are, x east, y north and z up, metres; `ecef` with the earth's middle at
   * the group's origin; or as a matrix of rotation, translation and uniform scale says.
   */
  frame?: 'local' | 'ecef' | THREE.Matrix4;
  style?: Partial<Style>;
  /** Changes the ground's standard material before it is first compiled. */
  material?: (material: THREE.MeshStandardMaterial) => void;
  /** Draws with other materials altogether. */
  materials?: GroundMaterials;
  /** What is brought to the graphics card in a frame at 60 Hz, at most. Default 2 MiB. */
  bytesPerFrame?: number;
  /** Reads along the longer axis of what a pixel sees of imagery. Default: what the graphics card does cheaply. */
  anisotropy?: number;
  /** Size of the picture in pixels. Default: that of the renderer's drawing buffer. */
  size?: { width: number; height: number };
}

/** What is drawn now. */
export interface DrawnStats {
  version: number;
  triangles: number;
  objectTriangles: number;
  objectImages: number;
  reliefTiles: number;
  imageryTiles: number;
  /** Brought to the card in the last frame, bytes, and what of that was allowed. */
  uploadedBytes: number;
  uploadLimit: number;
}

export class ForelandTerrain extends THREE.Group {
  override readonly type: string = 'ForelandTerrain';
  /** Shows ground between vertices as the style says; change it by `setStyle`. */
  readonly style: Style;
  /** What is sent for the camera's pose while it is set, so that the mesh stays the one of that pose. */
  frozenPose: Pose | null = null;
  /** Away from the zero surface at the eye, in the scene's axes. */
  readonly upAtEye = new THREE.Vector3(0, 0, 1);
  /** Called with each mesh as it begins to be drawn. */
  onMesh: (update: MeshUpdate) => void = () => {};

  private readonly renderer: THREE.WebGLRenderer;
  private readonly sink: MeshSink;
  private readonly offs: (() => void)[] = [];
  private readonly content = new THREE.Group(); // in the scene's axes
  private card: Card | null = null;
  private detach = () => {};
  private has_sent_sun: string | null = null;
  private has_lines = false;
  private lens = { fovY: 0, width: 0, height: 0 };
  private lens_ms = -Infinity; // when it last changed
  private last_ms: number | null = null;
  private eye: Vector = [0, 0, 0];
  private undulations: Undulations | null = null;

  constructor(readonly terrain: Terrain, private readonly options: ForelandTerrainOptions) {
    super();
    this.renderer = options.renderer;
    if (!(this.renderer instanceof THREE.WebGLRenderer)) throw new ForelandError('unsupported', 'ForelandTerrain draws with a WebGLRenderer.', 'With another one, draw what `Terrain.updates` gives.');
    this.style = { ...kDefaultStyle, ...options.style };
    this.sink = this.sinkOf();
    this.content.matrixAutoUpdate = false;
    this.add(this.content);
    this.build();
    this.offs.push(terrain.on('scene', (scene) => this.enter(scene)));
    if (terrain.hasScene) this.enter(terrain.scene);
    this.watchCard(this.renderer.domElement);
  }

  // ---- each frame

  /**
   * Before each render: reads where the camera is, tells the server, and makes ready what comes. `now` is on the clock of
   * `performance.now()`. With the strategy `delay` the picture is to be drawn from the frame's pose, which `poseCamera` gives a camera.
   */
  update(camera: THREE.PerspectiveCamera, now = performance.now()): Frame | null {
    const { card, terrain } = this;
    if (!card || terrain.isOver) return terrain.lastFrame;
    const frame_ms = this.last_ms === null ? 16 : now - this.last_ms;
    this.last_ms = now;
    this.readLens(camera, now);
    const own = this.poseOf(camera);
    this.eye = [own.eye[0], own.eye[1], own.eye[2]];
    card.upload(terrain.nextVersion, (terrain.lastFrame?.endTime ?? now) - now, frame_ms, this.options.bytesPerFrame ?? kBytesPerFrame);
    const frame = terrain.frame(now, this.frozenPose ?? own, own.eye);
    if (frame.version !== 0 && frame.version !== card.shownVersion) this.showNext();
    this.place(frame.weight, this.frozenPose ? own.eye : frame.pose.eye);
    return frame;
  }

  /** The camera's pose in the scene's axes. */
  poseOf(camera: THREE.PerspectiveCamera): Pose {
    if (!camera.isPerspectiveCamera) throw new ForelandError('argument', 'A terrain is streamed for perspective cameras.');
    camera.updateWorldMatrix(true, false);
    this.content.updateWorldMatrix(true, false);
    kMatrix.copy(this.content.matrixWorld).invert().multiply(camera.matrixWorld).decompose(kPosition, kTurn, kScale);
    return { eye: [kPosition.x, kPosition.y, kPosition.z], orientation: [kTurn.x, kTurn.y, kTurn.z, kTurn.w] };
  }
  /** Puts a camera where a pose in the scene's axes says. */
  poseCamera(camera: THREE.Camera, { eye, orientation }: Pose): void {
    this.content.updateWorldMatrix(true, false);
    kMatrix.compose(kPosition.fromArray(eye), kTurn.fromArray(orientation), kScale.set(1, 1, 1)).premultiply(this.content.matrixWorld);
    if (camera.parent) kMatrix.premultiply(kInverse.copy(camera.parent.matrixWorld).invert());
    kMatrix.decompose(camera.position, camera.quaternion, kScale);
  }
  /** Depths between which the camera sees the terrain: near enough not to cut into the ground, far enough for the edge of the scene. */
  depthRange(eye: readonly number[] = this.eye, aboveGround?: number | null): { near: number; far: number } {
    if (!this.terrain.hasScene) return { near: 0.1, far: 1e5 };
    const { low, high } = this.terrain.scene.bounds;
    if (this.terrain.scene.frame === 'globe') return globeDepths(this.terrain.scene, eye, this.terrain.place(eye), aboveGround);
    const across_m = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const outside_m = Math.hypot(eye[0]! - 0.5 * (low[0] + high[0]), eye[1]! - 0.5 * (low[1] + high[1]), eye[2]! - low[2]);
    if (aboveGround === undefined) {
      const place = this.terrain.place(eye);
      aboveGround = place && place.ground !== null ? place.height - place.ground : null;
    }
    const clearance_m = Math.max(aboveGround ?? 0.002 * across_m, 0);
    return { near: Math.max(0.06 * clearance_m, 1e-5 * across_m), far: across_m + outside_m };
  }

  /** Changes what is given of the style. */
  setStyle(style: Partial<Style>): void {
    Object.assign(this.style, style);
    this.showStyle();
  }
  /** Of a globe: where its sea lies, by which natural ground is coloured. */
  setUndulations(undulations: Undulations | null): void {
    this.undulations = undulations;
    if (undulations) this.card?.terrain.setUndulations(undulations);
  }
  /** From the scene's axes to the world's. Read it, and write it not. */
  get sceneToWorld(): THREE.Matrix4 {
    this.content.updateWorldMatrix(true, false);
    return this.content.matrixWorld;
  }
  /** Of the shaders that draw the ground, for materials of one's own (`glsl`). Others after the graphics card was reset. */
  get uniforms(): Uniforms {
    return this.card?.terrain.uniforms ?? {};
  }
  get drawn(): DrawnStats {
    const { card } = this;
    return {
      version: card?.terrain.version ?? 0, triangles: card?.terrain.triangles ?? 0, objectTriangles: card?.objects.triangles ?? 0,
      objectImages: card?.objects.images ?? 0, reliefTiles: card?.drape.tilesShown('relief') ?? 0, imageryTiles: card?.drape.tilesShown('imagery') ?? 0,
      uploadedBytes: card?.uploaded ?? 0, uploadLimit: card?.upload_limit ?? 1,
    };
  }
  /** The ground's material; of it a standard material unless `materials` was given. */
  get groundMaterial(): THREE.Material | null {
    return (this.card?.terrain.surface.material as THREE.Material | undefined) ?? null;
  }

  /** Where a ray meets ground or an object of the scene first, of what is held. The intersection's `instanceId` is the object's number. */
  override raycast(raycaster: THREE.Raycaster, intersects: THREE.Intersection[]): void {
    const to_scene = kInverse.copy(this.sceneToWorld).invert();
    const ray = kRay.copy(raycaster.ray).applyMatrix4(to_scene);
    const met = this.terrain.pick(ray.origin.toArray(), ray.direction.toArray());
    if (!met) return;
    const point = new THREE.Vector3().fromArray(met.point).applyMatrix4(this.sceneToWorld);
    const distance = raycaster.ray.origin.distanceTo(point);
    if (distance < raycaster.near || distance > raycaster.far) return;
    intersects.push({ distance, point, object: this, ...(met.object === null ? {} : { instanceId: met.object }) });
  }

  /** Gives back all that it has on the graphics card. The terrain stays open. */
  override dispose(): void {
    for (const off of this.offs.splice(0)) off();
    this.detach();
    this.dropCard();
    this.removeFromParent();
  }

  // ---- for tests of the seam between two meshes

  /** Whether the mesh that follows the one that is drawn is on the card; all that has come is brought there. */
  stageAll(): boolean {
    this.card?.uploadAll(Math.max(this.terrain.nextVersion, this.card.shownVersion));
    return this.card?.isNextReady ?? false;
  }
  /** Draws that mesh from now on; twice, and all is as it was. */
  showNext(): void {
    const update = this.card!.showNext();
    this.tellAttributions();
    this.onMesh(update);
  }
  /** Blends the mesh that is drawn by another weight, for an eye in the scene's axes. */
  place(weight: number, eye: readonly number[]): void {
    const { card, terrain } = this;
    const position = terrain.place(eye);
    if (!card || !position) return;
    this.upAtEye.fromArray(position.up);
    card.terrain.place(weight, eye, position.up);
    card.drape.place(position.lattice, terrain.scene.samples as [number, number]);
  }

  // ---- parts

  private sinkOf(): MeshSink {
    const card = () => this.card;
    return {
      add: (update) => card()?.add(update),
      addLines: (version: number, terrain: PartLines, objects: PartLines) => {
        card()?.addLines(version, terrain, objects);
        this.showStyle();
      },
      reset: () => card()?.reset(),
      get ready() { return card()?.versions().ready ?? 0; },
      get coming() { return card()?.versions().coming ?? 0; },
      get staged() { return card()?.stagedVersion ?? 0; },
    };
  }

  private build(): void {
    const { options, terrain } = this;
    const materials = options.materials ?? kStandardMaterials;
    const card = (this.card = new Card(this.renderer, {
      layers: layersOf(terrain.limits), anisotropy: options.anisotropy ?? null, models: new URL('models/', terrain.files), materials,
      onMissing: (what) => terrain.warn(`An image of a model did not come: ${what}`),
    }));
    if (options.material && !options.materials) options.material(card.terrain.surface.material as THREE.MeshStandardMaterial);
    this.content.add(card.terrain.object, card.objects.object);
    this.lens = { fovY: 0, width: 0, height: 0 };
    this.detach = terrain.attach(this.sink);
  }
  private dropCard(): void {
    this.content.clear();
    this.card?.dispose();
    this.card = null;
  }

  private enter(scene: Scene): void {
    const { frame = 'local' } = this.options;
    if (frame === 'ecef' && !scene.toEcef) throw new ForelandError('argument', `The scene is on a map (${scene.crs}), and has no place on the earth.`, "Use frame: 'local'.");
    if (frame === 'ecef') this.content.matrix.fromArray(scene.toEcef!);
    else if (frame !== 'local') this.content.matrix.copy(frame);
    this.content.matrixWorldNeedsUpdate = true;
    this.enterCard();
  }
  private enterCard(): void {
    const { card, terrain } = this;
    const { screen, welcome } = terrain;
    if (!card || !screen || !welcome) return;
    const slopes = screen.slopeFrame();
    card.terrain.setScene(welcome, northOf(welcome.frame, slopes?.origin_latitude ?? 0));
    this.setUndulations(this.undulations);
    card.objects.setScene(welcome);
    card.drape.setScene({ relief: screen.layer('relief'), imagery: screen.layer('imagery') }, slopes);
    this.showStyle();
  }

  private showStyle(): void {
    const { card, style, terrain } = this;
    if (!card) return;
    card.terrain.show(style);
    card.drape.show({ relief: style.relief, imagery: style.imagery, shadows: style.reliefShadows });
    card.objects.show(style);
    const sun = style.reliefShadows && style.relief ? style.sun : null;
    if (JSON.stringify(sun) !== this.has_sent_sun) terrain.setSun(sun && (new THREE.Vector3(...sun).normalize().toArray() as Vector));
    this.has_sent_sun = JSON.stringify(sun);
    if (style.wireframe !== this.has_lines) terrain.setLines(style.wireframe);
    this.has_lines = style.wireframe;
    this.tellAttributions();
  }
  private tellAttributions(): void {
    this.terrain.noteAttributions(this.card?.drape.attributions() ?? []);
  }

  private readLens(camera: THREE.PerspectiveCamera, now: number): void {
    const { width, height } = this.options.size ?? sizeOf(this.renderer);
    const fovY = 2 * Math.atan(Math.tan((camera.fov * Math.PI) / 360) / camera.zoom);
    if (fovY !== this.lens.fovY || width !== this.lens.width || height !== this.lens.height) {
      const is_first = this.lens.fovY === 0;
      this.lens = { fovY, width, height };
      this.lens_ms = is_first ? -Infinity : now;
      this.card?.terrain.setLens(fovY, height);
    }
    if (this.lens_ms !== null && now - this.lens_ms >= kResizeQuiet_ms && width >= 1 && height >= 1) {
      this.lens_ms = Infinity;
      this.terrain.setLens(this.lens);
    }
  }

  // What the card held is lost with it, and made anew once the renderer has its context back.
  private watchCard(canvas: HTMLCanvasElement): void {
    const lose = () => {
      this.terrain.leaveOutMeshes();
      this.detach();
      this.dropCard();
    };
    const restore = () => {
      if (this.card || this.terrain.isOver) return;
      this.build();
      this.enterCard();
    };
    canvas.addEventListener('webglcontextlost', lose);
    canvas.addEventListener('webglcontextrestored', restore);
    this.offs.push(() => canvas.removeEventListener('webglcontextlost', lose), () => canvas.removeEventListener('webglcontextrestored', restore));
  }
}

// Towards the pole, or the map's north.
function northOf(kind: FrameKind, origin_latitude: number): [number, number, number] {
  if (kind === 'globe') return [0, 0, 1];
  return kind === 'planar' ? [0, 1, 0] : [0, Math.cos(origin_latitude), Math.sin(origin_latitude)];
}

// To the farthest ground that may stand over the horizon, from the nearest that may be below the eye.
function globeDepths({ bounds: { high }, heights }: Scene, eye: readonly number[], place: Place | null, above_ground?: number | null): { near: number; far: number } {
  const inside_m = high[2] - heights.highest + heights.lowest; // of a ball below all ground
  const beyond_m = (from_m: number) => Math.sqrt(Math.max(from_m ** 2 - inside_m ** 2, 0));
  const far = beyond_m(Math.hypot(...eye)) + beyond_m(high[0]) + 1, over_m = place ? place.height - heights.highest : 0;
  const clearance_m = above_ground ?? (place && place.ground !== null ? place.height - place.ground : 0);
  return { near: Math.max(0.9 * over_m, 0.06 * clearance_m, 0.1), far };
}

function sizeOf(renderer: THREE.WebGLRenderer): { width: number; height: number } {
  renderer.getDrawingBufferSize(kSize);
  return { width: kSize.x, height: kSize.y };
}

const kMatrix = new THREE.Matrix4(), kInverse = new THREE.Matrix4();
const kPosition = new THREE.Vector3(), kScale = new THREE.Vector3();
const kTurn = new THREE.Quaternion();
const kRay = new THREE.Ray();
const kSize = new THREE.Vector2();
