// What is seen from a point, laid over the ground (draw/viewshed_drape.ts).
uniform sampler2D u_viewshed;   // of a cell: 0 hidden, 1 seen, 2 not known
uniform vec4 u_viewshed_place;  // the first cell's middle from the pivot; from cell to cell

// What is seen is green, what is hidden darker.
vec3 withViewshed(vec3 colour, vec2 lattice) {
  ivec2 cell = ivec2(floor((lattice - u_viewshed_place.xy) / u_viewshed_place.zw + 0.5));
  ivec2 size = textureSize(u_viewshed, 0);
  if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, size))) return colour;
  int what = int(255.0 * texelFetch(u_viewshed, cell, 0).r + 0.5);
  return what == 1 ? mix(colour, vec3(0.08, 0.75, 0.12), 0.5) : what == 0 ? 0.5 * colour : colour;
}
