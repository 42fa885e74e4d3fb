// The page's shaders. Distances are metres relative to the eye, along the scene's axes, so floats keep their precision far
// from the scene's origin. Colours are linear until the last line.
import atmosphere from './shaders/atmosphere.glsl?raw';
import head from './shaders/head.glsl?raw';
import interpolation from './shaders/interpolation.glsl?raw';
import light from './shaders/light.glsl?raw';
import objectFrag from './shaders/object.frag.glsl?raw';
import objectVert from './shaders/object.vert.glsl?raw';
import probeFrag from './shaders/probe.frag.glsl?raw';
import probeVert from './shaders/probe.vert.glsl?raw';
import skyFrag from './shaders/sky.frag.glsl?raw';
import skyVert from './shaders/sky.vert.glsl?raw';
import terrainFrag from './shaders/terrain.frag.glsl?raw';
import terrainVert from './shaders/terrain.vert.glsl?raw';
import tiles from './shaders/tiles.glsl?raw';
import wireFrag from './shaders/wire.frag.glsl?raw';
import wireVert from './shaders/wire.vert.glsl?raw';

// How ground is coloured: as it may look, or by the picture that is laid over it; in one colour; by how steep it is, and where it falls to;
// by its height, with a colour map; and by how far it has moved since the first epoch.
export const kGrounds = ['natural', 'plain', 'slope', 'aspect', 'heights', 'change'] as const;
export type Ground = (typeof kGrounds)[number];

export const kTerrainVertex = head + interpolation + terrainVert;
export const kTerrainFragment = head + atmosphere + light + tiles + terrainFrag;
export const kProbeVertex = head + probeVert;
export const kProbeFragment = head + atmosphere + light.replace('in vec3 v_from_eye;', 'const vec3 v_from_eye = vec3(0.0);') + tiles + probeFrag;
export const kObjectVertex = head + interpolation + objectVert;
export const kObjectFragment = head + atmosphere + light + objectFrag;
export const kWireVertex = head + interpolation + wireVert;
export const kWireFragment = head + wireFrag;
export const kSkyVertex = head + skyVert;
export const kSkyFragment = head + atmosphere + skyFrag;
