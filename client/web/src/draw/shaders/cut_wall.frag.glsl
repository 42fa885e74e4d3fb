// Strata of height: bands between round heights, with lines at these, the bolder ones at every fifth; and soil below the ground.
in vec2 v_height;
uniform float u_stratum_m;
out vec4 o_colour;

vec3 stratum(float layer) {
  const vec3 kColours[5] = vec3[](vec3(0.26, 0.135, 0.06), vec3(0.36, 0.225, 0.10), vec3(0.17, 0.085, 0.05), vec3(0.43, 0.30, 0.15), vec3(0.29, 0.175, 0.10));
  return kColours[int(mod(layer, 5.0))];
}

void main() {
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m, normal = normalize(cross(dFdx(v_from_eye), dFdy(v_from_eye)));
  if (dot(normal, direction) > 0.0) normal = -normal;
  float at = v_height.x / u_stratum_m, width = max(fwidth(at), 1e-6), layer = floor(at + 0.5);
  // From a band to the next one over a pixel.
  vec3 albedo = mix(stratum(layer - 1.0), stratum(layer), clamp((at - layer) / width + 0.5, 0.0, 1.0));
  float is_bold = step(abs(mod(layer + 0.5, 5.0) - 0.5), 0.1);
  float line = 1.0 - smoothstep(0.5, 1.5, abs(at - layer) / width - 0.7 * is_bold);
  albedo = mix(albedo, vec3(0.10, 0.065, 0.04), line * mix(0.45, 0.85, is_bold) * (1.0 - smoothstep(0.2, 0.5, width)));
  float soil = v_height.y / (0.16 * u_stratum_m);
  albedo = mix(vec3(0.085, 0.06, 0.035), albedo, smoothstep(0.8, 1.0, soil));
  vec3 colour = 0.5 * lit(albedo, normal, 1.0) + 0.5 * lit(albedo, u_up, 0.75);
  if (u_haze > 0.0) colour = mix(hazeColour(direction), colour, exp(-hazeAlong(distance_m)));
  o_colour = vec4(toScreen(colour), 1.0);
}
