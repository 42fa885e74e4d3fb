// The sea of a globe, as it is seen along rays: the ellipsoid raised by the geoid's undulation below the eye, which is a ball in a space that is
// stretched along the axis. Where there is water at all, the ground decides (globe.frag.glsl); beyond its edge, sea.frag.glsl.
uniform int u_sea;              // whether it is drawn
uniform vec3 u_sea_eye;         // in that space, metres from the middle
uniform float u_sea_radius;     // of the ball
uniform float u_sea_power;      // of the eye: its distance from the middle, squared, less the radius squared
uniform float u_sea_round;      // by which the axis is stretched
uniform float u_sea_tolerance;  // by how much the ground's error may turn what is seen, radians

// Along a unit direction to the sea lowered by `deep` metres; negative where the ray misses it.
float seaDistance(vec3 direction, float deep) {
  vec3 ray = direction * vec3(1.0, 1.0, u_sea_round);
  float a = dot(ray, ray), b = dot(ray, u_sea_eye), c = u_sea_power + deep * (2.0 * u_sea_radius - deep), d = b * b - a * c;
  return b >= 0.0 || d < 0.0 ? -1.0 : c / (sqrt(d) - b);
}

vec3 seaUp(vec3 from_eye) {
  vec3 at = u_sea_eye + from_eye * vec3(1.0, 1.0, u_sea_round);
  return normalize(at * vec3(1.0, 1.0, u_sea_round));
}

// With what is mirrored of sky and sun by waves of a moderate breeze (Cox and Munk's slopes). `through_m`: of water along the ray.
vec3 seaSeen(vec3 direction, float distance_m, float through_m) {
  const float kSlopes = 0.03, kGlitter = 0.15;  // of what still air would show: a camera has more range than a screen
  vec3 from_eye = direction * distance_m, up = seaUp(from_eye), point = airPoint(from_eye);
  vec3 skylight, sunlight = GetSunAndSkyIrradiance(point, up, u_sun, skylight);
  float facing = max(-dot(direction, up), 0.02), mirrored = 0.02 + 0.35 * pow(1.0 - facing, 5.0);
  vec3 half_way = normalize(u_sun - direction);
  float cosine = max(dot(half_way, up), 0.05), tangent2 = 1.0 / (cosine * cosine) - 1.0;
  float glitter = exp(-tangent2 / kSlopes) / (PI * kSlopes * pow(cosine, 4.0)) / (4.0 * max(facing, 0.2) * max(dot(u_sun, up), 0.2));
  float through_air = 0.02 + 0.98 * pow(1.0 - max(dot(half_way, u_sun), 0.0), 5.0);
  vec3 shallow = mix(vec3(0.030, 0.085, 0.095), seaColour(through_m), 1.0 - exp(-through_m / 40.0));
  vec3 colour = kAirBrighter * (shallow * ((sunlight + skylight) / PI + 0.0015) + mirrored * skylight / PI + kGlitter * through_air * glitter * sunlight);
  return throughAir(colour, point);
}
