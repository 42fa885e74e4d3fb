// The page's own look: ground, objects and edges in the light of its sun and behind its haze, straight to the screen.
import type { GroundMaterials, Uniforms } from '@foreland/client/three';
import type * as THREE from 'three';
import { kObjectFragment, kObjectVertex, kTerrainFragment, kTerrainVertex, kWireFragment, kWireVertex, shader } from './shaders';

// `haze` are uniforms of light.glsl, `on_ground` of viewshed.glsl and overlay.glsl; `cut` those of cut.glsl, and who decides whether that is there.
export function pageMaterials(haze: Uniforms, on_ground: Uniforms, cut: { uniforms: Uniforms; adopt(material: THREE.RawShaderMaterial): THREE.RawShaderMaterial }): GroundMaterials {
  return {
    ground: (uniforms) => cut.adopt(shader(kTerrainVertex, kTerrainFragment, { ...uniforms, ...haze, ...on_ground, ...cut.uniforms })),
    object(uniforms, image) {
      const u_image = { value: image };
      return { material: cut.adopt(shader(kObjectVertex, kObjectFragment, { ...uniforms, ...haze, ...cut.uniforms, u_image })), setImage: (texture) => void (u_image.value = texture) };
    },
    lines: (uniforms) => Object.assign(cut.adopt(shader(kWireVertex, kWireFragment, { ...uniforms, ...cut.uniforms })), { transparent: true, depthWrite: false }),
  };
}
