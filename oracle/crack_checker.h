// Looks for cracks in a mesh between two keyframes, by its lattice positions alone; shares no code with what builds
// meshes. Sound means:
//   every edge is shared by exactly two triangles with opposite directions, or lies on the border of the data
//   (so no vertex stands in the inside of an edge: the edge beside it would have one triangle only)
//   vertices at one lattice position are at one position in space, in both keyframes
//   every triangle has positive area in the lattice (counter-clockwise seen from above)
//   the areas add up to the data's, so that with the above every part of it is covered exactly once
// Pure; any thread. O(n log n).
#pragma once

#include <string>

#include "client/mesh/patch/keyframe_mesh.h"
#include "proto/topology/grid.h"

namespace foreland::oracle {

struct CrackReport {
  uint64_t cracks = 0;  // violations of any kind
  std::string first;    // the first of them, in words; empty if none
};

CrackReport findCracks(const client::KeyframeMesh& mesh, const proto::GridShape& shape);

}  // namespace foreland::oracle
