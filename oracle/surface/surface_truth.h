// The full-resolution surface as its oracle takes it. It uses the topology's arithmetic, and nothing that chooses or
// draws nodes. Pure; any thread.
#pragma once

#include "oracle/surface/surface_oracle.h"
#include "proto/topology/mesh_topology.h"
#include "terrain/surface/surface.h"

namespace foreland::oracle {

// A point of the parameter domain in the given face; the weights' sum is MeshTopology::weightScale().
SurfacePoint surfacePoint(const proto::FacePoint& at);

// Cost: linear in the surface's vertices, about 100 bytes each.
SurfaceTruth truthOf(const terrain::TrueSurface& surface);

}  // namespace foreland::oracle
