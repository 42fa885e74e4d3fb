in vec2 v_lattice;
uniform float u_footprint;  // sample intervals of a pixel
out vec4 o_colour;
void main() {
  Ground ground = groundAt(vec3(0.0), 0.0, v_lattice, vec2(u_footprint, 0.0), vec2(0.0, u_footprint));
  o_colour = vec4(toScreen(lit(u_ground == 4 ? tintAt(ground.height) : vec3(0.24), ground.normal, ground.sunshine)), 1.0);
}
