in float v_distance;
uniform float u_far;
out vec4 o_colour;
void main() {
  o_colour = vec4(0.04, 0.07, 0.10, 0.50 * exp(-2.5 * v_distance / u_far));
}
