// A frame between two keyframes: mix of two positions with one weight (THEORY section 2). Of more keyframes, a way that bends
// (BlendMesh::from_bends).
in vec4 from_position;  // metres from the mesh's origin; w: height above the zero surface
in vec4 to_position;
in vec3 from_bend;      // metres; 0 if the mesh has none
in vec3 to_bend;
in vec3 from_normal;
in vec3 to_normal;
uniform float u_weight;

vec4 blended() {
  vec4 p = mix(from_position, to_position, u_weight);
  p.xyz += u_weight * (1.0 - u_weight) * mix(from_bend, to_bend, u_weight);
  return p;
}
