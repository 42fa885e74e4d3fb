// All tiles of a flight's ground, by the path that each is asked for.
import { compressTile, encodeTile, finestLevel, layerJson, tileBounds, tilesOver } from './quantized_mesh.mjs';
import { finestRgbLevel, losslessWebp, rgbTexels, rgbTilesOver } from './terrain_rgb.mjs';

export function cutQuantizedMesh(ground, earth) {
  const finest = finestLevel(ground), tiles = new Map();
  tiles.set('/quantized/layer.json', { type: 'application/json', body: Buffer.from(JSON.stringify(layerJson(ground, finest))) });
  for (let level = 0; level <= finest; ++level) {
    const { startX, startY, endX, endY } = level === 0 ? { startX: 0, startY: 0, endX: 1, endY: 0 } : tilesOver(ground, level);
    for (let y = startY; y <= endY; ++y)
      for (let x = startX; x <= endX; ++x)
        tiles.set(`/quantized/${level}/${x}/${y}.terrain`, { type: 'application/vnd.quantized-mesh', coding: 'gzip', body: compressTile(encodeTile(tileBounds(level, x, y), ground, earth)) });
  }
  return tiles;
}

export async function cutTerrainRgb(ground) {
  const tiles = new Map();
  for (let level = 0; level <= finestRgbLevel(ground); ++level) {
    const { startX, startY, endX, endY } = rgbTilesOver(ground, level);
    for (let y = startY; y <= endY; ++y)
      for (let x = startX; x <= endX; ++x) tiles.set(`/terrain-rgb/${level}/${x}/${y}.webp`, { type: 'image/webp', body: await losslessWebp(rgbTexels(level, x, y, ground)) });
  }
  return tiles;
}
