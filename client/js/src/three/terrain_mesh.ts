// The keyframe mesh of the terrain, drawn from one of its two buffer sets. Between keyframes only one number changes, the weight.
import * as THREE from 'three';
import type { MeshUpdate } from '../core/mesh_update.js';
import type { Welcome } from '../core/values.js';
import type { BufferSet } from './blend_buffers.js';
import type { GroundMaterials, Uniforms } from './materials.js';
import type { Undulations } from './sea.js';
import { kGrounds, type Style } from './style.js';
import { WireLines } from './wire_lines.js';

const kPalette = ['#3b5238', '#546945', '#7d7c55', '#826b52', '#6f635a', '#98938e'];
const kRock = '#5c554f';
const kSnow = '#d9e2ec';

export class TerrainMesh {
  readonly object = new THREE.Group();
  readonly surface: THREE.Mesh;
  readonly uniforms: Uniforms;
  private readonly wire: WireLines;
  private readonly origin = new THREE.Vector3();
  private noise_period_m = 1;
  private contour_m = 100;
  private max_moved_m = 0;
  version = 0; // of the mesh that is drawn; 0: none
  triangles = 0;

  // `drape` are the uniforms of what is laid over it.
  constructor(private set: BufferSet, materials: GroundMaterials, drape: Uniforms) {
    this.uniforms = { ...terrainUniforms(), ...drape };
    this.wire = new WireLines(materials.lines(this.uniforms));
    this.surface = new THREE.Mesh(set.geometry, materials.ground(this.uniforms));
    this.surface.frustumCulled = false; // the server culls
    this.surface.raycast = () => {}; // ForelandTerrain does
    castShadows(this.surface, materials, this.uniforms, 'ground');
    this.object.add(this.surface, this.wire.object);
    this.object.visible = false;
  }

  dispose(): void {
    disposeMaterials(this.surface);
    disposeMaterials(this.wire.object);
    for (const name of ['u_tints', 'u_undulations']) (this.uniforms[name]!.value as THREE.Texture).dispose();
  }

  // Colours follow the scene's size and relief. `north`: the earth's axis, or north on the map.
  setScene(welcome: Welcome, north: readonly [number, number, number]): void {
    const across_m = Math.hypot(welcome.high[0] - welcome.low[0], welcome.high[1] - welcome.low[1]);
    const is_globe = welcome.frame === 'globe', has_sea = is_globe && welcome.geoid !== '' && welcome.lowest_m < 0;
    const lowest_m = has_sea ? 0 : welcome.lowest_m;
    const relief_m = Math.max(welcome.highest_m - lowest_m, is_globe ? 0 : 1e-3 * across_m, 1e-3);
    const spacing_m = across_m / Math.hypot(...welcome.samples);
    this.uniforms.u_heights!.value.set(lowest_m, lowest_m + relief_m);
    this.uniforms.u_has_sea!.value = has_sea ? 1 : 0;
    this.uniforms.u_round!.value = is_globe ? ((welcome.high[0] - welcome.highest_m) / (welcome.high[2] - welcome.highest_m)) ** 2 : 1;
    this.uniforms.u_noise_m!.value = 16 * spacing_m;
    this.noise_period_m = 16 * spacing_m * 1024;
    this.uniforms.u_far!.value = 0.35 * across_m;
    this.contour_m = niceStep(relief_m / 60);
    this.max_moved_m = welcome.max_moved_m;
    this.uniforms.u_north!.value.set(...north);
    const material = this.surface.material as THREE.Material, { GLOBE, ...others } = material.defines ?? {};
    if (is_globe === (GLOBE !== undefined)) return;
    material.defines = is_globe ? { ...others, GLOBE: '' } : others;
    material.needsUpdate = true;
  }

  // Of a globe: where its sea lies.
  setUndulations({ first, step, columns, rows, metres }: Undulations): void {
    const u = this.uniforms, radians = Math.PI / 180;
    (u.u_undulations!.value as THREE.Texture).dispose();
    u.u_undulations!.value = Object.assign(new THREE.DataTexture(metres, columns, rows, THREE.RedFormat, THREE.FloatType), { needsUpdate: true });
    u.u_undulation_place!.value.set(first[0] * radians, first[1] * radians, 1 / (step[0] * radians), 1 / (step[1] * radians));
  }

  show(style: Style): void {
    const u = this.uniforms;
    const tells_change = style.ground !== 'change' || this.max_moved_m > 0;
    u.u_ground!.value = kGrounds.indexOf(tells_change ? style.ground : 'natural');
    u.u_change_m!.value = Math.max(style.change * this.max_moved_m, 1e-3);
    u.u_snow_line!.value = style.snowLine;
    u.u_contour_m!.value = style.contours ? this.contour_m : 0;
    u.u_sun!.value.set(...style.sun).normalize();
    this.wire.wanted = style.wireframe;
    this.wire.show(this.set);
    if (style.tints) this.setTints(style.tints);
  }

  // Colours over a range of heights: RGBA, sRGB.
  private setTints({ low, high, texels }: NonNullable<Style['tints']>): void {
    const u = this.uniforms;
    if (u.u_tints!.value.image.data === texels) return;
    (u.u_tints!.value as THREE.Texture).dispose();
    const texture = new THREE.DataTexture(texels, texels.length / 4, 1);
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
    this.object.position.copy(this.origin);
    this.version = update.version;
    this.triangles = set.triangles;
    this.object.visible = set.triangles > 0;
  }

  setLens(fov_rad: number, height_px: number): void {
    this.uniforms.u_pixel_rad!.value = (2 * Math.tan(0.5 * fov_rad)) / height_px;
  }

  // The weight and the eye of the frame to be drawn.
  place(weight: number, eye: readonly number[], up: readonly number[]): void {
    const u = this.uniforms;
    u.u_weight!.value = weight;
    u.u_up!.value.fromArray(up);
    u.u_origin!.value.set(this.origin.x - eye[0]!, this.origin.y - eye[1]!, this.origin.z - eye[2]!);
    const wrap = (v: number) => v - this.noise_period_m * Math.floor(v / this.noise_period_m);
    u.u_origin_tile!.value.set(wrap(this.origin.x), wrap(this.origin.y), wrap(this.origin.z));
    u.u_from_middle!.value.copy(this.origin);
  }
}

export function castShadows(mesh: THREE.Mesh, materials: GroundMaterials, uniforms: Uniforms, part: 'ground' | 'object'): void {
  const made = materials.depth?.(uniforms, part);
  mesh.receiveShadow = true;
  mesh.castShadow = made !== undefined;
  if (made) Object.assign(mesh, { customDepthMaterial: made.depth, customDistanceMaterial: made.distance });
}

// With the textures that the materials own: images of models.
export function disposeMaterials(object: THREE.Mesh | THREE.LineSegments): void {
  for (const material of [object.material, (object as THREE.Mesh).customDepthMaterial, (object as THREE.Mesh).customDistanceMaterial].flat()) material?.dispose();
}

function terrainUniforms(): Uniforms {
  return {
    u_weight: { value: 0 },
    u_origin: { value: new THREE.Vector3() },
    u_origin_tile: { value: new THREE.Vector3() },
    u_from_middle: { value: new THREE.Vector3() },
    u_round: { value: 1 },
    u_has_sea: { value: 0 },
    u_undulations: { value: new THREE.DataTexture(new Float32Array(1), 1, 1, THREE.RedFormat, THREE.FloatType) },
    u_undulation_place: { value: new THREE.Vector4() },
    u_sun: { value: new THREE.Vector3(0, 0, 1) },
    u_up: { value: new THREE.Vector3(0, 0, 1) },
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
    u_far: { value: 1 },
    u_pixel_rad: { value: 1e-3 },
  };
}

// 1, 2 or 5 times a power of ten, at least `value`.
function niceStep(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([1, 2, 5, 10].find((n) => n * power >= value) ?? 10);
}
