in vec3 v_normal;
in vec2 v_texture_coordinate;
uniform sampler2D u_image;
out vec4 o_colour;
void main() {
#ifdef CUT
  if (isCutAway(u_cut_scene, v_from_eye.xy)) discard;
#endif
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m;
  vec3 colour = lit(texture(u_image, v_texture_coordinate).rgb, normalize(v_normal), 1.0);
  if (u_haze > 0.0) colour = mix(hazeColour(direction), colour, exp(-hazeAlong(distance_m)));
  o_colour = vec4(toScreen(colour), 1.0);
}
