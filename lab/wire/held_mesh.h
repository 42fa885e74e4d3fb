// A mesh that a client holds, taken apart for other makers' codecs: what our own wire made of it, and the same vertices
// and triangles as plain numbers. Pure; any thread.
#pragma once

#include <vector>

#include "lab/wire/peers/peer_mesh.h"
#include "proto/space/view.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct HeldMesh {
  // The same mesh twice, the vertices in the same order: on the lattice (x, y in samples, heights in quanta: the
  // integers that the wire sends), and in the scene's metres as the client draws them. Where triangles are clipped at
  // the data's border, the heights on the lattice are rounded to a quantum.
  PeerMesh lattice, scene;
  // Of the section's nodes, in quanta: height, and height less the mean of the edge's ends (rounded down).
  std::vector<int32_t> heights, displacements;
  size_t bytes = 0;  // of the keyframe that brought it to a client that held nothing, header included
};

// The mesh of a client whose first keyframe is for `view`.
HeldMesh meshHeldFor(const server::Hierarchy& hierarchy, const proto::View& view);

}  // namespace foreland::lab
