out vec4 o_colour;
uniform float u_pixel_rad;  // how much a pixel sees
void main() {
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m;
  vec2 lattice = latticeHere(), dx = dFdx(lattice), dy = dFdy(lattice);
  Ground ground = groundAt(normalize(v_normal), v_texture_coordinate.w, lattice, dx, dy);
  float facing = max(-dot(ground.normal, direction), 0.12);
  float pixel_m = max(distance_m * u_pixel_rad / sqrt(facing), 1e-4);
  vec3 albedo = withViewshed(withContours(albedoOf(ground.normal, ground.height, pixel_m, dx, dy), ground.height), v_lattice);
  vec3 point = airPoint(v_from_eye);
  vec3 colour = throughAir(litByAir(albedo, ground.normal, point, ground.sunshine), point);
  o_colour = vec4(withOverlay(toScreen(colour), v_lattice, dFdx(v_lattice), dFdy(v_lattice)), 1.0);
}
