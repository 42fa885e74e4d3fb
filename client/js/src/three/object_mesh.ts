// The scene's objects on the graphics card, blended between two keyframes by the terrain's weight and textured with the images
// of their models.
import * as THREE from 'three';
import { reasonOf } from '../core/failure.js';
import type { MeshUpdate } from '../core/mesh_update.js';
import type { BufferSet } from './blend_buffers.js';
import type { GroundMaterials, ObjectMaterial, Uniforms } from './materials.js';
import { castShadows, disposeMaterials } from './terrain_mesh.js';
import { WireLines } from './wire_lines.js';

const kPlain: [number, number, number, number] = [196, 178, 150, 255]; // of models without an image

export class ObjectMesh {
  readonly object = new THREE.Group();
  readonly surfaces: THREE.Mesh<THREE.BufferGeometry, THREE.Material[]>;
  private readonly wire: WireLines;
  private readonly made: ObjectMaterial[] = []; // by model
  private readonly textures: THREE.Texture[] = [];
  private has_image: readonly boolean[] = []; // by model
  private readonly missing = new Set<number>(); // models whose images did not come
  private is_disposed = false;
  triangles = 0;
  images = 0; // how many have been loaded

  // `uniforms` are the terrain's. `onMissing` is told of each image that does not come from below `models`.
  constructor(private set: BufferSet, private readonly materials: GroundMaterials, private readonly uniforms: Uniforms, private readonly models: URL,
              private readonly onMissing: (what: string) => void) {
    this.surfaces = new THREE.Mesh<THREE.BufferGeometry, THREE.Material[]>(set.geometry, []);
    this.surfaces.frustumCulled = false; // the server culls
    this.surfaces.raycast = () => {};
    castShadows(this.surfaces, materials, uniforms, 'object');
    this.wire = new WireLines(materials.lines(uniforms));
    this.object.add(this.surfaces, this.wire.object);
    this.object.visible = false;
  }

  dispose(): void {
    this.is_disposed = true;
    disposeMaterials(this.surfaces);
    disposeMaterials(this.wire.object);
    for (const texture of this.textures) texture.dispose();
  }

  // With each connection: images that did not come are asked for again.
  setScene(scene: { model_has_image: readonly boolean[] }): void {
    this.has_image = scene.model_has_image;
    const missing = [...this.missing];
    this.missing.clear();
    for (const model of missing) if (this.has_image[model]) void this.load(model);
  }

  show(options: { wireframe: boolean }): void {
    this.wire.wanted = options.wireframe;
    this.wire.show(this.set);
  }

  // Draws the mesh of an update from now on, which `set` holds.
  draw(update: MeshUpdate, set: BufferSet): void {
    this.set = set;
    this.triangles = set.triangles;
    this.object.visible = this.triangles > 0;
    this.wire.show(set);
    this.surfaces.geometry = set.geometry;
    set.geometry.clearGroups();
    for (let i = 0; i < update.object_parts.length; i += 3) {
      const [first, count, model] = [update.object_parts[i]!, update.object_parts[i + 1]!, update.object_parts[i + 2]!];
      set.geometry.addGroup(first, count, model);
      while (this.made.length <= model) this.addModel(this.made.length);
    }
    this.object.position.fromArray(update.origin);
  }

  // A plain colour until the model's image has been loaded, and for good if the model has none.
  private addModel(model: number): void {
    const plain = textureOf(new Uint8Array(kPlain), 1, 1);
    const made = this.materials.object(this.uniforms, plain);
    this.textures.push(plain);
    this.made.push(made);
    this.surfaces.material.push(made.material);
    if (this.has_image[model]) void this.load(model);
  }

  // Never rejects.
  private async load(model: number): Promise<void> {
    const url = new URL(`${model}.rgba`, this.models);
    try {
      const image = await imageAt(url);
      if (this.is_disposed) return image.dispose();
      this.textures.push(image);
      this.made[model]!.setImage(image);
      ++this.images;
    } catch (error) {
      if (this.is_disposed) return;
      this.missing.add(model);
      this.onMissing(`${url.href}: ${reasonOf(error)}`);
    }
  }
}

// Throws an Error.
async function imageAt(url: URL): Promise<THREE.Texture> {
  const reply = await fetch(url);
  if (!reply.ok) throw new Error(`HTTP ${reply.status}`);
  const bytes = new Uint8Array(await reply.arrayBuffer());
  const [width, height] = bytes.length < 8 ? [0, 0] : (new Uint32Array(bytes.buffer, 0, 2) as unknown as [number, number]);
  if (width === 0 || bytes.length !== 8 + 4 * width * height) throw new Error(`${bytes.length} bytes are no image`);
  return textureOf(bytes.subarray(8), width, height);
}

// The first row is the upper one, as in texture coordinates. Bilinear and without mipmaps, which the images' gutters suffice for.
function textureOf(texels: Uint8Array<ArrayBuffer>, width: number, height: number): THREE.Texture {
  const texture = new THREE.DataTexture(texels, width, height, THREE.RGBAFormat, THREE.UnsignedByteType);
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.needsUpdate = true;
  return texture;
}
