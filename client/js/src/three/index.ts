/** A terrain as an object of a three scene. */
export { colourAt, readColourMap, stretched, tintsOf, type ColourMap, type Rgb, type Tints } from './colour_map.js';
export { ForelandTerrain, type DrawnStats, type ForelandTerrainOptions } from './foreland_terrain.js';
export { glsl } from './glsl.js';
export { kStandardMaterials, type GroundMaterials, type ObjectMaterial, type Uniforms } from './materials.js';
export { readSea, undulationAt, type Sea, type Undulations } from './sea.js';
export { kDefaultStyle, kGrounds, type Ground, type Style } from './style.js';
