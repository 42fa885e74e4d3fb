in vec2 texture_coordinate;  // position on the lattice
in float from_moved;         // metres upwards since the first epoch
in float to_moved;
uniform vec2 u_pivot;        // a whole position near the eye
out vec2 v_lattice;          // from the pivot
out float v_moved;
out vec3 v_normal;
out vec3 v_texture_coordinate;  // x, y from the mesh's origin; height

// Passes on what the ground's colour is made of, at a blended position.
void passGround(vec4 p) {
  v_normal = mix(from_normal, to_normal, u_weight);
  v_texture_coordinate = vec3(p.xy, p.w);
  v_lattice = texture_coordinate - u_pivot;
  v_moved = mix(from_moved, to_moved, u_weight);
}
