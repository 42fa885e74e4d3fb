// The scene's objects on the graphics card, blended between two keyframes by the terrain's weight and textured with the images
// of their models.
import * as THREE from 'three';
import { reasonOf } from '../core/failure';
import { BufferSet, shader } from './blend_buffers';
import type { MeshUpdate } from '../core/mesh_update';
import { kObjectFragment, kObjectVertex } from './shaders';
import { WireLines } from './wire_lines';

const kPlain: [number, number, number, number] = [196, 178, 150, 255]; // of models without an image

export class ObjectMesh {
  readonly object = new THREE.Group();
  readonly sets: [BufferSet, BufferSet];
  private readonly surfaces: THREE.Mesh;
  private readonly wire: WireLines;
  private set: BufferSet; // that is drawn
  private readonly materials: THREE.RawShaderMaterial[] = [];
  private readonly origin = new THREE.Vector3();
  private has_image: readonly boolean[] = []; // by model
  private readonly missing = new Map<number, { value: THREE.Texture }>(); // images that did not come, by model
  triangles = 0;
  images = 0; // how many have been loaded

  // `uniforms` are the terrain's: weight, eye, light and haze. `onMissing` is told of each image that does not come.
  constructor(
    renderer: THREE.WebGLRenderer,
    private readonly uniforms: Record<string, THREE.IUniform>,
    private readonly models: URL,
    private readonly onMissing: (what: string) => void,
  ) {
    this.sets = [new BufferSet(renderer), new BufferSet(renderer)];
    this.set = this.sets[0];
    this.surfaces = new THREE.Mesh(this.set.geometry, this.materials);
    this.surfaces.frustumCulled = false; // the server culls
    this.wire = new WireLines(uniforms);
    this.object.add(this.surfaces, this.wire.object);
    this.object.visible = false;
  }

  // With each connection: images that did not come are asked for again.
  setScene(scene: { model_has_image: readonly boolean[] }): void {
    this.has_image = scene.model_has_image;
    const missing = [...this.missing];
    this.missing.clear();
    for (const [model, image] of missing) if (this.has_image[model]) void this.load(model, image);
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
      while (this.materials.length <= model) this.materials.push(this.materialOf(this.materials.length));
    }
    this.origin.fromArray(update.origin);
  }

  placeFrom(eye: readonly number[]): void {
    this.object.position.set(this.origin.x - eye[0]!, this.origin.y - eye[1]!, this.origin.z - eye[2]!);
  }

  // A plain colour until the model's image has been loaded, and for good if the model has none.
  private materialOf(model: number): THREE.RawShaderMaterial {
    const image = { value: textureOf(new Uint8Array(kPlain), 1, 1) };
    if (this.has_image[model]) void this.load(model, image);
    return shader(kObjectVertex, kObjectFragment, { ...this.uniforms, u_image: image });
  }

  // Never rejects.
  private async load(model: number, image: { value: THREE.Texture }): Promise<void> {
    const url = new URL(`${model}.rgba`, this.models);
    try {
      image.value = await imageAt(url);
      ++this.images;
    } catch (error) {
      this.missing.set(model, image);
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
  texture.needsUpdate = true;
  return texture;
}
