// Lines and areas drawn into the ground itself (overlay/ground_grid.ts), by where a pixel lies on the lattice: so they neither float nor
// sink, whatever the section is. Colours are those of the screen, as styles mean them: neither light nor haze changes them.
uniform highp usampler2D u_overlay_cells;  // first item and count
uniform highp usampler2D u_overlay_items;
uniform highp sampler2D u_overlay_segments;
uniform highp sampler2D u_overlay_styles;
uniform vec4 u_overlay_place;        // the grid's origin from the pivot; the finest cell's side; levels, 0 if there is nothing
uniform ivec3 u_overlay_levels[16];  // columns, rows, first cell
uniform float u_overlay_width_px;    // half of the widest line, and a pixel

const int kOverlayRow = 2048;  // texels in a row of these textures
const int kOverlayMost = 1024;  // items that a pixel looks at
ivec2 overlayTexel(int i) {
  return ivec2(i % kOverlayRow, i / kOverlayRow);
}

// A cell of the level whose reach covers half a line's width here; -1 beyond the grid.
int overlayCell(vec2 at, float reach, out vec2 middle) {
  int level = clamp(int(ceil(log2(max(reach / (0.5 * u_overlay_place.z), 1.0)))), 0, int(u_overlay_place.w) - 1);
  float side = u_overlay_place.z * exp2(float(level));
  ivec3 grid = u_overlay_levels[level];
  vec2 cell = floor(at / side);
  if (any(lessThan(at, vec2(-reach))) || any(greaterThan(at, vec2(grid.xy) * side + reach))) return -1;
  ivec2 inside = clamp(ivec2(cell), ivec2(0), grid.xy - 1);
  middle = (vec2(inside) + 0.5) * side;
  return grid.z + inside.y * grid.x + inside.x;
}

// Whether a segment crosses the way from one point to another.
bool overlayCrosses(vec4 segment, vec2 from, vec2 to) {
  vec2 way = to - from, edge = segment.zw - segment.xy;
  float side_a = way.x * (segment.y - from.y) - way.y * (segment.x - from.x), side_b = way.x * (segment.w - from.y) - way.y * (segment.z - from.x);
  float side_from = edge.x * (from.y - segment.y) - edge.y * (from.x - segment.x), side_to = edge.x * (to.y - segment.y) - edge.y * (to.x - segment.x);
  return (side_a < 0.0) != (side_b < 0.0) && (side_from < 0.0) != (side_to < 0.0);
}

vec3 overlayDrawn(vec3 colour, int shape, bool is_inside, float nearest_px) {
  vec4 stroke = texelFetch(u_overlay_styles, overlayTexel(3 * shape), 0), fill = texelFetch(u_overlay_styles, overlayTexel(3 * shape + 1), 0);
  vec4 more = texelFetch(u_overlay_styles, overlayTexel(3 * shape + 2), 0);
  if (is_inside) colour = mix(colour, fill.rgb, fill.a);
  return mix(colour, stroke.rgb, stroke.a * clamp(0.5 * more.x + 0.5 - nearest_px, 0.0, 1.0) * step(1e-3, more.x));
}

// Over what the screen would show. `dx` and `dy` are the lattice from a pixel to the next ones.
vec3 withOverlay(vec3 colour, vec2 lattice, vec2 dx, vec2 dy) {
  if (u_overlay_place.w < 1.0) return colour;
  vec2 at = lattice - u_overlay_place.xy, middle;
  int cell = overlayCell(at, u_overlay_width_px * max(length(dx), length(dy)), middle);
  if (cell < 0) return colour;
  uvec2 range = texelFetch(u_overlay_cells, overlayTexel(cell), 0).rg;
  float det = dx.x * dy.y - dx.y * dy.x;
  mat2 to_px = abs(det) > 0.0 ? mat2(dy.y, -dx.y, -dy.x, dx.x) / det : mat2(0.0);
  int shape = -1;
  bool is_inside = false;
  float nearest_px = 1e9;
  for (int i = 0; i < min(int(range.y), kOverlayMost); ++i) {
    uint item = texelFetch(u_overlay_items, overlayTexel(int(range.x) + i), 0).r;
    int kind = int(item >> 30), index = int(item & 0x3fffffffu);
    if (kind == 0) {
      if (shape >= 0) colour = overlayDrawn(colour, shape, is_inside, nearest_px);
      shape = index;
      is_inside = false;
      nearest_px = 1e9;
    } else if (kind == 1) {
      is_inside = !is_inside;
    } else {
      vec4 segment = texelFetch(u_overlay_segments, overlayTexel(index), 0);
      bool is_area = texelFetch(u_overlay_styles, overlayTexel(3 * shape + 2), 0).y > 0.5;
      if (is_area && overlayCrosses(segment, middle, at)) is_inside = !is_inside;
      vec2 a = to_px * (segment.xy - at), along = to_px * (segment.zw - at) - a;
      float t = clamp(-dot(a, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
      nearest_px = min(nearest_px, length(a + t * along));
    }
  }
  return shape >= 0 ? overlayDrawn(colour, shape, is_inside, nearest_px) : colour;
}
