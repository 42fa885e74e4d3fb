// The page's shaders. Distances are metres relative to the eye, along the scene's axes, so floats keep their precision far
// from the scene's origin. Colours are linear until the last line.

// How ground is coloured: as it may look, or by the picture that is laid over it; in one colour; by how steep it is, and where it falls to;
// by its height, with a colour map; and by how far it has moved since the first epoch.
export const kGrounds = ['natural', 'plain', 'slope', 'aspect', 'heights', 'change'] as const;
export type Ground = (typeof kGrounds)[number];

const kHead = /* glsl */ `
precision highp float;
precision highp int;
`;

// Sky, haze and the way to the screen, shared so that distant ground fades into the very sky behind it.
const kAtmosphere = /* glsl */ `
uniform vec3 u_sun;  // towards the sun
uniform vec3 u_up;   // away from the zero surface, at the eye

// Of the sky's light: 1 by day.
float daylight() {
  return mix(0.03, 1.0, smoothstep(-0.25, 0.12, dot(u_sun, u_up)));
}

// White by day, red when the sun is low, black when it has set.
vec3 sunColour() {
  float height = dot(u_sun, u_up);
  return mix(vec3(2.30, 1.05, 0.42), vec3(2.15, 1.92, 1.56), smoothstep(0.0, 0.30, height)) * smoothstep(-0.05, 0.03, height);
}

vec3 hazeColour(vec3 direction) {
  float towards_sun = max(dot(direction, u_sun), 0.0);
  float is_low = 1.0 - smoothstep(0.0, 0.30, dot(u_sun, u_up));
  vec3 glow = mix(vec3(0.95, 0.80, 0.60), vec3(1.15, 0.52, 0.24), is_low);
  return daylight() * mix(vec3(0.36, 0.50, 0.68), glow, (0.50 + 0.3 * is_low) * pow(towards_sun, 6.0 - 3.0 * is_low));
}

vec3 skyColour(vec3 direction) {
  float height = dot(direction, u_up);
  vec3 haze = hazeColour(direction);
  vec3 colour = mix(haze, daylight() * vec3(0.030, 0.105, 0.310), 1.0 - exp(-5.5 * max(height, 0.0)));
  colour = mix(colour, haze * 0.72, smoothstep(0.0, -0.4, height));
  float towards_sun = max(dot(direction, u_sun), 0.0);
  colour += daylight() * vec3(1.0, 0.80, 0.55) * (0.10 * pow(towards_sun, 24.0) + 0.35 * pow(towards_sun, 350.0));
  return colour + (vec3(9.0, 8.0, 6.0) / vec3(2.15, 1.92, 1.56)) * sunColour() * smoothstep(0.99985, 0.99993, towards_sun);
}

// Filmic curve (Narkowicz's fit of ACES), then sRGB.
vec3 toScreen(vec3 colour) {
  vec3 x = colour * 0.80;
  x = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
  return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), x));
}
`;

// A frame between two keyframes: mix of two positions with one weight (THEORY section 2). Of more keyframes, a way that bends
// (BlendMesh::from_bends).
const kInterpolation = /* glsl */ `
in vec4 from_position;  // metres from the mesh's origin; w: height above the zero surface
in vec4 to_position;
in vec3 from_bend;      // metres; 0 if the mesh has none
in vec3 to_bend;
in vec3 from_normal;
in vec3 to_normal;
uniform float u_weight;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform vec3 u_origin;  // of the mesh, from the eye

vec4 blended() {
  vec4 p = mix(from_position, to_position, u_weight);
  p.xyz += u_weight * (1.0 - u_weight) * mix(from_bend, to_bend, u_weight);
  return p;
}
`;

export const kTerrainVertex = kHead + kInterpolation + /* glsl */ `
in vec2 texture_coordinate;  // position on the lattice
in float from_moved;         // metres upwards since the first epoch
in float to_moved;
uniform vec2 u_pivot;        // a whole position near the eye
out vec2 v_lattice;          // from the pivot
out float v_moved;
out vec3 v_from_eye;
out vec3 v_normal;
out vec3 v_texture_coordinate;  // x, y from the mesh's origin; height
void main() {
  vec4 p = blended();
  v_from_eye = p.xyz + u_origin;
  v_normal = mix(from_normal, to_normal, u_weight);
  v_texture_coordinate = vec3(p.xy, p.w);
  v_lattice = texture_coordinate - u_pivot;
  v_moved = mix(from_moved, to_moved, u_weight);
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(p.xyz, 1.0));
}
`;

// Light on whatever stands in the scene, and the haze before it.
const kLight = /* glsl */ `
in vec3 v_from_eye;
uniform vec2 u_heights;       // lowest, highest ground
uniform float u_haze;         // optical depth per metre at the lowest ground; 0: none
uniform float u_haze_height;  // over which it falls to 1 / e
uniform float u_eye_height;

// \`sunshine\`: the share of the sun that is seen.
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
`;

// Tiles of relief and imagery (client/imagery/residency.h). A page table names the tile at each position in each level; the finest that
// is drawn, but none finer than wanted, gives the texel. While a tile comes or goes its image is mixed with the half-size one, which is
// its parent's.
const kTiles = /* glsl */ `
const int kPageSide = 32;
const float kPayload = 248.0;
uniform float u_weight;
uniform float u_anisotropy;  // at most so many reads along the longer axis; 1: by the level alone, as software does it faster

struct Texel {
  vec3 at;        // in the texture array
  float lod;      // 0: the tile's image; 1: the half-size one
  float fade;     // the least of it
  int tile_level;
  float opacity;  // 0: there is none
};

// The tile for a position, in texels of the finest level from the pivot. \`wanted\` is the level whose texels are a pixel large.
Texel findTexel(highp usampler2D pages, int levels, ivec2 pivot, vec2 from_pivot, float wanted) {
  for (int level = clamp(int(floor(wanted)), 0, levels - 1); level < levels; ++level) {
    ivec2 corner = pivot >> level;
    vec2 from_corner = (vec2(pivot - (corner << level)) + from_pivot) / float(1 << level);
    ivec2 pivot_page = corner / int(kPayload);
    vec2 in_page = vec2(corner - pivot_page * int(kPayload)) + from_corner;
    vec2 pages_off = floor(in_page / kPayload);
    in_page -= pages_off * kPayload;
    ivec2 page = pivot_page + ivec2(pages_off);
    ivec2 slot = page & (kPageSide - 1);
    uvec4 entry = texelFetch(pages, ivec2(slot.x, slot.y + level * kPageSide), 0);
    if (entry.z == 0u || ivec2(entry.xy) != page / kPageSide) continue;
    float fade = entry.w == 1u ? 1.0 - u_weight : entry.w == 2u ? u_weight : 0.0;
    float lod = clamp(max(wanted - float(level), fade), 0.0, 1.0);
    float opacity = level == levels - 1 && entry.w > 0u ? 1.0 - fade : 1.0;
    return Texel(vec3((in_page + 4.0) / 256.0, float(entry.z) - 1.0), lod, fade, level, opacity);
  }
  return Texel(vec3(0.0), 0.0, 0.0, 0, 0.0);
}

// What a pixel sees of a tile's image, given how a position in texels of the finest level changes from pixel to pixel: along the longer
// axis by several reads, where that is cheap. What is seen is enlarged until its shorter axis asks for the least level of detail.
vec4 imageAt(highp sampler2DArray images, Texel texel, vec2 dx, vec2 dy) {
  if (u_anisotropy <= 1.0) return textureLod(images, texel.at, texel.lod);
  dx /= float(1 << texel.tile_level), dy /= float(1 << texel.tile_level);
  float longer = sqrt(max(dot(dx, dx), dot(dy, dy)));
  float shorter = max(abs(dx.x * dy.y - dx.y * dy.x) / max(longer, 1e-9), longer / u_anisotropy);
  float enlarged = texel.fade > 0.0 ? max(1.0, exp2(texel.fade) / max(shorter, 1e-9)) : 1.0;
  return textureGrad(images, texel.at, dx * (enlarged / 256.0), dy * (enlarged / 256.0));
}

// The level whose texels are a pixel large, given how a position in texels of the finest level changes from pixel to pixel: by area,
// but no finer than a quarter of what the longer axis asks for.
float levelOf(vec2 dx, vec2 dy) {
  float longer = max(dot(dx, dx), dot(dy, dy));
  float area = abs(dx.x * dy.y - dx.y * dy.x);
  return 0.5 * log2(max(max(area, longer / 16.0), 1e-12));
}

uniform highp sampler2DArray u_relief;  // slopes: metres a sample interval
uniform highp sampler2DArray u_relief_ground;  // two numbers of 16 bits: the height, and below which height there is shadow
uniform vec2 u_relief_code;      // metres: the height of code 0, and from code to code
uniform float u_relief_texel_m;  // of the finest level
uniform int u_shadows;           // whether there are some
uniform highp usampler2D u_relief_pages;
uniform int u_relief_levels;     // 0: none
uniform vec2 u_relief_pivot;     // the pivot in texels of the finest level: whole, and the rest
uniform vec2 u_relief_rest;
uniform float u_relief_density;  // texels a sample interval
uniform vec2 u_relief_size;      // texels

uniform highp sampler2DArray u_imagery;
uniform highp usampler2D u_imagery_pages;
uniform int u_imagery_levels;
uniform vec2 u_imagery_pivot;
uniform vec2 u_imagery_rest;
uniform float u_imagery_density;
uniform vec2 u_imagery_size;

uniform vec4 u_gradient;  // planar: what slopes along the lattice's x (xy) and y (zw) add to the gradient
uniform int u_is_geographic;
uniform vec2 u_geodetic;  // longitude from the origin's meridian, and latitude, of the pivot
uniform vec2 u_geodetic_step;
uniform float u_origin_latitude;
uniform vec2 u_ellipsoid;  // semi-major axis, metres; eccentricity squared

vec3 planarNormal(vec2 slopes) {
  return normalize(vec3(-u_gradient.xy * slopes.x - u_gradient.zw * slopes.y, 1.0));
}

vec3 geographicNormal(vec2 slopes, vec2 lattice) {
  vec2 at = u_geodetic + lattice * u_geodetic_step;
  vec2 s = sin(at), c = cos(at);
  float w2 = 1.0 - u_ellipsoid.y * s.y * s.y;
  float across_m = u_ellipsoid.x / sqrt(w2);
  float along_m = across_m * (1.0 - u_ellipsoid.y) / w2;
  vec2 slope = slopes / (u_geodetic_step * vec2(across_m * max(c.y, 1e-4), along_m));
  vec3 east = vec3(-s.x, c.x, 0.0), north = vec3(-s.y * c.x, -s.y * s.x, c.y), up = vec3(c.y * c.x, c.y * s.x, s.y);
  vec3 n = normalize(up - slope.x * east - slope.y * north);
  float s0 = sin(u_origin_latitude), c0 = cos(u_origin_latitude);
  return vec3(n.y, c0 * n.z - s0 * n.x, s0 * n.z + c0 * n.x);
}

struct Ground {
  vec3 normal;
  float height;
  float sunshine;  // 0: in shadow
};

// The ground by relief, where there is some, and as the mesh has it elsewhere. The edge of a shadow is half a texel wide.
Ground groundAt(vec3 mesh_normal, float mesh_height, vec2 lattice, vec2 dx, vec2 dy) {
  Ground ground = Ground(mesh_normal, mesh_height, 1.0);
  if (u_relief_levels == 0) return ground;
  float wanted = levelOf(dx * u_relief_density, dy * u_relief_density);
  Texel texel = findTexel(u_relief_pages, u_relief_levels, ivec2(u_relief_pivot), u_relief_rest + lattice * u_relief_density, wanted);
  if (texel.opacity == 0.0) return ground;
  vec2 slopes = textureLod(u_relief, texel.at, texel.lod).xy;
  vec3 normal = u_is_geographic == 1 ? geographicNormal(slopes, lattice) : planarNormal(slopes);
  vec4 bytes = textureLod(u_relief_ground, texel.at, texel.lod) * 255.0;
  vec2 heights = u_relief_code.x + u_relief_code.y * vec2(bytes.x + 256.0 * bytes.y, bytes.z + 256.0 * bytes.w);
  ground.normal = normalize(mix(mesh_normal, normal, texel.opacity));
  ground.height = mix(mesh_height, heights.x, texel.opacity);
  if (u_shadows == 1) {
    float sine = clamp(dot(u_sun, u_up), 0.02, 0.999);
    float soft_m = 0.5 * u_relief_texel_m * exp2(float(texel.tile_level) + texel.lod) * sine / sqrt(1.0 - sine * sine);
    ground.sunshine = 1.0 - texel.opacity * smoothstep(0.0, soft_m, heights.y - heights.x);
  }
  return ground;
}

uniform int u_ground;  // of kGrounds
uniform sampler2D u_tints;  // over a range of heights
uniform vec2 u_tint_range;

vec3 tintAt(float height) {
  return 0.6 * texture(u_tints, vec2((height - u_tint_range.x) / (u_tint_range.y - u_tint_range.x), 0.5)).rgb;
}

// Of the picture, linear; its alpha is 0 where there is none.
vec4 pictureAt(vec2 lattice, vec2 dx, vec2 dy) {
  if (u_imagery_levels == 0) return vec4(0.0);
  vec2 from_pivot = u_imagery_rest + lattice * u_imagery_density;
  vec2 at = u_imagery_pivot + from_pivot;
  if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, u_imagery_size))) return vec4(0.0);
  float wanted = levelOf(dx * u_imagery_density, dy * u_imagery_density);
  Texel texel = findTexel(u_imagery_pages, u_imagery_levels, ivec2(u_imagery_pivot), from_pivot, wanted);
  if (texel.opacity == 0.0) return vec4(0.0);
  vec4 colour = imageAt(u_imagery, texel, dx * u_imagery_density, dy * u_imagery_density);
  return vec4(colour.rgb, colour.a * texel.opacity);
}
`;

export const kTerrainFragment = kHead + kAtmosphere + kLight + kTiles + /* glsl */ `
in vec2 v_lattice;
in vec3 v_normal;
in vec3 v_texture_coordinate;
in float v_moved;
out vec4 o_colour;

uniform vec3 u_palette[6];    // from the lowest ground to the highest
uniform vec3 u_rock;
uniform vec3 u_snow;
uniform vec2 u_origin_tile;   // the mesh's origin, modulo a whole number of noise periods
uniform float u_noise_m;      // coarsest wavelength of the ground's mottling
uniform float u_contour_m;    // 0: none
uniform float u_snow_line;    // from 0, the lowest ground, to 1, the highest
uniform float u_change_m;     // that has the strongest colours
uniform vec3 u_north;         // the earth's axis, or north on the map
uniform float u_pixel_rad;    // how much a pixel sees

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
  return u_is_geographic == 1 ? geographicNormal(vec2(0.0), lattice) : vec3(0.0, 0.0, 1.0);
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
  float span = max(u_heights.y - u_heights.x, 1e-3);
  float mottle = mottling(v_texture_coordinate.xy + u_origin_tile, pixel_m);
  float t = (height - u_heights.x) / span;
  float steepness = 1.0 - dot(normal, u_up);
  vec3 colour = hypsometric(t + 0.16 * mottle) * (1.0 + 0.55 * mottle);
  float strata = 0.10 * sin(height / span * 190.0 + 6.0 * mottle) * clamp(span / (400.0 * pixel_m), 0.0, 1.0);
  vec3 rock = u_rock * (1.0 + 0.5 * mottle + strata);
  colour = mix(colour, rock, smoothstep(0.20, 0.42, steepness + 0.12 * mottle));
  float snow = smoothstep(u_snow_line - 0.05, u_snow_line + 0.05, t + 0.14 * mottle) * (1.0 - smoothstep(0.26, 0.44, steepness + 0.12 * mottle));
  return mix(colour, u_snow, snow);
}

vec3 albedoOf(vec3 normal, float height, float pixel_m, vec2 dx, vec2 dy) {
  if (u_ground == 1) return vec3(0.24);
  if (u_ground == 2) return slopeColour(degrees(acos(clamp(dot(normal, upAt(v_lattice)), 0.0, 1.0))));
  if (u_ground == 3) return aspectColour(normal, upAt(v_lattice));
  if (u_ground == 4) return tintAt(height);
  if (u_ground == 5) return changeColour(v_moved / u_change_m);
  vec4 picture = pictureAt(v_lattice, dx, dy);
  return picture.a < 1.0 ? mix(groundColour(normal, height, pixel_m), picture.rgb, picture.a) : picture.rgb;
}

void main() {
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m;
  vec2 dx = dFdx(v_lattice), dy = dFdy(v_lattice);
  Ground ground = groundAt(normalize(v_normal), v_texture_coordinate.z, v_lattice, dx, dy);
  float facing = max(-dot(ground.normal, direction), 0.12);
  float pixel_m = max(distance_m * u_pixel_rad / sqrt(facing), 1e-4);
  vec3 colour = lit(albedoOf(ground.normal, ground.height, pixel_m, dx, dy), ground.normal, ground.sunshine);
  if (u_contour_m > 0.0) colour = mix(colour, vec3(0.06, 0.045, 0.03), 0.55 * contour(ground.height));
  if (u_haze > 0.0) colour = mix(hazeColour(direction), colour, exp(-hazeAlong(distance_m)));
  o_colour = vec4(toScreen(colour), 1.0);
}
`;

// The light on the ground at given positions (draw/shade_probe.ts).
export const kProbeVertex = kHead + /* glsl */ `
in vec3 position;  // where it is drawn, and the position on the lattice
uniform vec2 u_pivot;
out vec2 v_lattice;
void main() {
  v_lattice = position.yz - u_pivot;
  gl_Position = vec4(position.x, 0.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}
`;

export const kProbeFragment = kHead + kAtmosphere + kLight.replace('in vec3 v_from_eye;', 'const vec3 v_from_eye = vec3(0.0);') + kTiles + /* glsl */ `
in vec2 v_lattice;
uniform float u_footprint;  // sample intervals of a pixel
out vec4 o_colour;
void main() {
  Ground ground = groundAt(vec3(0.0), 0.0, v_lattice, vec2(u_footprint, 0.0), vec2(0.0, u_footprint));
  o_colour = vec4(toScreen(lit(u_ground == 4 ? tintAt(ground.height) : vec3(0.24), ground.normal, ground.sunshine)), 1.0);
}
`;

export const kObjectVertex = kHead + kInterpolation + /* glsl */ `
in vec2 texture_coordinate;  // in the model's image
out vec3 v_from_eye;
out vec3 v_normal;
out vec2 v_texture_coordinate;
void main() {
  vec4 p = blended();
  v_from_eye = p.xyz + u_origin;
  v_normal = mix(from_normal, to_normal, u_weight);
  v_texture_coordinate = texture_coordinate;
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(p.xyz, 1.0));
}
`;

export const kObjectFragment = kHead + kAtmosphere + kLight + /* glsl */ `
in vec3 v_normal;
in vec2 v_texture_coordinate;
uniform sampler2D u_image;  // sRGB
out vec4 o_colour;
void main() {
  float distance_m = length(v_from_eye);
  vec3 direction = v_from_eye / distance_m;
  vec3 colour = lit(pow(texture(u_image, v_texture_coordinate).rgb, vec3(2.2)), normalize(v_normal), 1.0);
  if (u_haze > 0.0) colour = mix(hazeColour(direction), colour, exp(-hazeAlong(distance_m)));
  o_colour = vec4(toScreen(colour), 1.0);
}
`;

export const kWireVertex = kHead + kInterpolation + /* glsl */ `
uniform vec3 u_up;
out float v_distance;
void main() {
  vec4 p = blended();
  vec4 view = modelViewMatrix * vec4(p.xyz, 1.0);
  v_distance = length(p.xyz + u_origin);
  gl_Position = projectionMatrix * vec4(view.xyz * 0.9995, 1.0);  // a hair nearer than the surface
}
`;

export const kWireFragment = kHead + /* glsl */ `
in float v_distance;
uniform float u_far;
out vec4 o_colour;
void main() {
  o_colour = vec4(0.04, 0.07, 0.10, 0.50 * exp(-2.5 * v_distance / u_far));
}
`;

export const kSkyVertex = kHead + /* glsl */ `
in vec3 position;
uniform mat4 u_directions;  // from the far plane's corners to directions in the scene
out vec3 v_direction;
void main() {
  vec4 far = u_directions * vec4(position.xy, 1.0, 1.0);
  v_direction = far.xyz / far.w;
  gl_Position = vec4(position.xy, 1.0, 1.0);
}
`;

export const kSkyFragment = kHead + kAtmosphere + /* glsl */ `
in vec3 v_direction;
out vec4 o_colour;
void main() {
  o_colour = vec4(toScreen(skyColour(normalize(v_direction))), 1.0);
}
`;
