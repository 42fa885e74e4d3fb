// The picture: what the graphics card holds, and a frame of it. It owns the renderer, the meshes that are drawn and that come next
// (stage.ts), the tiles on them (drape.ts), the sky and the frozen view.
import * as THREE from 'three';
import type { MeshUpdate, PartLines } from '../core/mesh_update';
import type { Screen } from '../core/screen';
import type { MapPosition, Pose, ScreenFrame, TextureLayers, Welcome } from '../core/values';
import { kLens, type Settings } from '../ui/settings';
import { cheapAnisotropy, Drape } from './drape';
import { FrozenView } from './frozen_view';
import { ObjectMesh } from './object_mesh';
import { ShadeProbe } from './shade_probe';
import { SightLines } from './sight_lines';
import { Sky } from './sky';
import { Stage } from './stage';
import { TerrainMesh } from './terrain_mesh';
import { ViewshedDrape } from './viewshed_drape';

// Of the next mesh, in a frame, in bytes; a call counts as some (blend_buffers.ts).
const kMinSlice = 128 << 10;
const kLargestSlice = 2 << 20; // at 60 frames a second

const kVisible = 8; // of 255
const kLargestSide = 16384; // of a lens, in pixels: proto/space/pose.h

// What a frame shows, and from where.
export interface Shot {
  pose: Pose;
  frame: ScreenFrame;
  position: MapPosition | null; // of the camera
  camera_eye: THREE.Vector3;
  above_ground_m: number | null; // where it is known
}

export class Picture {
  readonly renderer: THREE.WebGLRenderer;
  readonly up = new THREE.Vector3(0, 0, 1); // at the eye
  readonly sun = new THREE.Vector3(); // towards it
  readonly frozen_view = new FrozenView();
  readonly sight_lines = new SightLines();
  readonly viewshed = new ViewshedDrape();
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera();
  private readonly sky = new Sky(this.sun, this.up);
  private readonly drape: Drape;
  private readonly terrain: TerrainMesh;
  private readonly objects: ObjectMesh;
  private readonly stage: Stage;
  private welcome: Welcome | null = null;
  private last_shot: Shot | null = null;
  private uploaded = 0; // bytes, in the last frame
  private upload_limit = kLargestSlice; // of that frame
  private largest_upload = 0; // as a share of its frame's limit, since the first picture
  frames = 0;

  // `onMissing` is told of each image of a model that does not come.
  constructor(private readonly canvas: HTMLCanvasElement, from: { layers: TextureLayers; anisotropy: number | null; models: URL },
              onMissing: (what: string) => void) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.autoClear = false;
    this.drape = new Drape(this.renderer, from.layers, from.anisotropy ?? cheapAnisotropy(this.renderer));
    this.terrain = new TerrainMesh(this.renderer, this.sun, this.up, { ...this.drape.uniforms, ...this.viewshed.uniforms });
    this.objects = new ObjectMesh(this.renderer, this.terrain.uniforms, from.models, onMissing);
    this.scene.add(this.sky.object, this.terrain.object, this.objects.object, this.frozen_view.object, this.sight_lines.object);
    const [sets, object_sets] = [this.terrain.sets, this.objects.sets];
    this.stage = new Stage({ terrain: sets[0], objects: object_sets[0] }, { terrain: sets[1], objects: object_sets[1] });
  }

  get aspect(): number {
    return this.camera.aspect;
  }
  get shownVersion(): number {
    return this.stage.shownVersion;
  }
  get stagedVersion(): number {
    return this.stage.stagedVersion;
  }
  attributions(): string[] {
    return this.drape.attributions();
  }

  status(): Record<string, unknown> {
    return {
      frames: this.frames,
      mesh_version: this.terrain.version,
      triangles: this.terrain.triangles,
      object_triangles: this.objects.triangles,
      object_images: this.objects.images,
      relief_shown: this.drape.tilesShown('relief'),
      imagery_shown: this.drape.tilesShown('imagery'),
      largest_upload: this.largest_upload,
    };
  }

  // ---- what is shown

  setScene(welcome: Welcome, screen: Screen): void {
    this.welcome = welcome;
    this.terrain.setScene(welcome);
    this.objects.setScene(welcome);
    const frame = screen.slopeFrame();
    this.drape.setScene({ relief: screen.layer('relief'), imagery: screen.layer('imagery') }, frame);
    this.terrain.setNorth(frame?.is_geographic ? [0, Math.cos(frame.origin_latitude), Math.sin(frame.origin_latitude)] : [0, 1, 0]);
  }
  setTints(tints: Parameters<TerrainMesh['setTints']>[0]): void {
    this.terrain.setTints(tints);
  }
  show(settings: Settings): void {
    this.terrain.show(settings);
    this.drape.show(settings);
    this.objects.show(settings);
  }
  // False, and nothing changes, where no pixel would be left: in a frame that is hidden, or has no size yet.
  resize(width: number, height: number, sharpness: number): boolean {
    const ratio = Math.min(window.devicePixelRatio, sharpness, kLargestSide / Math.max(width, height));
    if (!(width * ratio >= 1 && height * ratio >= 1)) return false;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.fov = (kLens.fov_rad * 180) / Math.PI;
    this.terrain.setLens(kLens.fov_rad, this.canvas.height);
    return true;
  }

  // ---- meshes

  add(update: MeshUpdate): void {
    this.stage.add(update);
    this.drape.add(update);
  }
  addLines(version: number, terrain: PartLines, objects: PartLines): void {
    this.stage.addLines(version, terrain, objects);
  }

  // Of the mesh that comes next, which `wanted` says and which is shown in `left_ms`, so much that it is there in time. Of the first
  // one all.
  upload(wanted: number, left_ms: number, frame_ms: number): void {
    const next = Math.max(wanted, this.stage.shownVersion);
    this.upload_limit = Math.max(kLargestSlice, kLargestSlice * (frame_ms / 16));
    this.uploaded = 0;
    if (this.stage.shownVersion === 0) {
      this.uploadAll(next);
      return;
    }
    const frames = Math.max(1, Math.floor(left_ms / Math.max(frame_ms, 4)) - 1);
    const cost = this.stage.costTo(next) + this.drape.costTo(next);
    const budget = Math.min(Math.max(kMinSlice, cost / frames), this.upload_limit);
    this.uploaded = this.drape.upload(next, budget);
    this.uploaded += this.stage.upload(next, budget - this.uploaded);
  }
  private uploadAll(next: number): void {
    this.drape.upload(next, Infinity);
    this.stage.upload(next, Infinity);
  }
  // After showNext(), which uploads, too.
  noteUpload(): void {
    this.largest_upload = Math.max(this.largest_upload, this.uploaded / this.upload_limit);
  }

  // The newest mesh that can be shown, and the one that is being made ready.
  versions(): { ready: number; coming: number } {
    const { stage } = this;
    return this.drape.isReady(stage.readyVersion)
      ? { ready: stage.readyVersion, coming: stage.comingVersion }
      : { ready: stage.shownVersion, coming: stage.readyVersion };
  }

  showNext(): { update: MeshUpdate; triangles: number } {
    const { update, set } = this.stage.swap();
    this.terrain.draw(update, set.terrain);
    this.uploaded += this.drape.draw(update.version);
    this.objects.draw(update, set.objects);
    return { update, triangles: set.terrain.triangles };
  }

  // ---- a frame

  // Draws nothing before there is a scene.
  take(shot: Shot): void {
    if (this.welcome) this.render(shot, shot.frame.weight);
    this.last_shot = shot;
  }

  private render({ pose, position, camera_eye, above_ground_m }: Shot, weight: number): void {
    this.camera.quaternion.fromArray(pose.orientation);
    this.camera.position.set(0, 0, 0);
    this.setDepthRange(camera_eye, above_ground_m);
    this.camera.updateMatrixWorld();
    this.sky.update(this.camera);
    this.terrain.place(weight, pose.eye, position?.height_m ?? pose.eye[2]);
    this.objects.placeFrom(pose.eye);
    if (this.welcome && position) this.drape.place(position.lattice, this.welcome.samples);
    this.viewshed.place(this.drape.uniforms.u_pivot!.value as THREE.Vector2);
    this.frozen_view.place(pose.eye);
    this.sight_lines.place(pose.eye);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    ++this.frames;
  }

  // Near enough not to cut into the ground, far enough to keep depths apart to the edge of the scene.
  private setDepthRange(eye: THREE.Vector3, above_ground_m: number | null): void {
    const { low, high } = this.welcome!;
    const across_m = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const outside_m = Math.hypot(eye.x - 0.5 * (low[0] + high[0]), eye.y - 0.5 * (low[1] + high[1]), eye.z - low[2]);
    const clearance_m = Math.max(above_ground_m ?? 0.002 * across_m, 0);
    this.camera.near = Math.max(0.06 * clearance_m, 1e-5 * across_m);
    this.camera.far = across_m + outside_m;
    this.camera.updateProjectionMatrix();
  }

  // Whether an event's target is what it draws on.
  isOn(target: EventTarget | null): boolean {
    return target === this.canvas;
  }
  // The unit direction, in the scene's axes, of what was last drawn at a point of the window.
  directionAt(x: number, y: number): [number, number, number] {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector3((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height, 0.5);
    return at.unproject(this.camera).normalize().toArray();
  }

  // ---- for tests

  // How many pixels of the last frame's view differ between the end of the mesh that is drawn and the beginning of the next one,
  // `next`, and how many by more than kVisible; and how many between the beginning and the end of the one that is drawn. Null if it is
  // not known yet.
  compareEnds(next: number, showNext: () => void): { differing: number; visible: number; moved: number; pixels: number } | null {
    this.uploadAll(next);
    if (!this.stage.isNextReady || !this.last_shot) return null;
    const [begin, end] = [this.pixelsAt(0), this.pixelsAt(1)];
    showNext();
    const following = this.pixelsAt(0);
    showNext();
    const [moved, seam] = [differencesOf(begin, end), differencesOf(end, following)];
    return { differing: seam.differing, visible: seam.visible, moved: moved.differing, pixels: end.length / 4 };
  }

  // ShadeProbe.read with what the last frame drew, at a weight.
  shadeAt(positions: readonly number[], footprint: number, weight: number): number[] | null {
    if (!this.last_shot) return null;
    this.pixelsAt(weight);
    return new ShadeProbe(this.renderer, this.terrain.uniforms).read(positions, footprint);
  }

  private pixelsAt(weight: number): Uint8Array {
    this.render(this.last_shot!, weight);
    const gl = this.renderer.getContext();
    const pixels = new Uint8Array(4 * this.canvas.width * this.canvas.height);
    gl.readPixels(0, 0, this.canvas.width, this.canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  }
}

function differencesOf(one: Uint8Array, other: Uint8Array): { differing: number; visible: number } {
  let [differing, visible] = [0, 0];
  for (let i = 0; i < one.length; i += 4) {
    let most = 0;
    for (let k = 0; k < 3; ++k) most = Math.max(most, Math.abs(one[i + k]! - other[i + k]!));
    if (most > 0) ++differing;
    if (most > kVisible) ++visible;
  }
  return { differing, visible };
}
