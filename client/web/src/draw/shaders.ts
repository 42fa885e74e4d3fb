// The page's shaders: the client's ground under a sky, a sun and a haze of the page's own. Distances are metres relative to the eye, along
// the scene's axes, so floats keep their precision far from the scene's origin. Colours are linear until the last line.
import { glsl } from '@foreland/client/three';
import * as THREE from 'three';
import atmosphere from './shaders/atmosphere.glsl?raw';
import cut from './shaders/cut.glsl?raw';
import cutWallFrag from './shaders/cut_wall.frag.glsl?raw';
import cutWallVert from './shaders/cut_wall.vert.glsl?raw';
import head from './shaders/head.glsl?raw';
import light from './shaders/light.glsl?raw';
import markFrag from './shaders/mark.frag.glsl?raw';
import markVert from './shaders/mark.vert.glsl?raw';
import objectFrag from './shaders/object.frag.glsl?raw';
import objectVert from './shaders/object.vert.glsl?raw';
import probeFrag from './shaders/probe.frag.glsl?raw';
import probeVert from './shaders/probe.vert.glsl?raw';
import overlay from './shaders/overlay.glsl?raw';
import skyFrag from './shaders/sky.frag.glsl?raw';
import skyVert from './shaders/sky.vert.glsl?raw';
import terrainFrag from './shaders/terrain.frag.glsl?raw';
import terrainVert from './shaders/terrain.vert.glsl?raw';
import viewshed from './shaders/viewshed.glsl?raw';
import wireFrag from './shaders/wire.frag.glsl?raw';
import wireVert from './shaders/wire.vert.glsl?raw';

const { common, ground, groundVertex, interpolation, tiles } = glsl;

export const kTerrainVertex = head + interpolation + groundVertex + terrainVert;
export const kTerrainFragment = head + common + atmosphere + light + tiles + ground + viewshed + overlay + cut + terrainFrag;
export const kProbeVertex = head + probeVert;
export const kProbeFragment = head + common + atmosphere + light.replace('in vec3 v_from_eye;', 'const vec3 v_from_eye = vec3(0.0);') + tiles + probeFrag;
export const kObjectVertex = head + interpolation + objectVert;
export const kObjectFragment = head + common + atmosphere + light + cut + objectFrag;
export const kMarkVertex = head + markVert;
export const kMarkFragment = head + markFrag;
export const kWireVertex = head + interpolation + wireVert;
export const kWireFragment = head + cut + wireFrag;
export const kCutWallVertex = head + cutWallVert;
export const kCutWallFragment = head + common + atmosphere + light + cutWallFrag;
export const kSkyVertex = head + skyVert;
export const kSkyFragment = head + common + atmosphere + skyFrag;

export function shader(vertexShader: string, fragmentShader: string, uniforms: Record<string, THREE.IUniform>): THREE.RawShaderMaterial {
  return new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader, fragmentShader, uniforms });
}
