// Where a map draws a place of the earth. A map is flat, or its earth is a sphere, while a scene lies on the ellipsoid; so vertices are moved,
// by little near the eye. Lengths are metres from the zero surface below the eye, eastward, northward and up. Angles are small ones: they go
// by series, for sines of a graphics card may be wrong by a millionth, which is metres on the earth.
uniform vec3 u_origin;       // of the mesh, from the eye, in the scene's axes
uniform mat3 u_map_turn;     // from the scene's axes to east, north and up below the eye
uniform float u_map_eye;     // height of the eye
uniform vec2 u_map_latitude; // sine and cosine of the eye's
uniform vec3 u_map_earth;    // distance from the earth's axis; radius of the meridian's curve, and by what share it grows in a radian northward
uniform float u_map_radius;  // of the map's earth
uniform bool u_map_globe;    // whether the map is a globe, and no Mercator projection

float smallSine(float x) {
  float s = x * x;
  return x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0)));
}
float smallArctangent(float t) {
  float s = t * t;
  return abs(t) > 0.25 ? atan(t) : t * (1.0 - s * (1.0 / 3.0 - s * (0.2 - s * (1.0 / 7.0 - s / 9.0))));
}
float smallInverseTanh(float t) {
  float s = t * t;
  return abs(t) > 0.25 ? atanh(t) : t * (1.0 + s * (1.0 / 3.0 + s * (0.2 + s * (1.0 / 7.0 + s / 9.0))));
}

// Longitude and latitude from the eye's, radians, and height.
vec3 geodetic(vec3 p) {
  float s = u_map_latitude.x, c = u_map_latitude.y, out_m = p.z * c - p.y * s;
  float axis_m = u_map_earth.x + out_m, distance_m = length(vec2(p.x, axis_m));
  vec2 d = vec2(out_m + p.x * p.x / (distance_m + axis_m), p.z * s + p.y * c); // in the point's meridian: from the axis, and along it
  vec2 q = vec2(d.y * c - d.x * s, d.x * c + d.y * s);                         // there northward and up
  float up_m = u_map_earth.y + q.y;
  float north = smallArctangent(q.x / up_m);
  float height_m = q.y + q.x * q.x / (length(vec2(q.x, up_m)) + up_m);
  float growth_m = u_map_earth.y * u_map_earth.z * north * north;
  return vec3(smallArctangent(p.x / axis_m), north - 0.5 * growth_m / (u_map_earth.y + height_m), height_m - growth_m * north / 6.0);
}

// For a position of the mesh, the one by which the map's place comes out.
vec3 onMap(vec3 position) {
  vec3 p = u_map_turn * (position + u_origin) + vec3(0.0, 0.0, u_map_eye);
  vec3 g = geodetic(p);
  float s = u_map_latitude.x, c = u_map_latitude.y;
  float half_sine = smallSine(0.5 * g.y), half_cosine = sqrt(1.0 - half_sine * half_sine);
  float cosine = c * (1.0 - 2.0 * half_sine * half_sine) - s * 2.0 * half_sine * half_cosine; // of the latitude
  vec3 drawn;
  if (u_map_globe) {
    float east_sine = smallSine(0.5 * g.x), fall = 2.0 * east_sine * east_sine, from_middle = u_map_radius + g.z;
    drawn = vec3(from_middle * cosine * 2.0 * east_sine * sqrt(1.0 - east_sine * east_sine), from_middle * (2.0 * half_sine * half_cosine + cosine * s * fall),
                 g.z - from_middle * (2.0 * half_sine * half_sine + cosine * c * fall));
  } else {
    float middle_cosine = c * half_cosine - s * half_sine;
    drawn = vec3(u_map_radius * c * g.x, u_map_radius * c * 2.0 * smallInverseTanh(half_sine / middle_cosine), g.z * c / cosine);
  }
  return position + transpose(u_map_turn) * (drawn - p);
}
