// The colour of the ground: as it may look, by the picture that is laid over it, or by what is known of it.
in vec2 v_lattice;              // position on the lattice, from the pivot
#ifdef GLOBE
in vec4 v_chart_0;              // globe: position on a face from its pivot, the face, and 1 if the vertex lies on it; else zeros
in vec4 v_chart_1;
in vec4 v_chart_2;
in vec3 v_up;                   // away from the zero surface; of any length
in float v_undulation;          // how far the sea lies above the zero surface, metres
#endif
in vec3 v_normal;               // of the mesh, in the scene's axes
in vec4 v_texture_coordinate;   // from the mesh's origin; height
in float v_moved;               // metres upwards since the first epoch
uniform vec3 u_palette[6];    // from the lowest ground to the highest
uniform vec3 u_rock;
uniform vec3 u_snow;
uniform vec3 u_origin_tile;   // the mesh's origin, modulo a whole number of noise periods
uniform float u_noise_m;      // coarsest wavelength of the ground's mottling
uniform float u_contour_m;    // 0: none
uniform float u_snow_line;    // from 0, the lowest ground, to 1, the highest
uniform float u_change_m;     // that has the strongest colours
uniform int u_has_sea;        // globe: what is lower than the sea lies under water (1), or would if that were drawn (2)
uniform vec3 u_north;         // the earth's axis, or north on the map

// Position on the lattice, from the pivot; on a globe on the face that all corners of the triangle lie on, from the face's pivot.
vec2 latticeHere() {
#ifdef GLOBE
  vec3 off = abs(vec3(v_chart_0.w, v_chart_1.w, v_chart_2.w) - 1.0);
  vec4 chart = off.x <= min(off.y, off.z) ? v_chart_0 : off.y <= off.z ? v_chart_1 : v_chart_2;
  g_face = int(chart.z + 0.5);
  return chart.xy;
#else
  return v_lattice;
#endif
}

float hash(ivec2 p) {
  uint h = uint(p.x) * 0x9E3779B1u ^ uint(p.y) * 0x85EBCA77u;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  h = (h ^ (h >> 12)) * 0x297A2D39u;
  return float((h ^ (h >> 15)) & 0xFFFFu) / 65535.0;
}

float noise(vec2 p) {
  ivec2 cell = ivec2(floor(p)) & 1023;  // periodic, so that the origin's tile may be taken modulo the period
  ivec2 next = (cell + 1) & 1023;
  vec2 f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  float south = mix(hash(cell), hash(ivec2(next.x, cell.y)), f.x);
  float north = mix(hash(ivec2(cell.x, next.y)), hash(next), f.x);
  return mix(south, north, f.y) - 0.5;
}

// Mottling in [-0.5, 0.5]; octaves finer than about two pixels fade out.
float mottling(vec2 position, float pixel_m) {
  float sum = 0.0, amplitude = 0.5, wave_m = u_noise_m;
  for (int octave = 0; octave < 6; ++octave) {
    float visible = clamp(wave_m / (2.0 * pixel_m) - 1.0, 0.0, 1.0);
    if (visible == 0.0) break;
    sum += visible * amplitude * noise(position / wave_m);
    amplitude *= 0.64;
    wave_m *= 0.25;
  }
  return sum;
}

// On a globe by the planes that its axes stand on, mixed where they meet.
float mottlingHere(vec3 up, float pixel_m) {
  vec3 at = v_texture_coordinate.xyz + u_origin_tile;
  if (!IS_GLOBE) return mottling(at.xy, pixel_m);
  vec3 weights = up * up * up * up;
  weights *= weights;
  weights /= weights.x + weights.y + weights.z;
  float sum = 0.0;
  if (weights.x > 0.01) sum += weights.x * mottling(at.yz, pixel_m);
  if (weights.y > 0.01) sum += weights.y * mottling(at.zx, pixel_m);
  if (weights.z > 0.01) sum += weights.z * mottling(at.xy, pixel_m);
  return sum;
}

vec3 hypsometric(float t) {
  float at = clamp(t, 0.0, 1.0) * 5.0;
  int i = min(int(at), 4);
  return mix(u_palette[i], u_palette[i + 1], smoothstep(0.0, 1.0, at - float(i)));
}

float contour(float height) {
  float lines = height / u_contour_m;
  float width = fwidth(lines);
  float near_line = 0.5 - abs(fract(lines - 0.5) - 0.5);
  float strength = 1.0 - smoothstep(0.6 * width, 1.4 * width, near_line);
  float major = abs(mod(floor(lines + 0.5), 5.0)) < 0.5 ? 1.0 : 0.55;
  return strength * major * (1.0 - smoothstep(0.12, 0.4, width));
}

// Away from the zero surface, where the ground is.
vec3 upAt(vec2 lattice) {
#ifdef GLOBE
  return normalize(v_up);
#endif
  return u_is_geographic ? geographicNormal(vec2(0.0), lattice) : vec3(0.0, 0.0, 1.0);
}

vec3 slopeColour(float degrees) {
  const vec3 kColours[6] = vec3[](vec3(0.55, 0.66, 0.50), vec3(0.78, 0.76, 0.42), vec3(0.87, 0.56, 0.22), vec3(0.78, 0.22, 0.13),
                                  vec3(0.45, 0.09, 0.25), vec3(0.20, 0.07, 0.32));
  float at = clamp(degrees / 10.0, 0.0, 5.0);
  int i = min(int(at), 4);
  return 0.5 * mix(kColours[i], kColours[i + 1], at - float(i));
}

// By where the ground falls to, around the compass: north blue, east green, south yellow, west red; grey where it is level.
vec3 aspectColour(vec3 normal, vec3 up) {
  vec3 east = normalize(cross(u_north, up)), north = cross(up, east);
  vec2 fall = vec2(dot(normal, east), dot(normal, north));
  float steep = length(fall);
  vec3 north_south = mix(vec3(0.48, 0.42, 0.10), vec3(0.09, 0.18, 0.42), 0.5 + 0.5 * fall.y / max(steep, 1e-6));
  vec3 east_west = mix(vec3(0.42, 0.11, 0.10), vec3(0.09, 0.33, 0.18), 0.5 + 0.5 * fall.x / max(steep, 1e-6));
  float share = fall.x * fall.x / max(steep * steep, 1e-12);
  return mix(vec3(0.30), mix(north_south, east_west, share), smoothstep(0.02, 0.12, steep));
}

// From what has sunk, blue, to what has risen, red.
vec3 changeColour(float share) {
  const vec3 kColours[7] = vec3[](vec3(0.015, 0.133, 0.413), vec3(0.136, 0.397, 0.624), vec3(0.638, 0.783, 0.871), vec3(0.93),
                                  vec3(0.982, 0.708, 0.571), vec3(0.863, 0.254, 0.122), vec3(0.445, 0.009, 0.024));
  float at = clamp(3.0 * share + 3.0, 0.0, 6.0);
  int i = min(int(at), 5);
  return 0.5 * mix(kColours[i], kColours[i + 1], at - float(i));
}

vec3 groundColour(vec3 normal, float height, float pixel_m) {
#ifdef GLOBE
  vec3 up = normalize(v_up);
  if (u_has_sea > 0 && height < v_undulation) return u_has_sea == 1 ? seaColour(v_undulation - height) : floorColour(v_undulation - height);
#else
  vec3 up = u_up;
#endif
  float span = max(u_heights.y - u_heights.x, 1e-3);
  float mottle = mottlingHere(up, pixel_m);
  float t = (height - u_heights.x) / span;
  float steepness = 1.0 - dot(normal, up);
  vec3 colour = hypsometric(t + 0.16 * mottle) * (1.0 + 0.55 * mottle);
  float strata = 0.10 * sin(height / span * 190.0 + 6.0 * mottle) * clamp(span / (400.0 * pixel_m), 0.0, 1.0);
  vec3 rock = u_rock * (1.0 + 0.5 * mottle + strata);
  colour = mix(colour, rock, smoothstep(0.20, 0.42, steepness + 0.12 * mottle));
  float snow = smoothstep(u_snow_line - 0.05, u_snow_line + 0.05, t + 0.14 * mottle) * (1.0 - smoothstep(0.26, 0.44, steepness + 0.12 * mottle));
  return mix(colour, u_snow, snow);
}

vec3 albedoOf(vec3 normal, float height, float pixel_m, vec2 dx, vec2 dy) {
  if (u_ground == 1) return vec3(0.24);
  vec2 lattice = latticeHere();
  if (u_ground == 2) return slopeColour(degrees(acos(clamp(dot(normal, upAt(lattice)), 0.0, 1.0))));
  if (u_ground == 3) return aspectColour(normal, upAt(lattice));
  if (u_ground == 4) return tintAt(height);
  if (u_ground == 5) return changeColour(v_moved / u_change_m);
  vec4 picture = pictureAt(lattice, dx, dy);
  return picture.a < 1.0 ? mix(groundColour(normal, height, pixel_m), picture.rgb, picture.a) : picture.rgb;
}

// The colour with contour lines over it, if there are some.
vec3 withContours(vec3 colour, float height) {
  return u_contour_m > 0.0 ? mix(colour, vec3(0.06, 0.045, 0.03), 0.55 * contour(height)) : colour;
}
