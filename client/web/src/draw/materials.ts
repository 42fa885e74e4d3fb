// The page's own look: ground, objects and edges in the light of its sun and behind its haze, straight to the screen.
import type { GroundMaterials, Uniforms } from '@foreland/client/three';
import { kObjectFragment, kObjectVertex, kTerrainFragment, kTerrainVertex, kWireFragment, kWireVertex, shader } from './shaders';

// `haze` are uniforms of light.glsl, `on_ground` of viewshed.glsl and overlay.glsl.
export function pageMaterials(haze: Uniforms, on_ground: Uniforms): GroundMaterials {
  return {
    ground: (uniforms) => shader(kTerrainVertex, kTerrainFragment, { ...uniforms, ...haze, ...on_ground }),
    object(uniforms, image) {
      const u_image = { value: image };
      return { material: shader(kObjectVertex, kObjectFragment, { ...uniforms, ...haze, u_image }), setImage: (texture) => void (u_image.value = texture) };
    },
    lines: (uniforms) => Object.assign(shader(kWireVertex, kWireFragment, { ...uniforms }), { transparent: true, depthWrite: false }),
  };
}
