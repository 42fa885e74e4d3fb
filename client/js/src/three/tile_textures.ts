// The tiles of a content on the graphics card: a texture array with a layer for each tile, and the page table that says where each is.
// Tiles are uploaded ahead of the mesh that draws them, in slices, and the page table changes with the mesh.
import * as THREE from 'three';
import { kTileSide, type Content } from '../core/values.js';
import type { TileUpdate, TileUpload } from '../core/tile_update.js';

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
  // For the shaders: the array, whose images have half-size images, and the table. Of relief the images are slopes, and `grounds` are
  // heights with shadows.
  readonly uniforms: { images: THREE.IUniform<THREE.Texture>; grounds: THREE.IUniform<THREE.Texture> | null; pages: THREE.IUniform<THREE.Texture> };
  shown = 0; // tiles
  private images: WebGLTexture;
  private grounds: WebGLTexture | null = null;
  private pages: WebGLTexture;
  private readonly source: WebGLFramebuffer;
  private readonly target: WebGLFramebuffer;
  private scene = 0;
  private levels = 1;
  private waiting: Waiting[] = [];
  private drawn = new Set<number>(); // layers

  // Everything here but add() and the counts runs inside withOwnState().
  constructor(private readonly renderer: THREE.WebGLRenderer, private readonly gl: WebGL2RenderingContext, private readonly content: Content,
              private readonly layers: number, private readonly anisotropy: number) {
    [this.source, this.target] = [this.gl.createFramebuffer()!, this.gl.createFramebuffer()!];
    this.images = this.makeImages(1, 1);
    this.pages = this.makePages(1);
    if (content === 'relief') this.grounds = this.makeImages(1, 1, this.gl.RGBA8);
    this.uniforms = {
      images: { value: new THREE.Texture() },
      grounds: this.grounds && { value: new THREE.Texture() },
      pages: { value: new THREE.Texture() },
    };
    this.showTextures();
  }

  dispose(): void {
    for (const texture of [this.images, this.grounds, this.pages]) this.gl.deleteTexture(texture);
    for (const buffer of [this.source, this.target]) this.gl.deleteFramebuffer(buffer);
    this.reset();
  }
  // Forgets what was added and not uploaded.
  reset(): void {
    for (const { uploads } of this.waiting) for (const { image } of uploads) image?.close();
    this.waiting = [];
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
        if (this.mustWait(waiting)) return spent;
        spent += this.uploadSlice(waiting, budget - spent);
      }
    }
    return spent;
  }
  // Whether show() has next to nothing left to do.
  isReady(version: number): boolean {
    return this.waiting.every((w) => w.version > version || w.uploads.length === 0 || this.mustWait(w));
  }
  // For show(): another tile in a layer that is drawn. New shadows of the tile that is drawn there need not.
  private mustWait({ update, uploads }: Waiting): boolean {
    const [next] = uploads;
    return update.scene !== this.scene || (this.drawn.has(next!.layer) && !isRelit(next!));
  }
  // What remains to be uploaded for a mesh, in bytes.
  costTo(version: number): number {
    return this.waiting.reduce((sum, w) => sum + (w.version <= version ? w.uploads.reduce((s, u) => s + kTileSide * rowBytesOf(u), 0) : 0), 0);
  }

  // Draws what belongs to the mesh of `version` from now on; gives how many bytes had to be uploaded for that.
  show(version: number): number {
    let [last, spent]: [TileUpdate | null, number] = [null, 0];
    while (this.waiting.length > 0 && this.waiting[0]!.version <= version) {
      const waiting = this.waiting.shift()!;
      if (waiting.update.scene !== this.scene) this.enter(waiting.update);
      while (waiting.uploads.length > 0) spent += this.uploadSlice(waiting, Infinity);
      last = waiting.update;
    }
    if (last) this.showPages(last);
    return spent;
  }

  private enter({ scene, page_table }: TileUpdate): void {
    this.scene = scene;
    this.levels = page_table.length / kEmpty.page_table.length;
    this.gl.deleteTexture(this.images);
    this.gl.deleteTexture(this.pages);
    [this.images, this.pages] = [this.makeImages(kTileSide, this.layers), this.makePages(this.levels)];
    if (this.grounds) {
      this.gl.deleteTexture(this.grounds);
      this.grounds = this.makeImages(kTileSide, this.layers, this.gl.RGBA8);
    }
    this.showTextures();
  }

  // The renderer takes these for the textures that it made of its own: all its versions keep them so, and it uploads nothing to a
  // texture of version 0.
  private showTextures(): void {
    const give = (texture: THREE.Texture, made: WebGLTexture) => Object.assign(this.renderer.properties.get(texture) as object, { __webglTexture: made });
    give(this.uniforms.images.value, this.images);
    give(this.uniforms.pages.value, this.pages);
    if (this.grounds) give(this.uniforms.grounds!.value, this.grounds);
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
    const { gl } = this;
    const upload = waiting.uploads[0]!;
    const row_bytes = rowBytesOf(upload);
    const rows = upload.image ? kTileSide : Math.min(kTileSide - waiting.row, Math.max(32, 2 * Math.floor(budget / (2 * row_bytes))));
    this.bind(gl.TEXTURE_2D_ARRAY, this.images);
    if (upload.slopes) this.uploadRows(upload.layer, upload.slopes, 2, gl.RG, gl.HALF_FLOAT, waiting.row, rows);
    else if (upload.image) this.uploadImage(upload);
    if (upload.ground) {
      this.bind(gl.TEXTURE_2D_ARRAY, this.grounds!);
      this.uploadRows(upload.layer, upload.ground, 4, gl.RGBA, gl.UNSIGNED_BYTE, waiting.row, rows);
    }
    waiting.row += rows;
    if (waiting.row === kTileSide) {
      waiting.row = 0;
      waiting.uploads.shift();
    }
    return row_bytes * rows;
  }

  // Rows of both images, of so many numbers a texel; half-size ones are half as many.
  private uploadRows(layer: number, [whole, half]: readonly [Uint8Array, Uint8Array] | readonly [Uint16Array, Uint16Array], numbers: number,
                     format: number, type: number, row: number, rows: number): void {
    const { gl } = this;
    const put = (level: number, data: Uint8Array | Uint16Array, side: number, from: number, count: number) => {
      const part = data.subarray(numbers * side * from, numbers * side * (from + count));
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, level, 0, from, layer, side, count, 1, format, type, part);
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
    }
  }

  private attach(target: number, layer: number, level: number): void {
    const { gl } = this;
    gl.bindFramebuffer(target, target === gl.READ_FRAMEBUFFER ? this.source : this.target);
    gl.framebufferTextureLayer(target, gl.COLOR_ATTACHMENT0, this.images, level, layer);
  }

  private bind(target: number, texture: WebGLTexture): void {
    this.gl.bindTexture(target, texture);
  }

  private makeImages(side: number, layers: number, format: number = this.content === 'relief' ? this.gl.RG16F : this.gl.SRGB8_ALPHA8): WebGLTexture {
    const { gl } = this;
    const texture = this.make(gl.TEXTURE_2D_ARRAY, gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR);
    const anisotropic = this.anisotropy > 1 ? gl.getExtension('EXT_texture_filter_anisotropic') : null;
    if (anisotropic) gl.texParameterf(gl.TEXTURE_2D_ARRAY, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, this.anisotropy);
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

function isRelit(upload: TileUpload): boolean {
  return upload.slopes === null && upload.image === null;
}
// Of a row of a tile's images, with the part of the half-size ones that belongs to it.
function rowBytesOf(upload: TileUpload): number {
  return 5 * kTileSide * (upload.slopes && upload.ground ? 2 : 1);
}
