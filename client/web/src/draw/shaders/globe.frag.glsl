out vec4 o_colour;
uniform float u_pixel_rad;  // how much a pixel sees
uniform vec2 u_pivot;       // a whole position on the lattice near the eye

// The share of a pixel that is water: by the ground's height above the sea, whose sign changes at the coast. The mesh knows it to the tolerance,
// tiles of relief to half their step (8 m) and to what is inside a texel: so these decide where a pixel is wider. Level ground at 0 is the sea as
// models of land have it, give or take what heights and undulations are rounded by.
float waterShare(float height, float pixel_m) {
  const float kLevel_m = 0.15;
  float mesh_m = v_texture_coordinate.w - v_undulation, above_sea_m = mix(mesh_m, height - v_undulation, smoothstep(4.0, 8.0, pixel_m));
  if (max(abs(mesh_m), fwidth(mesh_m)) < kLevel_m) above_sea_m = -kLevel_m;
  return u_sea == 0 ? 0.0 : clamp(0.5 - above_sea_m / max(fwidth(above_sea_m), 1e-3), 0.0, 1.0);
}

// A position on the drawn face, which counts from that face's pivot, from the lattice's. Exact: both are whole.
vec2 fromPivot(vec2 on_face) {
  return on_face + (u_pivots[g_face] + vec2(float(g_face) * u_face_steps, 0.0) - u_pivot);
}

void main() {
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m;
  vec2 lattice = latticeHere(), dx = dFdx(lattice), dy = dFdy(lattice);
  Ground ground = groundAt(normalize(v_normal), v_texture_coordinate.w, lattice, dx, dy);
  float water = waterShare(ground.height, distance_m * u_pixel_rad);
  vec3 colour = vec3(0.0);
  if (water < 1.0) {
    float facing = max(-dot(ground.normal, direction), 0.12);
    float pixel_m = max(distance_m * u_pixel_rad / sqrt(facing), 1e-4);
    vec3 albedo = withViewshed(withContours(albedoOf(ground.normal, ground.height, pixel_m, dx, dy), ground.height), fromPivot(lattice));
    vec3 point = airPoint(v_from_eye);
    colour = throughAir(litByAir(albedo, ground.normal, point, ground.sunshine), point);
  }
  if (water > 0.0) {
    float sea_m = seaDistance(direction, 0.0), under_m = max(v_undulation - ground.height, 0.0);
    if (sea_m < 0.0 || sea_m > distance_m) sea_m = distance_m;
    colour = mix(colour, seaSeen(direction, sea_m, under_m / max(-dot(direction, seaUp(direction * sea_m)), 0.02)), water);
  }
  o_colour = vec4(withOverlay(toScreen(colour), fromPivot(lattice), dx, dy), 1.0);
}
