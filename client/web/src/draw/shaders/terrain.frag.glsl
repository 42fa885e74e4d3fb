out vec4 o_colour;
uniform float u_pixel_rad;  // how much a pixel sees
uniform float u_exaggeration;  // of heights
void main() {
#ifdef CUT
  if (isCutAway(u_cut, v_lattice)) discard;
#endif
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m;
  vec2 lattice = latticeHere(), dx = dFdx(lattice), dy = dFdy(lattice);
  Ground ground = groundAt(normalize(v_normal), v_texture_coordinate.w, lattice, dx, dy);
  float facing = max(-dot(ground.normal, direction), 0.12);
  float pixel_m = max(distance_m * u_pixel_rad / sqrt(facing), 1e-4);
  vec3 colour = lit(albedoOf(ground.normal, ground.height, pixel_m, dx, dy), normalize(vec3(ground.normal.xy, ground.normal.z / u_exaggeration)), ground.sunshine);
  colour = withViewshed(withContours(colour, ground.height), v_lattice);
  if (u_haze > 0.0) colour = mix(hazeColour(direction), colour, exp(-hazeAlong(distance_m)));
  o_colour = vec4(withOverlay(toScreen(colour), v_lattice, dx, dy), 1.0);
}
