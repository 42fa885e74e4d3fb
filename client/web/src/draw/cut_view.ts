// A cut through the ground: what it takes away is not drawn, and a wall of strata stands along it.
import type { Vector } from '@foreland/client';
import * as THREE from 'three';
import { kMostCorners, type At } from '../cut/ring';
import type { Wall } from '../cut/wall';
import { kCutWallFragment, kCutWallVertex, shader } from './shaders';

export interface Cut {
  ring: readonly At[]; // at most kMostCorners
  corners: readonly Vector[]; // the same in the scene's axes
  is_hole: boolean; // what is inside is taken away, and not what is outside
  wall: Wall;
}

const kStrata = 12; // about so many are seen

export class CutView {
  readonly object = new THREE.Mesh<THREE.BufferGeometry, THREE.Material>(new THREE.BufferGeometry());
  readonly uniforms = {
    u_cut: { value: Array.from({ length: kMostCorners }, () => new THREE.Vector2()) }, // the ring, from the pivot
    u_cut_scene: { value: Array.from({ length: kMostCorners }, () => new THREE.Vector2()) }, // from the eye, along the scene's axes
    u_cut_corners: { value: 0 },
    u_cut_hole: { value: false },
  };
  private readonly wall_uniforms = { u_wall: { value: new THREE.Vector3() }, u_stratum_m: { value: 1 } };
  private readonly adopted = new Set<THREE.RawShaderMaterial>();
  private cut: Cut | null = null;

  constructor() {
    this.object.visible = false;
    this.object.frustumCulled = false;
  }

  // A material that leaves out what is cut away. Where nothing is, its shader has nothing of that: cards draw faster what is never discarded.
  adopt(material: THREE.RawShaderMaterial): THREE.RawShaderMaterial {
    this.adopted.add(material);
    material.addEventListener('dispose', () => this.adopted.delete(material));
    this.define(material);
    return material;
  }

  // The ground's uniforms, and those of the light.
  begin(uniforms: Record<string, THREE.IUniform>): void {
    this.object.material = Object.assign(shader(kCutWallVertex, kCutWallFragment, { ...uniforms, ...this.wall_uniforms }), { side: THREE.DoubleSide });
  }

  // Null: none.
  show(cut: Cut | null): void {
    const was_on = this.cut !== null;
    this.cut = cut;
    this.object.visible = cut !== null && cut.wall.columns > 1;
    this.uniforms.u_cut_corners.value = cut?.ring.length ?? 0;
    this.uniforms.u_cut_hole.value = cut?.is_hole ?? false;
    if (was_on !== (cut !== null)) for (const material of this.adopted) this.define(material);
    this.object.geometry.dispose();
    this.object.geometry = new THREE.BufferGeometry();
    if (!cut) return;
    const { wall } = cut;
    this.object.geometry.setAttribute('position', new THREE.BufferAttribute(wall.positions, 3)).setAttribute('height', new THREE.BufferAttribute(wall.heights, 2)).setIndex(new THREE.BufferAttribute(wall.indices, 1));
    this.object.position.fromArray(wall.origin);
    this.wall_uniforms.u_stratum_m.value = roundStep(wall.span_m / kStrata);
  }

  get shown(): Cut | null {
    return this.cut;
  }

  // The frame's pivot on the lattice, and its eye.
  place(pivot: THREE.Vector2, eye: THREE.Vector3): void {
    if (!this.cut) return;
    this.cut.ring.forEach(([x, y], i) => this.uniforms.u_cut.value[i]!.set(x - pivot.x, y - pivot.y));
    this.cut.corners.forEach(([x, y], i) => this.uniforms.u_cut_scene.value[i]!.set(x - eye.x, y - eye.y));
    this.wall_uniforms.u_wall.value.copy(this.object.position).sub(eye);
  }

  dispose(): void {
    this.show(null);
    this.object.material.dispose();
  }

  private define(material: THREE.RawShaderMaterial): void {
    material.defines = this.cut ? { CUT: '' } : {};
    material.needsUpdate = true;
  }
}

// 1, 2 or 5 times a power of ten.
export function roundStep(wanted: number): number {
  const ten = 10 ** Math.floor(Math.log10(Math.max(wanted, 1e-6)));
  return ten * [1, 2, 5, 10].find((step) => step * ten >= wanted * (1 - 1e-9))!;
}
