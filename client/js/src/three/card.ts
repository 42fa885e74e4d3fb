// What a terrain has on the graphics card: meshes, tiles on them, and their materials. Made anew when the card was reset.
import * as THREE from 'three';
import type { MeshUpdate, PartLines } from '../core/mesh_update.js';
import type { TextureLayers } from '../core/values.js';
import { BufferSet } from './blend_buffers.js';
import { cheapAnisotropy, Drape } from './drape.js';
import { withOwnState } from './gl_state.js';
import type { GroundMaterials } from './materials.js';
import { ObjectMesh } from './object_mesh.js';
import { Stage, type MeshSet } from './stage.js';
import { TerrainMesh } from './terrain_mesh.js';

// Of the next mesh, in a frame, in bytes; a call counts as some (blend_buffers.ts).
const kMinSlice = 128 << 10;

export interface CardOptions {
  layers: TextureLayers;
  anisotropy: number | null; // null: what the card does cheaply
  models: URL;
  materials: GroundMaterials;
  onMissing: (what: string) => void;
}

export class Card {
  readonly terrain: TerrainMesh;
  readonly objects: ObjectMesh;
  readonly drape: Drape;
  private readonly gl: WebGL2RenderingContext;
  private readonly sets: [MeshSet, MeshSet];
  private stage: Stage;
  uploaded = 0; // bytes, in the last frame
  upload_limit = 0; // of that frame

  constructor(renderer: THREE.WebGLRenderer, { layers, anisotropy, models, materials, onMissing }: CardOptions) {
    const gl = (this.gl = renderer.getContext() as WebGL2RenderingContext);
    [this.drape, this.sets] = withOwnState(gl, () => {
      const setOf = (): MeshSet => ({ terrain: new BufferSet(gl), objects: new BufferSet(gl) });
      return [new Drape(renderer, gl, layers, anisotropy ?? cheapAnisotropy(renderer)), [setOf(), setOf()]];
    });
    this.stage = new Stage(...this.sets);
    this.terrain = new TerrainMesh(this.sets[0].terrain, materials, this.drape.uniforms);
    this.objects = new ObjectMesh(this.sets[0].objects, materials, this.terrain.uniforms, models, onMissing);
  }

  // After the card was reset, what it held is gone by itself.
  dispose(): void {
    this.terrain.dispose();
    this.objects.dispose();
    this.drape.dispose();
    for (const set of this.sets) {
      set.terrain.dispose();
      set.objects.dispose();
    }
  }

  // ---- meshes

  add(update: MeshUpdate): void {
    this.stage.add(update);
    this.drape.add(update);
  }
  addLines(version: number, terrain: PartLines, objects: PartLines): void {
    withOwnState(this.gl, () => this.stage.addLines(version, terrain, objects));
  }
  reset(): void {
    this.stage = new Stage(...this.sets);
    this.drape.reset();
    this.terrain.object.visible = this.objects.object.visible = false;
  }

  get shownVersion(): number {
    return this.stage.shownVersion;
  }
  get stagedVersion(): number {
    return this.stage.stagedVersion;
  }
  get isNextReady(): boolean {
    return this.stage.isNextReady;
  }
  // The newest mesh that can be shown, and the one that is being made ready.
  versions(): { ready: number; coming: number } {
    const { stage } = this;
    return this.drape.isReady(stage.readyVersion)
      ? { ready: stage.readyVersion, coming: stage.comingVersion }
      : { ready: stage.shownVersion, coming: stage.readyVersion };
  }

  // Of the mesh that comes next, which `wanted` says and which is shown in `left_ms`, so much that it is there in time, but at most
  // `limit` bytes. Of the first one, and of one after a jump, all: until it is there what is drawn is worth nothing.
  upload(wanted: number, left_ms: number, frame_ms: number, limit: number): void {
    const next = Math.max(wanted, this.stage.shownVersion);
    this.upload_limit = Math.max(limit, limit * (frame_ms / 16));
    this.uploaded = 0;
    if (this.stage.shownVersion === 0 || this.stage.isElsewhere(next)) return this.uploadAll(next);
    const cost = this.stage.costTo(next) + this.drape.costTo(next);
    if (cost === 0 && !this.stage.hasWork(next)) return;
    const frames = Math.max(1, Math.floor(left_ms / Math.max(frame_ms, 4)) - 1);
    const budget = Math.min(Math.max(kMinSlice, cost / frames), this.upload_limit);
    withOwnState(this.gl, () => {
      this.uploaded = this.drape.upload(next, budget);
      this.uploaded += this.stage.upload(next, budget - this.uploaded);
    });
  }
  uploadAll(next: number): void {
    withOwnState(this.gl, () => {
      this.drape.upload(next, Infinity);
      this.stage.upload(next, Infinity);
    });
  }

  // Draws the next mesh from now on, which is ready.
  showNext(): MeshUpdate {
    const { update, set } = this.stage.swap();
    this.terrain.draw(update, set.terrain);
    withOwnState(this.gl, () => (this.uploaded += this.drape.draw(update.version)));
    this.objects.draw(update, set.objects);
    return update;
  }
}
