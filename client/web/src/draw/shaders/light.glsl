// Light on whatever stands in the scene, and the haze before it.
in vec3 v_from_eye;
uniform float u_haze;         // optical depth per metre at the lowest ground; 0: none
uniform float u_haze_height;  // over which it falls to 1 / e
uniform float u_eye_height;

// `sunshine`: the share of the sun that is seen.
vec3 lit(vec3 albedo, vec3 normal, float sunshine) {
  float sunlight = sunshine * max(dot(normal, u_sun), 0.0);
  float openness = 0.5 + 0.5 * dot(normal, u_up);
  vec3 skylight = mix(vec3(0.09, 0.08, 0.07), vec3(0.17, 0.24, 0.36), openness);
  return albedo * (sunColour() * sunlight + daylight() * skylight);
}

// Optical depth through haze that thins exponentially with height (exact along the ray).
float hazeAlong(float distance_m) {
  float rise = dot(v_from_eye, u_up) / u_haze_height;
  float mean = abs(rise) < 1e-3 ? 1.0 : (1.0 - exp(-rise)) / rise;
  float at_eye = exp(-clamp((u_eye_height - u_heights.x) / u_haze_height, -2.0, 20.0));
  return u_haze * distance_m * at_eye * mean;
}
