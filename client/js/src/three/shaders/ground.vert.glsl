in vec2 texture_coordinate;  // position on the lattice
in float from_moved;         // metres upwards since the first epoch
in float to_moved;
uniform vec3 u_up;           // away from the zero surface, at the eye
uniform int u_frame;         // planar, geographic, globe
uniform vec3 u_from_middle;  // globe: of the mesh's origin
uniform float u_round;       // globe: by which the axis is stretched, so that normals of its ellipsoid are those of a ball
uniform vec2 u_pivot;        // a whole position near the eye
out vec2 v_lattice;          // from the pivot
out float v_moved;
out vec3 v_normal;
out vec3 v_up;               // away from the zero surface; of any length
out vec4 v_texture_coordinate;  // from the mesh's origin; height

// Passes on what the ground's colour is made of, at a blended position.
void passGround(vec4 p) {
  v_normal = mix(from_normal, to_normal, u_weight);
  v_up = u_frame == 2 ? (u_from_middle + p.xyz) * vec3(1.0, 1.0, u_round) : u_up;
  v_texture_coordinate = p;
  v_lattice = texture_coordinate - u_pivot;
  v_moved = mix(from_moved, to_moved, u_weight);
}
