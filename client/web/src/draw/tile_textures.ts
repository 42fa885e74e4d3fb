// The tiles of a content on the graphics card: a texture array with a layer for each tile, and the page table that says where each is.
// Tiles are uploaded ahead of the mesh that draws them, in slices, and the page table changes with the mesh.
import * as THREE from 'three';
import { kTileSide, type Content } from '../core/core';
import type { TileUpdate, TileUpload } from '../core/tiles';

export const kPageSide = 32; // of the page table in each level; client/imagery/residency.h
const kGutter = 4; // texels about a tile's own; proto/imagery/tile.h
const kEmpty = { page_table: new Uint16Array(4 * kPageSide * kPageSide), shown: 0 };

interface Waiting {
  version: number;
  uploads: TileUpload[]; // that remain
  row: number; // of the first of them: rows that are there
  update: TileUpdate;
}

export class TileTextures {
  // For the shaders: the array, whose images have half-size images, and the table.
  readonly uniforms: { images: THREE.IUniform<THREE.Texture>; pages: THREE.IUniform<THREE.Texture> };
  shown = 0; // tiles
  private readonly gl: WebGL2RenderingContext;
  private images: WebGLTexture;
  private pages: WebGLTexture;
  private readonly source: WebGLFramebuffer;
  private readonly target: WebGLFramebuffer;
  private scene = 0;
  private levels = 1;
  private waiting: Waiting[] = [];
  private drawn = new Set<number>(); // layers

  constructor(private readonly renderer: THREE.WebGLRenderer, private readonly content: Content, private readonly layers: number) {
    this.gl = renderer.getContext() as WebGL2RenderingContext;
    [this.source, this.target] = [this.gl.createFramebuffer()!, this.gl.createFramebuffer()!];
    this.images = this.makeImages(1, 1);
    this.pages = this.makePages(1);
    this.uniforms = { images: { value: new THREE.ExternalTexture(this.images) }, pages: { value: new THREE.ExternalTexture(this.pages) } };
  }

  add(version: number, update: TileUpdate): void {
    this.waiting.push({ version, uploads: [...update.uploads], row: 0, update });
  }

  // Uploads what the mesh of `version` needs, up to a number of bytes; gives how many. Layers that are drawn now wait for show().
  upload(version: number, budget: number): number {
    let spent = 0;
    for (const waiting of this.waiting) {
      if (waiting.version > version) break;
      while (spent < budget && waiting.uploads.length > 0) {
        if (waiting.update.scene !== this.scene || this.drawn.has(waiting.uploads[0]!.layer)) return spent;
        spent += this.uploadSlice(waiting, budget - spent);
      }
    }
    return spent;
  }
  // Whether show() has next to nothing left to do.
  isReady(version: number): boolean {
    const mayWait = ({ update, uploads }: Waiting) => update.scene !== this.scene || this.drawn.has(uploads[0]!.layer);
    return this.waiting.every((w) => w.version > version || w.uploads.length === 0 || mayWait(w));
  }
  // What remains to be uploaded for a mesh, in bytes.
  costTo(version: number): number {
    return this.waiting.reduce((sum, w) => sum + (w.version <= version ? w.uploads.length : 0), 0) * 5 * kTileSide * kTileSide;
  }

  // Draws what belongs to the mesh of `version` from now on.
  show(version: number): void {
    let last: TileUpdate | null = null;
    while (this.waiting.length > 0 && this.waiting[0]!.version <= version) {
      const waiting = this.waiting.shift()!;
      if (waiting.update.scene !== this.scene) this.enter(waiting.update);
      while (waiting.uploads.length > 0) this.uploadSlice(waiting, Infinity);
      last = waiting.update;
    }
    if (last) this.showPages(last);
  }

  private enter({ scene, page_table }: TileUpdate): void {
    this.scene = scene;
    this.levels = page_table.length / kEmpty.page_table.length;
    this.gl.deleteTexture(this.images);
    this.gl.deleteTexture(this.pages);
    [this.images, this.pages] = [this.makeImages(kTileSide, this.layers), this.makePages(this.levels)];
    (this.uniforms.images.value as THREE.ExternalTexture).sourceTexture = this.images;
    (this.uniforms.pages.value as THREE.ExternalTexture).sourceTexture = this.pages;
  }

  private showPages({ page_table, shown }: Pick<TileUpdate, 'page_table' | 'shown'>): void {
    const { gl } = this;
    this.bind(gl.TEXTURE_2D, this.pages);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, kPageSide, kPageSide * this.levels, gl.RGBA_INTEGER, gl.UNSIGNED_SHORT, page_table);
    this.shown = shown;
    this.drawn.clear();
    for (let i = 2; i < page_table.length; i += 4) if (page_table[i]! > 0) this.drawn.add(page_table[i]! - 1);
  }

  // A part of the first tile that waits; gives the bytes.
  private uploadSlice(waiting: Waiting, budget: number): number {
    const upload = waiting.uploads[0]!;
    const rows = Math.min(kTileSide - waiting.row, Math.max(32, Math.floor(budget / (4 * kTileSide))));
    this.bind(this.gl.TEXTURE_2D_ARRAY, this.images);
    if (upload.slopes) this.uploadSlopes(upload.layer, upload.slopes, waiting.row, rows);
    else if (waiting.row === 0) this.uploadImage(upload);
    waiting.row = upload.slopes ? waiting.row + rows : kTileSide;
    if (waiting.row === kTileSide) {
      waiting.row = 0;
      waiting.uploads.shift();
    }
    return 5 * kTileSide * (upload.slopes ? rows : kTileSide);
  }

  // Rows of both images; half-size ones are half as many.
  private uploadSlopes(layer: number, [whole, half]: readonly [Uint16Array, Uint16Array], row: number, rows: number): void {
    const { gl } = this;
    const put = (level: number, data: Uint16Array, side: number, from: number, count: number) => {
      const part = data.subarray(2 * side * from, 2 * side * (from + count));
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, from, layer, side, count, 1, gl.RG, gl.HALF_FLOAT, part);
    };
    put(0, whole, kTileSide, row, rows);
    const [begin, end] = [row >> 1, (row + rows) >> 1];
    put(1, half, kTileSide / 2, begin, end - begin);
  }

  // The half-size image is a part of the parent's; of a tile without one it is made of its own.
  private uploadImage({ layer, parent_layer, is_odd, image }: TileUpload): void {
    const { gl } = this;
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, kTileSide, kTileSide, 1, gl.RGBA, gl.UNSIGNED_BYTE, image!);
    image!.close();
    const half = kTileSide / 2;
    this.attach(gl.READ_FRAMEBUFFER, parent_layer ?? layer, 0);
    if (parent_layer !== null) {
      const [x, y] = is_odd.map((odd) => kGutter / 2 + (odd ? (kTileSide - 2 * kGutter) / 2 : 0)) as [number, number];
      gl.copyTexSubImage3D(gl.TEXTURE_2D_ARRAY, 1, 0, 0, layer, x, y, half, half);
    } else {
      this.attach(gl.DRAW_FRAMEBUFFER, layer, 1);
      gl.blitFramebuffer(0, 0, kTileSide, kTileSide, 0, 0, half, half, gl.COLOR_BUFFER_BIT, gl.LINEAR);
      this.renderer.state.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    }
    this.renderer.state.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
  }

  private attach(target: number, layer: number, level: number): void {
    const { gl } = this;
    this.renderer.state.bindFramebuffer(target, target === gl.READ_FRAMEBUFFER ? this.source : this.target);
    gl.framebufferTextureLayer(target, gl.COLOR_ATTACHMENT0, this.images, level, layer);
  }

  private bind(target: number, texture: WebGLTexture): void {
    const { gl } = this;
    this.renderer.state.bindTexture(target, texture);
    // Of what the renderer may have set for textures of its own.
    this.renderer.state.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false as unknown as number);
    this.renderer.state.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false as unknown as number);
    this.renderer.state.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    this.renderer.state.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
  }

  private makeImages(side: number, layers: number): WebGLTexture {
    const { gl } = this;
    const texture = this.make(gl.TEXTURE_2D_ARRAY, gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR);
    const format = this.content === 'relief' ? gl.RG16F : gl.SRGB8_ALPHA8;
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, side > 1 ? 2 : 1, format, side, side, layers);
    return texture;
  }
  private makePages(levels: number): WebGLTexture {
    const { gl } = this;
    const texture = this.make(gl.TEXTURE_2D, gl.NEAREST, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA16UI, kPageSide, kPageSide * levels);
    return texture;
  }
  private make(target: number, min: number, mag: number): WebGLTexture {
    const { gl } = this;
    const texture = gl.createTexture()!;
    this.bind(target, texture);
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, min);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, mag);
    gl.texParameteri(target, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(target, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return texture;
  }
}
