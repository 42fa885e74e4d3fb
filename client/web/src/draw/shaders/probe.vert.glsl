// The light on the ground at given positions (draw/shade_probe.ts).
in vec3 position;  // where it is drawn, and the position on the lattice
uniform vec2 u_pivot;
out vec2 v_lattice;
void main() {
  v_lattice = position.yz - u_pivot;
  gl_Position = vec4(position.x, 0.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}
