// meshoptimizer's codecs for vertices and indices with zstd around them, as glTF's EXT_meshopt_compression is served:
// positions in 16 bits of the box's longest side, ordered for vertex cache and vertex fetch. Any thread.
#pragma once

#include <string>

#include "base/result.h"
#include "lab/wire/peers/peer_mesh.h"

namespace foreland::lab {

inline constexpr int kMeshoptimizerBits = 16, kMeshoptimizerZstdLevel = 19;

// Vertices, indices and a header of origin, scale and counts. kMalformed if what is decoded is no mesh.
Result<PeerCode> codeMeshoptimizer(const PeerMesh& mesh);

// Exact for positions that are integers, which `mesh` must have: the same codecs on those integers, less the least of
// each axis, in 16 bits each, or 32 if they need more.
Result<PeerCode> codeMeshoptimizerExactly(const PeerMesh& mesh);

std::string meshoptimizerVersion();  // such as "0.18"

}  // namespace foreland::lab
