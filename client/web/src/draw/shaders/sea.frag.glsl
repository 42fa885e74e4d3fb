// The sea where no ground is drawn before it: between its horizon and that of its floor. As deep as it hides what is behind it.
in vec3 v_direction;
uniform vec3 u_sea_ahead;     // where the camera looks
uniform mat4 projectionMatrix;
uniform bool u_sea_reversed;  // depths
uniform float u_sea_floor_m;  // of a ball below all ground, that far below the sea
out vec4 o_colour;

const float kThrough_m = 12e3;  // of water, which is as dark as any that is deeper

float depthAt(vec3 direction, float distance_m) {
  float z = -distance_m * dot(direction, u_sea_ahead), depth = (projectionMatrix[2][2] * z + projectionMatrix[3][2]) / -z;
  return u_sea_reversed ? depth : 0.5 * depth + 0.5;
}

void main() {
  vec3 direction = normalize(v_direction);
  float distance_m = seaDistance(direction, 0.0);
  if (distance_m < 0.0) discard;
  // Ground is drawn where it is, or nearly: what may be land is not hidden by the sea that it stands out of.
  float hidden_m = seaDistance(direction, max(3.0, u_sea_tolerance * distance_m));
  if (hidden_m > 0.0) hidden_m = max(hidden_m, distance_m + kThrough_m);
  gl_FragDepth = hidden_m > 0.0 ? clamp(depthAt(direction, hidden_m), 0.0, 1.0) : u_sea_reversed ? 0.0 : 1.0;
  float floor_m = seaDistance(direction, u_sea_floor_m);
  bool is_drawn_over = floor_m > 0.0 && (hidden_m < 0.0 || floor_m < hidden_m);
  o_colour = vec4(is_drawn_over ? seaColour(kThrough_m) : toScreen(seaSeen(direction, distance_m, kThrough_m)), 1.0);
}
