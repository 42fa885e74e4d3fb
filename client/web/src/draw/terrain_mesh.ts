// The keyframe mesh of the terrain, drawn from one of its two buffer sets. Between keyframes only one number changes, the weight.
import * as THREE from 'three';
import { BufferSet, shader } from './blend_buffers';
import type { Welcome } from '../core/values';
import type { MeshUpdate } from '../core/mesh_update';
import { kGrounds, kTerrainFragment, kTerrainVertex, type Ground } from './shaders';
import { WireLines } from './wire_lines';

const kPalette = ['#3b5238', '#546945', '#7d7c55', '#826b52', '#6f635a', '#98938e'];
const kRock = '#5c554f';
const kSnow = '#d9e2ec';

export class TerrainMesh {
  readonly object = new THREE.Group();
  readonly sets: [BufferSet, BufferSet];
  private readonly surface: THREE.Mesh;
  private readonly wire: WireLines;
  private set: BufferSet; // that is drawn
  readonly uniforms: Record<string, THREE.IUniform>;
  private origin = new THREE.Vector3();
  private noise_period_m = 1;
  private haze = 0;
  private contour_m = 100;
  private max_moved_m = 0;
  version = 0; // of the mesh that is drawn; 0: none
  triangles = 0;

  // `drape` are the uniforms of what is laid over it.
  constructor(renderer: THREE.WebGLRenderer, sun: THREE.Vector3, up: THREE.Vector3, drape: Record<string, THREE.IUniform>) {
    this.sets = [new BufferSet(renderer), new BufferSet(renderer)];
    this.set = this.sets[0];
    this.uniforms = { ...terrainUniforms(sun, up), ...drape };
    this.wire = new WireLines(this.uniforms);
    this.surface = new THREE.Mesh(this.set.geometry, shader(kTerrainVertex, kTerrainFragment, this.uniforms));
    this.surface.frustumCulled = false; // the server culls
    this.object.add(this.surface, this.wire.object);
    this.object.visible = false;
  }

  // Colours and haze follow the scene's size and relief.
  setScene(welcome: Welcome): void {
    const across_m = Math.hypot(welcome.high[0] - welcome.low[0], welcome.high[1] - welcome.low[1]);
    const relief_m = Math.max(welcome.highest_m - welcome.lowest_m, 1e-3 * across_m, 1e-3);
    const spacing_m = across_m / Math.hypot(...welcome.samples);
    this.uniforms.u_heights!.value.set(welcome.lowest_m, welcome.lowest_m + relief_m);
    this.uniforms.u_noise_m!.value = 16 * spacing_m;
    this.noise_period_m = 16 * spacing_m * 1024;
    this.uniforms.u_haze_height!.value = 0.9 * relief_m;
    this.uniforms.u_far!.value = 0.35 * across_m;
    this.haze = 1.8 / across_m;
    this.contour_m = niceStep(relief_m / 60);
    this.max_moved_m = welcome.max_moved_m;
  }

  // `north`: the earth's axis, or north on the map.
  setNorth(north: readonly [number, number, number]): void {
    this.uniforms.u_north!.value.set(...north);
  }

  show(options: { wireframe: boolean; contours: boolean; fog: boolean; ground: Ground; snow_line: number; change: number }): void {
    const tells_change = options.ground !== 'change' || this.max_moved_m > 0;
    this.uniforms.u_ground!.value = kGrounds.indexOf(tells_change ? options.ground : 'natural');
    this.uniforms.u_change_m!.value = Math.max(options.change * this.max_moved_m, 1e-3);
    this.uniforms.u_snow_line!.value = options.snow_line;
    this.wire.wanted = options.wireframe;
    this.wire.show(this.set);
    this.uniforms.u_contour_m!.value = options.contours ? this.contour_m : 0;
    this.uniforms.u_haze!.value = options.fog ? this.haze : 0;
  }

  // Colours over a range of heights: RGBA, sRGB.
  setTints({ low, high, texels }: { low: number; high: number; texels: Uint8Array }): void {
    const u = this.uniforms;
    (u.u_tints!.value as THREE.Texture).dispose();
    const texture = new THREE.DataTexture(texels as Uint8Array<ArrayBuffer>, texels.length / 4, 1);
    Object.assign(texture, { colorSpace: THREE.SRGBColorSpace, magFilter: THREE.LinearFilter, minFilter: THREE.LinearFilter, needsUpdate: true });
    u.u_tints!.value = texture;
    u.u_tint_range!.value.set(low, high);
  }

  // Draws the mesh of an update from now on, which `set` holds.
  draw(update: MeshUpdate, set: BufferSet): void {
    this.set = set;
    this.surface.geometry = set.geometry;
    this.wire.show(set);
    this.origin.fromArray(update.origin);
    this.version = update.version;
    this.triangles = set.triangles;
    this.object.visible = set.triangles > 0;
  }

  setLens(fov_rad: number, height_px: number): void {
    this.uniforms.u_pixel_rad!.value = (2 * Math.tan(0.5 * fov_rad)) / height_px;
  }

  // The weight and the eye of the frame to be drawn.
  place(weight: number, eye: readonly number[], eye_height_m: number): void {
    const u = this.uniforms;
    u.u_weight!.value = weight;
    u.u_eye_height!.value = eye_height_m;
    const from_eye = u.u_origin!.value as THREE.Vector3;
    from_eye.set(this.origin.x - eye[0]!, this.origin.y - eye[1]!, this.origin.z - eye[2]!);
    this.object.position.copy(from_eye);
    const wrap = (v: number) => v - this.noise_period_m * Math.floor(v / this.noise_period_m);
    u.u_origin_tile!.value.set(wrap(this.origin.x), wrap(this.origin.y));
  }
}

function terrainUniforms(sun: THREE.Vector3, up: THREE.Vector3): Record<string, THREE.IUniform> {
  return {
    u_weight: { value: 0 },
    u_origin: { value: new THREE.Vector3() },
    u_origin_tile: { value: new THREE.Vector2() },
    u_sun: { value: sun },
    u_up: { value: up },
    u_palette: { value: kPalette.map((c) => new THREE.Color(c)) },
    u_rock: { value: new THREE.Color(kRock) },
    u_snow: { value: new THREE.Color(kSnow) },
    u_heights: { value: new THREE.Vector2(0, 1) },
    u_noise_m: { value: 1 },
    u_contour_m: { value: 0 },
    u_snow_line: { value: 0.75 },
    u_ground: { value: 0 },
    u_tints: { value: new THREE.DataTexture(new Uint8Array(4), 1, 1) },
    u_tint_range: { value: new THREE.Vector2(0, 1) },
    u_change_m: { value: 1 },
    u_north: { value: new THREE.Vector3(0, 1, 0) },
    u_haze: { value: 0 },
    u_haze_height: { value: 1 },
    u_eye_height: { value: 0 },
    u_far: { value: 1 },
    u_pixel_rad: { value: 1e-3 },
  };
}

// 1, 2 or 5 times a power of ten, at least `value`.
function niceStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([1, 2, 5, 10].find((n) => n * power >= value) ?? 10);
}
