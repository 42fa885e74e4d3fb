// Draco's mesh codec (edgebreaker), as glTF has it and tuned to an integer grid. Encoding and decoding speed 0, its
// best compression. Any thread.
#pragma once

#include "base/result.h"
#include "lab/wire/peers/peer_mesh.h"

namespace foreland::lab {

inline constexpr int kDracoPositionBits = 14;

// As others use it: positions as floats, quantised to 14 bits of the box's longest side (qp14), everything else as the
// encoder chooses. kMalformed if Draco refuses the mesh or its own bytes.
Result<PeerCode> codeDraco(const PeerMesh& mesh);

// Exact for positions that are integers, which `mesh` must have. Places (x, y) and heights are attributes of their own,
// so that each has its own statistics: 9 to 10 % smaller on terrain than one attribute of three. Of the predictors
// that Draco has for heights the one that codes best is taken.
Result<PeerCode> codeDracoExactly(const PeerMesh& mesh);

const char* dracoVersion();

}  // namespace foreland::lab
