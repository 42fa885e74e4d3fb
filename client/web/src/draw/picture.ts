// The picture: a canvas with its renderer, the terrain with the page's own look, the sky and the frozen view; and a frame of it.
import type { Frame, Place, Pose, Scene, Terrain, Vector } from '@foreland/client';
import { ForelandTerrain, type Sea } from '@foreland/client/three';
import * as THREE from 'three';
import { kLens, type Settings } from '../ui/settings';
import { metNow, wayAlong, type Met } from '../cut/rays';
import { CutView, type Cut } from './cut_view';
import { askedLens, askedPose, shownPose, type AskedLens } from './exaggeration';
import type { Air } from './air';
import { DeepCanvas } from './deep_canvas';
import { FlightMarks } from './flight_marks';
import { FrozenView } from './frozen_view';
import { Headset } from './headset';
import { pageMaterials } from './materials';
import { MeasureLine } from './measure_line';
import { NameTexts } from './name_texts';
import { OverlayDrape } from './overlay_drape';
import { OverlayMarks } from './overlay_marks';
import { SeaSurface } from './sea';
import { ShadeProbe } from './shade_probe';
import { kTerrainVertex } from './shaders';
import { SightLines } from './sight_lines';
import { Sky } from './sky';
import { ViewshedDrape } from './viewshed_drape';

const kVisible = 8; // of 255
const kTolerances = 1.25; // that ground may lie below the sea before that hides it: its own, and what the geoid bends until there
const kLargestSide = 16384; // of a lens, in pixels: proto/space/pose.h

// What a frame shows, and from where.
export interface Shot {
  frame: Frame;
  pose: Pose; // that it is drawn from
  camera_eye: readonly number[];
  above_ground_m: number | null; // where it is known
}

export class Picture {
  readonly renderer: THREE.WebGLRenderer;
  readonly headset: Headset;
  readonly frozen_view = new FrozenView();
  readonly sight_lines = new SightLines();
  readonly measure_line = new MeasureLine();
  readonly flight_marks = new FlightMarks();
  readonly viewshed_drape = new ViewshedDrape();
  readonly overlay_drape = new OverlayDrape();
  readonly overlay_marks = new OverlayMarks();
  readonly name_texts = new NameTexts();
  readonly cut_view = new CutView();
  readonly up = new THREE.Vector3(0, 0, 1); // at the camera's eye
  ground: ForelandTerrain | null = null;
  private readonly sun = new THREE.Vector3(); // towards it
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera();
  private readonly sky = new Sky(this.sun, this.up);
  readonly sea = new SeaSurface(this.sun, this.up);
  private readonly haze = { u_haze: { value: 0 }, u_haze_height: { value: 1 }, u_eye_height: { value: 0 }, u_exaggeration: { value: 1 } };
  private exaggeration = 1; // of heights
  private readonly told = new THREE.PerspectiveCamera(); // that the server is told of
  private asked_lens = { key: '', lens: { tan_x: 1, tan_y: 1, finer: 1 } };
  private readonly told_size = { width: 1, height: 1 };
  private thickness = 0; // of the haze, where it is shown
  private deep: DeepCanvas | null = null; // of a globe
  private air: Air | null = null;
  private has_air = true; // that is shown
  private tau_px = 1; // that is wanted
  private last_shot: Shot | null = null;
  private largest_upload = 0; // as a share of its frame's limit, since the first picture
  frames = 0;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly anisotropy: number | null) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.autoClear = false;
    this.headset = new Headset(this.renderer);
    this.scene.add(this.sky.object, this.sea.object, this.frozen_view.object, this.sight_lines.object, this.measure_line.object, this.overlay_marks.object, this.name_texts.object, this.cut_view.object,
      this.flight_marks.lines, this.flight_marks.aircraft);
  }

  // Shows a terrain; once.
  show(terrain: Terrain): void {
    this.ground = new ForelandTerrain(terrain, {
      renderer: this.renderer, size: this.told_size, materials: pageMaterials(this.haze, { ...this.viewshed_drape.uniforms, ...this.overlay_drape.uniforms }, this.cut_view), ...(this.anisotropy === null ? {} : { anisotropy: this.anisotropy }),
    });
    this.scene.add(this.ground);
    this.cut_view.begin({ ...this.ground.uniforms, ...this.haze });
  }
  dispose(): void {
    void this.headset.session?.end();
    this.ground?.dispose();
    this.overlay_drape.dispose();
    this.overlay_marks.dispose();
    this.cut_view.dispose();
    this.name_texts.clear();
    this.deep?.dispose();
    this.air?.dispose();
    this.sea.dispose();
    this.renderer.dispose();
  }

  get sunDirection(): Vector {
    return this.sun.toArray();
  }
  get aspect(): number {
    return this.camera.aspect;
  }
  get shownVersion(): number {
    return this.ground?.drawn.version ?? 0;
  }
  get triangles(): number {
    return this.ground?.drawn.triangles ?? 0;
  }

  status(): Record<string, unknown> {
    const drawn = this.ground?.drawn;
    return {
      frames: this.frames,
      ...this.headset.status(),
      shown_pose: this.last_shot?.pose ?? null,
      depth_reversed: this.deep?.isReversed ?? false,
      air: this.air !== null && this.has_air,
      sea: this.sea.uniforms.u_sea.value === 1,
      mesh_version: drawn?.version ?? 0,
      triangles: drawn?.triangles ?? 0,
      object_triangles: drawn?.objectTriangles ?? 0,
      object_images: drawn?.objectImages ?? 0,
      relief_shown: drawn?.reliefTiles ?? 0,
      imagery_shown: drawn?.imageryTiles ?? 0,
      largest_upload: this.largest_upload,
    };
  }

  // ---- what is shown

  // Haze follows the scene's size and relief.
  setScene({ frame, bounds: { low, high }, heights }: Scene): void {
    const across_m = Math.hypot(high[0] - low[0], high[1] - low[1]);
    this.haze.u_haze_height.value = 0.9 * Math.max(heights.highest - heights.lowest, 1e-3 * across_m, 1e-3);
    this.thickness = frame === 'globe' ? 0 : 1.8 / across_m;
    this.sky.setFrame(frame);
    if (frame === 'globe') this.deep ??= new DeepCanvas(this.renderer);
  }
  // Of a globe whose air is known.
  takeAir({ air, ground, sea, sky }: { air: Air; ground: string; sea: string; sky: string }): void {
    const material = this.ground?.groundMaterial as THREE.RawShaderMaterial;
    this.air = air;
    air.uniforms.u_air!.value = this.has_air ? 1 : 0;
    material.fragmentShader = ground;
    Object.assign(material.uniforms, air.uniforms, this.sea.uniforms);
    material.needsUpdate = true;
    this.sky.takeAir(sky, air.uniforms);
    this.sea.takeAir(sea, air.uniforms);
  }
  takeSea(sea: Sea): void {
    const { scene } = this.ground!.terrain;
    this.ground!.setUndulations(sea.undulations);
    this.sea.take(sea, scene.ellipsoid!, scene.heights.lowest);
  }
  setLook(settings: Settings, sun: [number, number, number]): void {
    this.sun.set(...sun);
    this.haze.u_haze.value = settings.fog ? this.thickness : 0;
    this.has_air = settings.fog;
    this.tau_px = settings.tau_px;
    this.sea.wanted = settings.sea;
    if (this.air) this.air.uniforms.u_air!.value = settings.fog ? 1 : 0;
    const { ground, contours, relief, imagery, wireframe, snow_line: snowLine, change, shadows: reliefShadows } = settings;
    this.ground?.setStyle({ ground, contours, relief, imagery, wireframe, snowLine, change, reliefShadows, sun });
  }
  // False, and nothing changes, where no pixel would be left: in a frame that is hidden, or has no size yet.
  resize(width: number, height: number, sharpness: number): boolean {
    const ratio = Math.min(window.devicePixelRatio, sharpness, kLargestSide / Math.max(width, height));
    if (!(width * ratio >= 1 && height * ratio >= 1)) return false;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.fov = (kLens.fov_rad * 180) / Math.PI;
    return true;
  }

  // Null: none. Pins on what it takes away are not drawn.
  showCut(cut: Cut | null): void {
    this.cut_view.show(cut);
    this.overlay_marks.cut(cut);
  }

  // In pixels of its own, whatever the window has.
  sizeExactly(width: number, height: number): void {
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
  }

  // ---- a frame

  // Heights are drawn so many times as tall. Gives how much smaller the tolerance that is asked for has to be.
  exaggerate(factor: number): number {
    this.exaggeration = this.haze.u_exaggeration.value = factor;
    return this.toldLens().finer;
  }
  // What the server is told of a camera, and the other way round.
  asked(pose: Pose): Pose {
    return askedPose(pose, this.exaggeration, kLens.fov_rad);
  }
  shown(pose: Pose): Pose {
    return shownPose(pose, this.exaggeration, kLens.fov_rad);
  }

  // Tells the server where the camera is, and makes ready what comes. Null before there is anything to tell.
  update(now_ms: number, own: Pose): Frame | null {
    if (!this.ground) return null;
    const had_mesh = this.shownVersion > 0;
    const finer = this.setTold(own), frame = this.ground.update(this.told, now_ms);
    const { uploadedBytes, uploadLimit } = this.ground.drawn;
    if (had_mesh) this.largest_upload = Math.max(this.largest_upload, uploadedBytes / Math.max(uploadLimit, 1));
    return frame && { ...frame, pose: this.shown(frame.pose), guaranteedPx: frame.guaranteedPx === null ? null : finer * frame.guaranteedPx };
  }
  private setTold(own: Pose): number {
    const { told, ground } = this, { fov_deg, width, height, finer } = this.toldLens();
    ground!.poseCamera(told, this.asked(own));
    told.fov = fov_deg;
    Object.assign(this.told_size, { width, height });
    return finer;
  }
  // With as many pixels for an angle as the canvas has.
  private toldLens(): ToldLens {
    const { exaggeration, aspect, camera, headset } = this;
    if (headset.isOn && headset.lens) return toldLens({ ...headset.lens, finer: headset.lens.growth }, headset.lens.focal_px);
    const [wide, high] = this.renderer.getDrawingBufferSize(kSize).toArray() as [number, number];
    if (exaggeration === 1) return { fov_deg: camera.fov, width: wide, height: high, finer: 1 };
    const key = `${aspect} ${exaggeration}`, { lens } = this.asked_lens.key === key ? this.asked_lens : (this.asked_lens = { key, lens: askedLens(kLens.fov_rad, aspect, exaggeration) });
    return toldLens(lens, high / (2 * Math.tan(kLens.fov_rad / 2)));
  }

  // Draws nothing before there is a scene.
  take(shot: Shot, position: Place | null): void {
    this.haze.u_eye_height.value = position?.height ?? shot.pose.eye[2];
    if (this.ground?.terrain.hasScene) this.render(shot);
    this.last_shot = shot;
  }

  private render({ pose, camera_eye, above_ground_m }: Shot): void {
    const { camera, ground } = this;
    ground!.poseCamera(camera, pose);
    const { near, far } = ground!.depthRange(camera_eye, above_ground_m), e = this.exaggeration;
    Object.assign(camera, { near: near * Math.min(e, 1), far: far * Math.max(e, 1) });
    camera.updateProjectionMatrix();
    this.setMatrices();
    this.sky.update(camera);
    this.air?.place(camera.position);
    this.placeSea();
    const pivot = ground!.uniforms.u_pivot!.value as THREE.Vector2;
    this.viewshed_drape.place(pivot);
    this.overlay_drape.place(pivot);
    this.cut_view.place(pivot, camera.position);
    this.name_texts.place(camera, this.canvas.clientHeight);
    const seen = this.headset.isOn ? Object.assign(this.headset.camera, { near: camera.near, far: camera.far }) : camera;
    const draw = () => this.flight_marks.draw(this.renderer, this.scene, seen);
    if (this.deep) this.deep.draw(draw);
    else draw();
    ++this.frames;
  }

  private placeSea(): void {
    const { camera, deep, ground, sea, tau_px } = this, at = sea.exists ? ground!.terrain.toGeodetic(camera.position.toArray()) : null;
    sea.place(camera, at && 'lat' in at ? at : null, kTolerances * tau_px * ground!.uniforms.u_pixel_rad!.value, deep?.isReversed ?? false);
    if (sea.exists) ground!.uniforms.u_has_sea!.value = sea.object.visible ? 1 : 2;
  }

  // The camera's own axes are those of the taller scene, its eye is where the true one is.
  private setMatrices(): void {
    const { camera } = this, { elements } = camera.matrixWorld;
    camera.matrixAutoUpdate = camera.matrixWorldAutoUpdate = false;
    camera.matrixWorld.compose(camera.position, camera.quaternion, camera.scale);
    for (const i of [2, 6, 10]) elements[i]! /= this.exaggeration;
    camera.matrixWorldInverse.copy(camera.matrixWorld).invert();
  }

  // ---- what was drawn last

  // Whether an event's target is what it draws on.
  isOn(target: EventTarget | null): boolean {
    return target === this.canvas;
  }
  // In the scene's axes.
  get eye(): Vector {
    return this.camera.position.toArray();
  }
  // The unit direction, in the scene's axes, of what is seen at a point of the window.
  directionAt(x: number, y: number): Vector {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector3((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height, 0.5);
    return at.unproject(this.camera).sub(this.camera.position).normalize().toArray();
  }

  // The unit direction, in the camera's axes, of a point of the window.
  pointerAt(x: number, y: number): THREE.Vector3 {
    const { left, top, width, height } = this.canvas.getBoundingClientRect(), tall = Math.tan(kLens.fov_rad / 2);
    return new THREE.Vector3(((2 * (x - left)) / width - 1) * tall * this.camera.aspect, (1 - (2 * (y - top)) / height) * tall, -1).normalize();
  }
  // Of a globe: the ground or the sea that is drawn at a point of the window; null beside it.
  drawnAt(x: number, y: number): THREE.Vector3 | null {
    const { camera } = this, direction = this.pointerAt(x, y).applyQuaternion(camera.quaternion);
    const distances_m = [this.groundDistance(camera.position, direction), this.sea.distanceAlong(direction)].filter((distance_m) => distance_m !== null);
    return distances_m.length === 0 ? null : direction.multiplyScalar(Math.min(...distances_m)).add(camera.position);
  }
  // Of a globe: how far the ground that is drawn now is from a point in a unit direction, metres; null where it is not met.
  groundDistance(from: THREE.Vector3, direction: THREE.Vector3): number | null {
    const { deep, ground, camera } = this;
    return deep && ground && this.shownVersion > 0 ? deep.distanceAlong(ground, camera, from, direction, kTerrainVertex, ground.uniforms) : null;
  }

  // Of other scenes: what is met there of the ground that is held, and of a cut's wall; null beyond both.
  heldAt(x: number, y: number): Met | null {
    const terrain = this.ground?.terrain;
    return terrain?.hasScene ? metNow(terrain, this.cut_view.shown, wayAlong(terrain, this.eye, this.directionAt(x, y))) : null;
  }

  // What is met there: of a globe what is drawn, elsewhere what is held.
  metAt(x: number, y: number): Met | null {
    if (!this.deep) return this.heldAt(x, y);
    const point = this.drawnAt(x, y)?.toArray();
    return point ? { point, is_wall: false } : null;
  }

  // Where a point of the scene is in the window, and how deep; null behind the eye.
  pointOnScreen(point: Vector): Vector | null {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector3(...point).applyMatrix4(this.camera.matrixWorldInverse);
    const depth = -at.z;
    if (depth <= 0) return null;
    at.applyMatrix4(this.camera.projectionMatrix);
    return [left + (0.5 + 0.5 * at.x) * width, top + (0.5 - 0.5 * at.y) * height, depth];
  }

  // Metres across a pixel of the window, on a plane towards the ground in the middle of the view; null where there is none.
  pixelAtGround_m(): number | null {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const met = this.metAt(left + width / 2, top + height / 2);
    return met && ((2 * Math.tan(kLens.fov_rad / 2) * (this.pointOnScreen(met.point)?.[2] ?? 0)) / height || null);
  }

  // ---- for tests

  // How many pixels of the last frame's view differ between the end of the mesh that is drawn and the beginning of the next one, and how
  // many by more than kVisible; and how many between the beginning and the end of the one that is drawn. Null if it is not known yet.
  compareEnds(): { differing: number; visible: number; moved: number; pixels: number } | null {
    const { ground } = this;
    if (!ground?.stageAll() || !this.last_shot) return null;
    const [begin, end] = [this.pixelsAt(0), this.pixelsAt(1)];
    ground.showNext();
    const following = this.pixelsAt(0);
    ground.showNext();
    const [moved, seam] = [differencesOf(begin, end), differencesOf(end, following)];
    return { differing: seam.differing, visible: seam.visible, moved: moved.differing, pixels: end.length / 4 };
  }

  // ShadeProbe.read with what the last frame drew, at a weight.
  shadeAt(positions: readonly number[], footprint: number, weight: number): number[] | null {
    if (!this.last_shot || !this.ground) return null;
    this.pixelsAt(weight);
    return new ShadeProbe(this.renderer, { ...this.ground.uniforms, ...this.haze }).read(positions, footprint);
  }

  private pixelsAt(weight: number): Uint8Array {
    const shot = this.last_shot!;
    this.ground!.place(weight, shot.pose.eye);
    this.render(shot);
    const gl = this.renderer.getContext();
    const pixels = new Uint8Array(4 * this.canvas.width * this.canvas.height);
    gl.readPixels(0, 0, this.canvas.width, this.canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  }
}

const kSize = new THREE.Vector2();

interface ToldLens {
  fov_deg: number;
  width: number;
  height: number;
  finer: number; // how much smaller the tolerance has to be
}
// With so many pixels per unit of tangent, unless that were too many.
function toldLens({ tan_x, tan_y, finer }: AskedLens, focal_px: number): ToldLens {
  const share = Math.min(1, kLargestSide / (2 * focal_px * Math.max(tan_x, tan_y)));
  const [width, height] = [tan_x, tan_y].map((tan) => Math.floor(2 * focal_px * share * tan)) as [number, number];
  return { fov_deg: (360 * Math.atan(tan_y)) / Math.PI, width, height, finer: finer / share };
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
