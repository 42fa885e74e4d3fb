// Is a decoded mesh the one that was encoded? It judges every codec of this folder and shares no code with any of them.
// Codecs may renumber vertices and triangles and rotate the corners of a triangle, but not reverse its orientation. Any
// thread.
#pragma once

#include "base/result.h"
#include "lab/wire/peers/peer_mesh.h"

namespace foreland::lab {

// Which vertex of `original` each vertex of `decoded` is: the nearest within the code's tolerance. An Error names the
// first vertex that is nobody's, or that two claim, or the first triangle that is not in both. O(n) for vertices spread
// as those of terrain are, of which no two lie within a tolerance in x and y.
Result<std::vector<uint32_t>> matchMeshes(const PeerMesh& original, const PeerCode& code);

}  // namespace foreland::lab
