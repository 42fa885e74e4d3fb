// The air about a globe (@takram/three-atmosphere), and what it does to what is seen. Positions are kilometres in a space where the ellipsoid is
// the ball that the textures are of: stretched along the axis, so that lines and the limb stay what they are.
uniform vec3 u_air_eye;
uniform vec3 u_air_scale;  // from metres
uniform int u_air;         // 0: none

const float kAirExposure = 2.9;   // of radiance, to the page's light
const float kAirBrighter = 2.0;  // than the ground's colours are on maps, whose light no air dims

vec3 airPoint(vec3 from_eye) {
  vec3 point = u_air_eye + from_eye * u_air_scale;
  return point * (max(length(point), ATMOSPHERE.bottom_radius + 0.002) / length(point));
}

// `sunshine`: the share of the sun that is seen.
vec3 litByAir(vec3 albedo, vec3 normal, vec3 point, float sunshine) {
  vec3 skylight, sunlight = GetSunAndSkyIrradiance(point, normal, u_sun, skylight);
  return kAirBrighter * albedo * ((sunshine * sunlight + skylight) / PI + 0.0015);
}

vec3 throughAir(vec3 colour, vec3 point) {
  if (u_air == 0) return kAirExposure * colour;
  vec3 transmittance, scattered = GetSkyRadianceToPoint(u_air_eye, point, 0.0, u_sun, transmittance);
  return kAirExposure * (colour * transmittance + max(scattered, vec3(0.0)));
}

vec3 skyInAir(vec3 direction) {
  vec3 transmittance = vec3(1.0), radiance = vec3(0.0), ray = normalize(direction * u_air_scale);
  if (u_air != 0) radiance = max(GetSkyRadiance(u_air_eye, ray, 0.0, u_sun, transmittance), vec3(0.0));
  float disc = smoothstep(0.99996, 0.999985, dot(direction, u_sun));
  return kAirExposure * (radiance + transmittance * disc * 40.0);
}
