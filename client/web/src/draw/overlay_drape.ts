// What is laid over the ground of files (overlay/): lines and areas as textures of the ground's shader.
import * as THREE from 'three';
import type { GroundGrid } from '../overlay/ground_grid';

const kRow = 2048; // texels of a texture's row: kOverlayRow of overlay.glsl
const kMaxLevels = 16;

export class OverlayDrape {
  readonly uniforms = {
    u_overlay_cells: { value: integersOf(new Uint32Array(2), 2) },
    u_overlay_items: { value: integersOf(new Uint32Array(1), 1) },
    u_overlay_segments: { value: floatsOf(new Float32Array(4)) },
    u_overlay_styles: { value: floatsOf(new Float32Array(4)) },
    u_overlay_place: { value: new THREE.Vector4(0, 0, 1, 0) },
    u_overlay_levels: { value: new Int32Array(3 * kMaxLevels).fill(1) },
    u_overlay_width_px: { value: 1 },
  };
  private grid: GroundGrid | null = null;

  // Null: none.
  show(grid: GroundGrid | null): void {
    const { uniforms: u } = this;
    for (const uniform of [u.u_overlay_cells, u.u_overlay_items, u.u_overlay_segments, u.u_overlay_styles]) uniform.value.dispose();
    this.grid = grid;
    u.u_overlay_place.value.w = grid?.levels.length ?? 0;
    u.u_overlay_cells.value = integersOf(grid?.cells ?? new Uint32Array(2), 2);
    u.u_overlay_items.value = integersOf(grid?.items ?? new Uint32Array(1), 1);
    u.u_overlay_segments.value = floatsOf(grid?.segments ?? new Float32Array(4));
    u.u_overlay_styles.value = floatsOf(grid?.styles ?? new Float32Array(4));
    if (!grid) return;
    grid.levels.forEach(({ columns, rows, begin }, i) => u.u_overlay_levels.value.set([columns, rows, begin], 3 * i));
    let widest_px = 0;
    for (let shape = 0; shape < grid.features.length; ++shape) widest_px = Math.max(widest_px, grid.styles[12 * shape + 8]!);
    u.u_overlay_width_px.value = 0.5 * widest_px + 1;
  }

  // The frame's pivot on the lattice, from which the shader counts positions.
  place(pivot: THREE.Vector2): void {
    if (!this.grid) return;
    const { origin, cell, levels } = this.grid;
    this.uniforms.u_overlay_place.value.set(origin[0] - pivot.x, origin[1] - pivot.y, cell, levels.length);
  }

  dispose(): void {
    this.show(null);
  }
}

function filled<T extends Uint32Array<ArrayBuffer> | Float32Array<ArrayBuffer>>(numbers: T, per_texel: number): { data: T; rows: number } {
  const rows = Math.max(1, Math.ceil(numbers.length / per_texel / kRow));
  const data = new (numbers.constructor as new (length: number) => T)(rows * kRow * per_texel);
  data.set(numbers);
  return { data, rows };
}

function integersOf(numbers: Uint32Array<ArrayBuffer>, per_texel: 1 | 2): THREE.DataTexture {
  const { data, rows } = filled(numbers, per_texel);
  const texture = new THREE.DataTexture(data, kRow, rows, per_texel === 1 ? THREE.RedIntegerFormat : THREE.RGIntegerFormat, THREE.UnsignedIntType);
  return Object.assign(texture, { internalFormat: per_texel === 1 ? 'R32UI' : 'RG32UI', needsUpdate: true });
}

function floatsOf(numbers: Float32Array<ArrayBuffer>): THREE.DataTexture {
  const { data, rows } = filled(numbers, 4);
  return Object.assign(new THREE.DataTexture(data, kRow, rows, THREE.RGBAFormat, THREE.FloatType), { needsUpdate: true });
}
