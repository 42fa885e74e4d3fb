// What is laid over the terrain: relief, which it is shaded and coloured by, and imagery. Their textures, and the uniforms by which the terrain's
// shader finds the texels of a lattice position.
import * as THREE from 'three';
import { kContents, kFrameKinds, type Content, type Layer, type SlopeFrame, type TextureLayers } from '../core/values.js';
import type { MeshUpdate } from '../core/mesh_update.js';
import { kFaces, nearestOnFaces } from './cube.js';
import { TileTextures } from './tile_textures.js';

export class Drape {
  readonly uniforms: Record<string, THREE.IUniform>;
  private readonly textures: Record<Content, TileTextures>;
  private layers: Record<Content, Layer | null> = { relief: null, imagery: null };
  private frame: SlopeFrame | null = null;
  private wanted: Record<Content, boolean> = { relief: true, imagery: true };

  // `anisotropy`: reads along the longer axis of what a pixel sees; 1 where a processor draws.
  constructor(renderer: THREE.WebGLRenderer, gl: WebGL2RenderingContext, sizes: TextureLayers, anisotropy: number) {
    this.textures = {
      relief: new TileTextures(renderer, gl, 'relief', sizes.relief, 1),
      imagery: new TileTextures(renderer, gl, 'imagery', sizes.imagery, anisotropy),
    };
    this.uniforms = { u_pivot: { value: new THREE.Vector2() }, u_anisotropy: { value: anisotropy }, ...slopeUniforms() };
    for (const content of kContents) Object.assign(this.uniforms, tileUniforms(content, this.textures[content]));
    Object.assign(this.uniforms, groundUniforms(this.textures.relief));
  }

  dispose(): void {
    for (const content of kContents) this.textures[content].dispose();
  }
  reset(): void {
    for (const content of kContents) this.textures[content].reset();
  }

  setScene(layers: Record<Content, Layer | null>, frame: SlopeFrame | null): void {
    [this.layers, this.frame] = [layers, frame];
    const u = this.uniforms;
    if (!frame) return;
    u.u_gradient!.value.set(...frame.gradient_x, ...frame.gradient_y);
    u.u_geodetic_step!.value.set(frame.longitude_step, frame.latitude_step);
    u.u_origin_latitude!.value = frame.origin_latitude;
    u.u_ellipsoid!.value.set(frame.semi_major_m, frame.eccentricity_squared);
    const { relief } = layers, kind = kFrameKinds[frame.frame_kind];
    u.u_is_geographic!.value = kind === 'geographic';
    if (!relief) return;
    u.u_relief_code!.value.set(relief.low_m, relief.code_m);
    if (kind === 'globe') {
      u.u_relief_texel_m!.value = (0.5 * Math.PI * frame.semi_major_m) / relief.size[0];
      return;
    }
    const sample_m = kind === 'geographic' ? frame.semi_major_m * frame.latitude_step : 1 / Math.hypot(...frame.gradient_y);
    u.u_relief_texel_m!.value = relief.texel * sample_m;
  }

  show(wanted: Record<Content, boolean> & { shadows: boolean }): void {
    this.wanted = wanted;
    this.uniforms.u_shadows!.value = wanted.shadows ? 1 : 0;
  }

  add(update: MeshUpdate): void {
    for (const content of kContents) {
      const tiles = update.tiles[content];
      if (tiles) this.textures[content].add(update.version, tiles);
    }
  }
  // Uploads what the mesh of `version` needs, up to a number of bytes; gives how many.
  upload(version: number, budget: number): number {
    const spent = this.textures.relief.upload(version, budget);
    return spent + this.textures.imagery.upload(version, budget - spent);
  }
  isReady(version: number): boolean {
    return kContents.every((content) => this.textures[content].isReady(version));
  }
  costTo(version: number): number {
    return kContents.reduce((sum, content) => sum + this.textures[content].costTo(version), 0);
  }
  // Draws what belongs to the mesh of `version` from now on; gives how many bytes had to be uploaded for that.
  draw(version: number): number {
    return kContents.reduce((sum, content) => sum + this.textures[content].show(version), 0);
  }

  tilesShown(content: Content): number {
    return this.textures[content].shown;
  }
  // What is to be said of the layers that are drawn.
  attributions(): string[] {
    return kContents.filter((c) => this.wanted[c] && this.textures[c].shown > 0).map((c) => this.layers[c]?.attribution ?? '').filter((text) => text !== '');
  }

  private placeOnFaces(lattice: readonly [number, number], steps: number): [number, number][] {
    const places = nearestOnFaces(lattice, steps);
    this.uniforms.u_face_steps!.value = steps;
    places.forEach((at, face) => this.uniforms.u_pivots!.value[face].set(...at));
    return places;
  }

  // Positions count from a sample near the eye, so that floats are exact enough far from the lattice's origin.
  place(lattice: readonly [number, number], samples: readonly [number, number]): void {
    const pivot = lattice.map((v, i) => Math.round(Math.min(Math.max(v, 0), samples[i]! - 1))) as [number, number];
    const u = this.uniforms;
    u.u_pivot!.value.set(...pivot);
    if (this.frame) {
      const { latitude, longitude, latitude_step, longitude_step } = this.frame;
      u.u_geodetic!.value.set(longitude + pivot[0] * longitude_step, latitude + pivot[1] * latitude_step);
    }
    const is_globe = this.frame !== null && kFrameKinds[this.frame.frame_kind] === 'globe';
    const on_faces = is_globe ? this.placeOnFaces(lattice, samples[1] - 1) : null;
    for (const content of kContents) {
      const layer = this.layers[content];
      u[`u_${content}_levels`]!.value = layer && this.wanted[content] && this.textures[content].shown > 0 ? layer.levels : 0;
      if (!layer) continue;
      on_faces?.forEach((at, face) => {
        const [x, y] = at.map((v) => v / layer.texel) as [number, number];
        u[`u_${content}_pivots`]!.value[face].set(Math.floor(x), Math.floor(y), x - Math.floor(x), y - Math.floor(y));
      });
      const texels = pivot.map((v, i) => (v - layer.origin[i]!) / layer.texel) as [number, number];
      const whole = texels.map(Math.floor) as [number, number];
      u[`u_${content}_pivot`]!.value.set(...whole);
      u[`u_${content}_rest`]!.value.set(texels[0] - whole[0], texels[1] - whole[1]);
      u[`u_${content}_density`]!.value = 1 / layer.texel;
      u[`u_${content}_size`]!.value.set(...layer.size);
    }
  }
}

function fill<T>(make: () => T): T[] {
  return Array.from({ length: kFaces }, make);
}

function slopeUniforms(): Record<string, THREE.IUniform> {
  return {
    u_gradient: { value: new THREE.Vector4() },
    u_is_geographic: { value: false },
    u_geodetic: { value: new THREE.Vector2() },
    u_geodetic_step: { value: new THREE.Vector2() },
    u_origin_latitude: { value: 0 },
    u_face_steps: { value: 1 },
    u_pivots: { value: fill(() => new THREE.Vector2()) },
    u_ellipsoid: { value: new THREE.Vector2() },
  };
}

function groundUniforms(relief: TileTextures): Record<string, THREE.IUniform> {
  return { u_relief_ground: relief.uniforms.grounds!, u_relief_code: { value: new THREE.Vector2(0, 1) }, u_relief_texel_m: { value: 1 }, u_shadows: { value: 0 } };
}

function tileUniforms(content: Content, textures: TileTextures): Record<string, THREE.IUniform> {
  return {
    [`u_${content}`]: textures.uniforms.images,
    [`u_${content}_pages`]: textures.uniforms.pages,
    [`u_${content}_pivot`]: { value: new THREE.Vector2() },
    [`u_${content}_rest`]: { value: new THREE.Vector2() },
    [`u_${content}_pivots`]: { value: fill(() => new THREE.Vector4()) },
    [`u_${content}_density`]: { value: 1 },
    [`u_${content}_size`]: { value: new THREE.Vector2() },
    [`u_${content}_levels`]: { value: 0 },
  };
}

// How many reads along the longer axis of what a pixel sees are cheap: many for a graphics card, none where a processor draws.
export function cheapAnisotropy(renderer: THREE.WebGLRenderer): number {
  const gl = renderer.getContext();
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name) ? 1 : Math.min(8, renderer.capabilities.getMaxAnisotropy());
}
