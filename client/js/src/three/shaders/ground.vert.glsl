in vec2 texture_coordinate;  // position on the lattice
in float from_moved;         // metres upwards since the first epoch
in float to_moved;
uniform vec3 u_from_middle;  // globe: of the mesh's origin
uniform float u_round;       // globe: by which the axis is stretched, so that normals of its ellipsoid are those of a ball
uniform vec2 u_pivot;        // a whole position near the eye
uniform float u_face_steps;  // globe: lattice steps a side of a face
uniform vec2 u_pivots[6];    // globe: of each face a whole position near the eye
out vec2 v_lattice;          // from the pivot
#ifdef GLOBE
out vec4 v_chart_0;          // globe: see latticeHere()
out vec4 v_chart_1;
out vec4 v_chart_2;
out vec3 v_up;               // away from the zero surface; of any length
out float v_undulation;      // how far the sea lies above the zero surface, metres
uniform highp sampler2D u_undulations;  // metres, on meridians and parallels, row by row from the south
uniform vec4 u_undulation_place;        // longitude and latitude of the first, radians; values to a radian, 0 if there are none

// Bilinear. Between vertices it is linear: geoids bend by a few hundredths of what the body does, so little of a triangle's error.
float undulationAt(vec3 up) {
  vec2 at = (vec2(atan(up.y, up.x), atan(up.z, length(up.xy))) - u_undulation_place.xy) * u_undulation_place.zw;
  ivec2 last = textureSize(u_undulations, 0) - 1;
  at = clamp(at, vec2(0.0), vec2(last));
  ivec2 low = ivec2(at), high = min(low + 1, last);
  vec2 share = at - vec2(low);
  vec4 n = vec4(texelFetch(u_undulations, low, 0).r, texelFetch(u_undulations, ivec2(high.x, low.y), 0).r, texelFetch(u_undulations, ivec2(low.x, high.y), 0).r, texelFetch(u_undulations, high, 0).r);
  return mix(mix(n.x, n.y, share.x), mix(n.z, n.w, share.x), share.y);
}
#endif
out float v_moved;
out vec3 v_normal;
out vec4 v_texture_coordinate;  // from the mesh's origin; height

#ifdef GLOBE
// A vertex on an edge or in a corner of the cube lies on two or three faces (proto/topology/cube.h), and its name is that of one. So all
// places of it are passed on, of faces 0 and 3 on the first chart, of 1 and 4 on the second, of 2 and 5 on the third: no vertex is on both.
void setChart(inout vec4 charts[3], int face, vec2 place) {
  vec4 chart = vec4(place - u_pivots[face], float(face), 1.0);
  if (face % 3 == 0) charts[0] = chart;
  else if (face % 3 == 1) charts[1] = chart;
  else charts[2] = chart;
}
void passCharts() {
  vec4 charts[3] = vec4[](vec4(0.0), vec4(0.0), vec4(0.0));
  float side = u_face_steps;
  int face = min(int((texture_coordinate.x + 0.5) / side), 5);  // whatever a card makes of a whole quotient
  vec2 p = vec2(texture_coordinate.x - float(face) * side, texture_coordinate.y);
  bool is_first = face % 2 == 0;
  setChart(charts, face, p);
  if (p.x == side || p.y == side) { // corners that no face names
    setChart(charts, (face + 2) % 6, p);
    setChart(charts, (face + 4) % 6, p);
  } else {
    if (p.x == 0.0) setChart(charts, (face + (is_first ? 4 : 5)) % 6, is_first ? vec2(side - p.y, side) : vec2(side, p.y));
    if (p.y == 0.0) setChart(charts, (face + (is_first ? 5 : 4)) % 6, is_first ? vec2(p.x, side) : vec2(side, side - p.x));
  }
  v_chart_0 = charts[0], v_chart_1 = charts[1], v_chart_2 = charts[2];
}
#endif

// Passes on what the ground's colour is made of, at a blended position.
void passGround(vec4 p) {
  v_normal = mix(from_normal, to_normal, u_weight);
  v_texture_coordinate = p;
  v_lattice = texture_coordinate - u_pivot;
#ifdef GLOBE
  v_up = (u_from_middle + p.xyz) * vec3(1.0, 1.0, u_round);
  v_undulation = undulationAt(v_up);
  passCharts();
#endif
  v_moved = mix(from_moved, to_moved, u_weight);
}
