// What a cut takes away (draw/cut_view.ts).
#ifdef CUT
uniform vec2 u_cut[16];        // its ring on the lattice, from the pivot
uniform vec2 u_cut_scene[16];  // the same along the scene's axes, from the eye
uniform int u_cut_corners;
uniform bool u_cut_hole;

bool isCutAway(vec2 ring[16], vec2 at) {
  bool is_inside = false;
  for (int i = 0, k = u_cut_corners - 1; i < u_cut_corners; k = i++) {
    vec2 a = ring[i], b = ring[k];
    if ((a.y > at.y) != (b.y > at.y) && at.x < (b.x - a.x) * (at.y - a.y) / (b.y - a.y) + a.x) is_inside = !is_inside;
  }
  return is_inside == u_cut_hole;
}
#endif
