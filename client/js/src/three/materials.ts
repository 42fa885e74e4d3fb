// The materials that a blended mesh is drawn with. The default ones are three's standard material, extended: whatever lights, shadows,
// fog, clipping, tone mapping or depth a scene has, they have. A page with a light of its own makes its own (GroundMaterials).
import * as THREE from 'three';
import { glsl } from './glsl.js';

export type Uniforms = Record<string, THREE.IUniform>;

/** A material of an object's model, whose image comes later than the first mesh. */
export interface ObjectMaterial {
  material: THREE.Material;
  setImage(image: THREE.Texture): void;
}

/** What draws the meshes. `uniforms` are those of the shaders' parts (`glsl`), and are to be given on as they are. */
export interface GroundMaterials {
  ground(uniforms: Uniforms): THREE.Material;
  object(uniforms: Uniforms, image: THREE.Texture): ObjectMaterial;
  lines(uniforms: Uniforms): THREE.Material;
  /** For shadow maps; without them the meshes cast no shadow. */
  depth?(uniforms: Uniforms, part: 'ground' | 'object'): { depth: THREE.Material; distance: THREE.Material };
}

/** @internal Where positions of a mesh are drawn, if not where they are: GLSL that has `vec3 NAME(vec3 position)`, and its uniforms. */
export interface Placement {
  name: string;
  glsl: string;
  uniforms: Uniforms;
}

type Shader = THREE.WebGLProgramParametersWithUniforms;

function replaced(source: string, chunk: string, by: string): string {
  if (!source.includes(chunk)) throw new Error(`A shader of this version of three has no ${chunk}.`);
  return source.replace(chunk, by);
}

// Positions and normals are blended, and everything after that is three's.
function blendVertices(shader: Shader, uniforms: Uniforms, part: 'ground' | 'object', placement: Placement | null): void {
  Object.assign(shader.uniforms, uniforms, placement?.uniforms);
  const is_ground = part === 'ground';
  let source = replaced(shader.vertexShader, '#include <begin_vertex>',
    `vec4 foreland_position = blended();\nvec3 transformed = ${placement ? `${placement.name}(foreland_position.xyz)` : 'foreland_position.xyz'};\n${is_ground ? 'passGround(foreland_position);' : ''}`);
  source = source.replace('#include <beginnormal_vertex>', 'vec3 objectNormal = normalize(mix(from_normal, to_normal, u_weight));');
  shader.vertexShader = glsl.interpolation + (is_ground ? glsl.groundVertex : '') + (placement?.glsl ?? '') + source;
}

const kGroundColour = `#include <map_fragment>
  vec2 foreland_lattice = latticeHere(), foreland_dx = dFdx(foreland_lattice), foreland_dy = dFdy(foreland_lattice);
  Ground foreland_ground = groundAt(normalize(v_normal), v_texture_coordinate.w, foreland_lattice, foreland_dx, foreland_dy);
  float foreland_facing = max(abs(dot(normalize(normalMatrix * foreland_ground.normal), normalize(vViewPosition))), 0.12);
  float foreland_pixel_m = max(length(vViewPosition) * u_pixel_rad / sqrt(foreland_facing), 1e-4);
  vec3 foreland_albedo = albedoOf(foreland_ground.normal, foreland_ground.height, foreland_pixel_m, foreland_dx, foreland_dy);
  diffuseColor.rgb *= withContours(foreland_albedo, foreland_ground.height);`;
const kGroundNormal = `#include <normal_fragment_maps>
  normal = normalize(normalMatrix * foreland_ground.normal);`;
const kGroundShadow = `#include <lights_fragment_end>
  reflectedLight.directDiffuse *= foreland_ground.sunshine;
  reflectedLight.directSpecular *= foreland_ground.sunshine;`;

function groundMaterial(uniforms: Uniforms, placement: Placement | null): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({ roughness: 1, metalness: 0 });
  material.onBeforeCompile = (shader) => {
    blendVertices(shader, uniforms, 'ground', placement);
    let source = replaced(shader.fragmentShader, '#include <map_fragment>', kGroundColour);
    source = replaced(source, '#include <normal_fragment_maps>', kGroundNormal);
    source = replaced(source, '#include <lights_fragment_end>', kGroundShadow);
    shader.fragmentShader = `uniform mat3 normalMatrix;\nuniform float u_pixel_rad;\n${glsl.common}${glsl.tiles}${glsl.ground}${source}`;
  };
  material.customProgramCacheKey = () => `foreland ground ${placement?.name}`;
  return material;
}

function objectMaterial(uniforms: Uniforms, image: THREE.Texture, placement: Placement | null): ObjectMaterial {
  const material = new THREE.MeshStandardMaterial({ roughness: 1, metalness: 0, map: image });
  material.onBeforeCompile = (shader) => blendVertices(shader, uniforms, 'object', placement);
  material.customProgramCacheKey = () => `foreland object ${placement?.name}`;
  return { material, setImage: (texture) => void (material.map = texture) };
}

function lineMaterial(uniforms: Uniforms, placement: Placement | null): THREE.Material {
  const material = new THREE.LineBasicMaterial({ color: 0x0a1219, transparent: true, opacity: 0.4, depthWrite: false });
  material.onBeforeCompile = (shader) => blendVertices(shader, uniforms, 'object', placement);
  material.customProgramCacheKey = () => `foreland lines ${placement?.name}`;
  return material;
}

function depthMaterials(uniforms: Uniforms, part: 'ground' | 'object', placement: Placement | null): { depth: THREE.Material; distance: THREE.Material } {
  const depth = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking });
  const distance = new THREE.MeshDistanceMaterial();
  for (const material of [depth, distance]) {
    material.onBeforeCompile = (shader: Shader) => blendVertices(shader, uniforms, part, placement);
    material.customProgramCacheKey = () => `foreland depth ${part} ${placement?.name}`;
  }
  return { depth, distance };
}

/** @internal Three's standard material, extended, whose vertices are drawn where `placement` says. */
export function standardMaterials(placement: Placement | null): GroundMaterials {
  return {
    ground: (uniforms) => groundMaterial(uniforms, placement), object: (uniforms, image) => objectMaterial(uniforms, image, placement),
    lines: (uniforms) => lineMaterial(uniforms, placement), depth: (uniforms, part) => depthMaterials(uniforms, part, placement),
  };
}

/** What a `ForelandTerrain` is drawn with if it is not told otherwise: three's standard material, extended. */
export const kStandardMaterials: GroundMaterials = standardMaterials(null);
