in float v_distance;
in vec2 v_aside;  // from the eye
uniform float u_far;
out vec4 o_colour;
void main() {
#ifdef CUT
  if (isCutAway(u_cut_scene, v_aside)) discard;
#endif
  o_colour = vec4(0.04, 0.07, 0.10, 0.50 * exp(-2.5 * v_distance / u_far));
}
