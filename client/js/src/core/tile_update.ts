// What changes in the tiles of relief and imagery with a mesh.

// Of one tile: slopes and ground texels (client/imagery/shadows.h) with those of the half-size image, or an image, whose half-size
// image is copied from the parent's layer. A tile whose shadows have changed has ground texels alone.
export interface TileUpload {
  layer: number;
  parent_layer: number | null;
  is_odd: readonly [boolean, boolean]; // its column and row: where it lies in its parent
  slopes: readonly [Uint16Array<ArrayBuffer>, Uint16Array<ArrayBuffer>] | null;
  ground: readonly [Uint8Array<ArrayBuffer>, Uint8Array<ArrayBuffer>] | null;
  image: ImageBitmap | null;
}

// Of a content, with a mesh.
export interface TileUpdate {
  scene: number;
  shown: number;
  page_table: Uint16Array<ArrayBuffer>;
  uploads: TileUpload[];
}

export function tileMemoryOf(update: TileUpdate): Transferable[] {
  const uploads = update.uploads.flatMap(({ slopes, ground, image }) => [
    ...(slopes ?? []).map((s) => s.buffer), ...(ground ?? []).map((g) => g.buffer), ...(image ? [image] : [])]);
  return [update.page_table.buffer, ...uploads];
}
