// The parts of shaders of which materials for blended meshes are made, GLSL ES 3.0. A vertex shader begins with `interpolation`; the
// ground's goes on with `groundVertex` and calls `passGround(blended())`. Its fragment shader begins with `common`, `tiles` and `ground`,
// and calls `groundAt` and `albedoOf`.
import common from './shaders/common.glsl';
import ground from './shaders/ground.glsl';
import groundVertex from './shaders/ground.vert.glsl';
import interpolation from './shaders/interpolation.glsl';
import tiles from './shaders/tiles.glsl';

/** Parts of shaders for materials of one's own; `GroundMaterials` says how they are used. */
export const glsl = { common, ground, groundVertex, interpolation, tiles } as const;
