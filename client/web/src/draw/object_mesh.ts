// The scene's objects on the graphics card, blended between two keyframes by the terrain's weight and textured with the images
// of their models.
import * as THREE from 'three';
import { bindBlend, blendChannels, channel, fill, fillBlend, patch, patchBlend, shader, type BlendChannels, type Channel } from './blend_buffers';
import type { Changes, Mesh } from '../core/core';
import { kObjectFragment, kObjectVertex } from './shaders';
import { WireLines } from './wire_lines';

const kPlain: [number, number, number, number] = [196, 178, 150, 255]; // of models without an image

export class ObjectMesh {
  readonly object = new THREE.Group();
  private readonly wire: WireLines;
  private readonly geometry = new THREE.BufferGeometry();
  private readonly channels: BlendChannels;
  private readonly texture_coordinate: Channel;
  private readonly index: Channel;
  private readonly materials: THREE.RawShaderMaterial[] = [];
  private readonly origin = new THREE.Vector3();
  private has_image: readonly boolean[] = []; // by model
  private version = 0; // of the mesh on the card; 0: none
  triangles = 0;
  images = 0; // how many have been loaded

  // `uniforms` are the terrain's: weight, eye, light and haze.
  constructor(
    private readonly renderer: THREE.WebGLRenderer,
    private readonly uniforms: Record<string, THREE.IUniform>,
    private readonly models: URL,
  ) {
    const gl = renderer.getContext() as WebGL2RenderingContext;
    this.channels = blendChannels(gl);
    this.texture_coordinate = channel(gl, gl.FLOAT, 2, 4);
    this.index = channel(gl, gl.UNSIGNED_INT, 1, 4);
    bindBlend(this.geometry, this.channels, this.index);
    this.geometry.setAttribute('texture_coordinate', this.texture_coordinate.attribute as unknown as THREE.BufferAttribute);
    const surfaces = new THREE.Mesh(this.geometry, this.materials);
    surfaces.frustumCulled = false; // the server culls
    this.wire = new WireLines(renderer, this.channels, uniforms);
    this.object.add(surfaces, this.wire.object);
    this.object.visible = false;
  }

  setScene(scene: { model_has_image: readonly boolean[] }): void {
    this.has_image = scene.model_has_image;
  }

  show(options: { wireframe: boolean }): void {
    this.wire.object.visible = options.wireframe;
  }

  // `changes` are those that the viewer tells of this mesh.
  upload(mesh: Mesh, changes: Changes): void {
    const { objects } = mesh;
    this.triangles = objects.indices.length / 3;
    this.object.visible = this.triangles > 0;
    if (!this.object.visible) return;
    const gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.renderer.resetState(); // index buffers must not be bound into one of the renderer's vertex arrays
    if (this.version !== 0 && changes.base_version === this.version) {
      patchBlend(gl, this.channels, this.index, objects, changes);
      const { texture_coordinates: ranges } = changes;
      patch(gl, gl.ARRAY_BUFFER, this.texture_coordinate, objects.texture_coordinates, 2, ranges, objects.vertices);
    } else {
      fillBlend(gl, this.channels, this.index, objects);
      fill(gl, gl.ARRAY_BUFFER, this.texture_coordinate, objects.texture_coordinates, objects.vertices);
    }
    this.version = mesh.version;
    this.geometry.clearGroups();
    for (let i = 0; i < objects.parts.length; i += 3) {
      const [first, count, model] = [objects.parts[i]!, objects.parts[i + 1]!, objects.parts[i + 2]!];
      this.geometry.addGroup(first, count, model);
      while (this.materials.length <= model) this.materials.push(this.materialOf(this.materials.length));
    }
    this.origin.fromArray(mesh.origin);
    if (this.wire.object.visible) this.wire.upload(objects.indices, true);
  }

  // A new session counts its meshes anew.
  forget(): void {
    this.version = 0;
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

  private async load(model: number, image: { value: THREE.Texture }): Promise<void> {
    const reply = await fetch(new URL(`${model}.rgba`, this.models)).catch(() => null);
    if (!reply?.ok) return;
    const bytes = new Uint8Array(await reply.arrayBuffer());
    if (bytes.length < 8) return;
    const [width, height] = new Uint32Array(bytes.buffer, 0, 2) as unknown as [number, number];
    if (width === 0 || bytes.length !== 8 + 4 * width * height) return;
    image.value = textureOf(bytes.subarray(8), width, height);
    ++this.images;
  }
}

// The first row is the upper one, as in texture coordinates. Bilinear and without mipmaps, which the images' gutters suffice for.
function textureOf(texels: Uint8Array<ArrayBuffer>, width: number, height: number): THREE.Texture {
  const texture = new THREE.DataTexture(texels, width, height, THREE.RGBAFormat, THREE.UnsignedByteType);
  texture.magFilter = texture.minFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
