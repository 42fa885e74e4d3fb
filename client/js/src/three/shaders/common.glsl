uniform vec3 u_sun;            // towards the sun whose shadows the relief has
uniform vec3 u_up;             // away from the zero surface, at the eye
uniform bool u_is_geographic;  // planar or a globe otherwise
// What only globes need is compiled for them alone: elsewhere it would cost a quarter of a frame on a processor that draws.
#ifdef GLOBE
#define IS_GLOBE true
#else
#define IS_GLOBE false
#endif
uniform vec2 u_heights;        // lowest, highest ground

// A sea's floor that no water covers, by its depth.
vec3 floorColour(float depth_m) {
  return mix(vec3(0.260, 0.225, 0.160), vec3(0.065, 0.075, 0.090), 1.0 - exp(-depth_m / 2500.0));
}

// Under water, by its depth.
vec3 seaColour(float depth_m) {
  return mix(vec3(0.020, 0.075, 0.110), vec3(0.004, 0.017, 0.050), 1.0 - exp(-depth_m / 1800.0));
}
