// Tiles of relief and imagery (client/imagery/residency.h). A page table names the tile at each position in each level; the finest that
// is drawn, but none finer than wanted, gives the texel. While a tile comes or goes its image is mixed with the half-size one, which is
// its parent's.
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

int g_face = 0;  // globe: the face that is drawn

// Where the page table has a page (client/imagery/residency.h), whose x on a globe counts from the face's first one.
ivec2 slotOf(ivec2 page, int bits) {
  if (IS_GLOBE) page += ivec2((g_face % 3 == 1 ? kPageSide / 2 : 0) + (bits < 4 ? g_face / 3 << bits : 0), g_face % 3 == 2 ? kPageSide / 2 : 0);
  return page & (kPageSide - 1);
}

// The tile for a position, in texels of the finest level from the pivot. `wanted` is the level whose texels are a pixel large.
Texel findTexel(highp usampler2D pages, int levels, ivec2 size, ivec2 pivot, vec2 from_pivot, float wanted) {
  for (int level = clamp(int(floor(wanted)), 0, levels - 1); level < levels; ++level) {
    ivec2 corner = pivot >> level;
    vec2 from_corner = (vec2(pivot - (corner << level)) + from_pivot) / float(1 << level);
    ivec2 pivot_page = corner / int(kPayload);
    vec2 in_page = vec2(corner - pivot_page * int(kPayload)) + from_corner;
    vec2 pages_off = floor(in_page / kPayload);
    int bits = levels - 1 - level;
    // A face ends at its side, to the bit or not.
    if (IS_GLOBE) pages_off = clamp(pages_off, vec2(-pivot_page), vec2((((size - 1) >> level) / int(kPayload)) - pivot_page));
    in_page -= pages_off * kPayload;
    ivec2 page = pivot_page + ivec2(pages_off), slot = slotOf(page, bits);
    if (IS_GLOBE) page.x += g_face << bits;
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
uniform vec4 u_relief_pivots[6];  // globe: both, of each face
uniform float u_relief_density;  // texels a sample interval
uniform vec2 u_relief_size;      // texels

uniform highp sampler2DArray u_imagery;
uniform highp usampler2D u_imagery_pages;
uniform int u_imagery_levels;
uniform vec2 u_imagery_pivot;
uniform vec2 u_imagery_rest;
uniform vec4 u_imagery_pivots[6];
uniform float u_imagery_density;
uniform vec2 u_imagery_size;

uniform vec4 u_gradient;  // planar: what slopes along the lattice's x (xy) and y (zw) add to the gradient
uniform vec2 u_geodetic;  // longitude from the origin's meridian, and latitude, of the pivot
uniform vec2 u_geodetic_step;
uniform float u_origin_latitude;
uniform float u_face_steps; // globe: lattice steps a side of a face
uniform vec2 u_pivots[6];   // globe: where on each face positions count from
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

// By the lattice's axes at a place of a face (proto/space/cube_map.h).
vec3 globeNormal(vec2 slopes, vec2 lattice) {
  const vec3 kEast[6] = vec3[](vec3(0, 1, 0), vec3(-1, 0, 0), vec3(-1, 0, 0), vec3(0, 0, -1), vec3(0, 0, -1), vec3(0, 1, 0));
  const vec3 kNorth[6] = vec3[](vec3(0, 0, 1), vec3(0, 0, 1), vec3(0, -1, 0), vec3(0, -1, 0), vec3(1, 0, 0), vec3(1, 0, 0));
  const float kFirst = 0.78539816, kThird = 0.1615, kFifth = 1.0 - kFirst - kThird;
  vec2 s = (u_pivots[g_face] + lattice) * (2.0 / u_face_steps) - 1.0, s2 = s * s;
  vec2 tangent = s * (kFirst + s2 * (kThird + s2 * kFifth)), growth = (kFirst + s2 * (3.0 * kThird + s2 * 5.0 * kFifth)) * (2.0 / u_face_steps);
  vec3 east = kEast[g_face], north = kNorth[g_face], m = cross(east, north) + tangent.x * east + tangent.y * north;
  vec3 squash = vec3(1.0, 1.0, 1.0 - u_ellipsoid.y), squashed = squash * m;
  float w2 = dot(m, squashed), w = sqrt(w2);
  vec3 x = (squash * east - squashed * (dot(squashed, east) / w2)) * (u_ellipsoid.x * growth.x / w);
  vec3 y = (squash * north - squashed * (dot(squashed, north) / w2)) * (u_ellipsoid.x * growth.y / w);
  vec3 up = normalize(m);
  return normalize(cross(x + slopes.x * up, y + slopes.y * up));
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
  vec4 pivot = IS_GLOBE ? u_relief_pivots[g_face] : vec4(u_relief_pivot, u_relief_rest);
  Texel texel = findTexel(u_relief_pages, u_relief_levels, ivec2(u_relief_size), ivec2(pivot.xy), pivot.zw + lattice * u_relief_density, wanted);
  if (texel.opacity == 0.0) return ground;
  vec2 slopes = textureLod(u_relief, texel.at, texel.lod).xy;
  vec3 normal = IS_GLOBE ? globeNormal(slopes, lattice) : u_is_geographic ? geographicNormal(slopes, lattice) : planarNormal(slopes);
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
  vec4 pivot = IS_GLOBE ? u_imagery_pivots[g_face] : vec4(u_imagery_pivot, u_imagery_rest);
  vec2 from_pivot = pivot.zw + lattice * u_imagery_density;
  vec2 at = pivot.xy + from_pivot;
  if (!IS_GLOBE && (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, u_imagery_size)))) return vec4(0.0);
  float wanted = levelOf(dx * u_imagery_density, dy * u_imagery_density);
  Texel texel = findTexel(u_imagery_pages, u_imagery_levels, ivec2(u_imagery_size), ivec2(pivot.xy), from_pivot, wanted);
  if (texel.opacity == 0.0) return vec4(0.0);
  vec4 colour = imageAt(u_imagery, texel, dx * u_imagery_density, dy * u_imagery_density);
  return vec4(colour.rgb, colour.a * texel.opacity);
}
