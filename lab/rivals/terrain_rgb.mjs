// Terrain-RGB tiles cut from the ground: heights in steps of 0.1 m from -10,000 m on, in the three channels of a picture, over
// Mercator's tiling of one square at level 0. A texel's height is that of its middle, as MapLibre 6 reads it. Rows count from the north.
import sharp from 'sharp';

export const kTexels = 256;
export const kStep_m = 0.1;

const mercatorX = (lon) => 0.5 + lon / (2 * Math.PI);
const mercatorY = (lat) => 0.5 - Math.asinh(Math.tan(lat)) / (2 * Math.PI);
const longitude = (x) => (x - 0.5) * 2 * Math.PI;
const latitude = (y) => Math.atan(Math.sinh((0.5 - y) * 2 * Math.PI));

export function rgbTilesOver(ground, level) {
  const n = 2 ** level, inside = 1e-12, index = (v) => Math.floor(v * n);
  return { startX: index(mercatorX(ground.west) + inside), startY: index(mercatorY(ground.north) + inside), endX: index(mercatorX(ground.east) - inside), endY: index(mercatorY(ground.south) - inside) };
}

// The level whose texels are at least as dense as the data.
export const finestRgbLevel = (ground) => Math.ceil(Math.log2((2 * Math.PI) / kTexels / Math.min(ground.dx, ground.dy / Math.cos(ground.south))) - 1e-9);

export const decodeTexel = (r, g, b) => -10000 + (65536 * r + 256 * g + b) * kStep_m;

// Three bytes a texel.
export function rgbTexels(level, x, y, ground) {
  const texels = Buffer.alloc(3 * kTexels * kTexels), n = 2 ** level;
  for (let j = 0; j < kTexels; ++j) {
    const lat = latitude((y + (j + 0.5) / kTexels) / n);
    for (let i = 0; i < kTexels; ++i)
      texels.writeUIntBE(Math.round((ground.heightAt(longitude((x + (i + 0.5) / kTexels) / n), lat) + 10000) / kStep_m), 3 * (j * kTexels + i), 3);
  }
  return texels;
}

export const losslessWebp = (texels) => sharp(texels, { raw: { width: kTexels, height: kTexels, channels: 3 } }).webp({ lossless: true, effort: 4 }).toBuffer();

export const rgbSource = (ground) => ({ minzoom: 0, maxzoom: finestRgbLevel(ground), bounds: [ground.west, ground.south, ground.east, ground.north].map((v) => (v * 180) / Math.PI) });
