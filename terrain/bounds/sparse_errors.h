// Errors of ground that is fine in places, each of one node alone: sparse_bounds.h makes them saturated ones.
//
// Bisection's triangles are a tree, and what a node's support holds lies in the triangles below the two that it halves.
// So each triangle is visited once, with the planes of all that hold it, and its node's place is compared with all of
// them: places, which cost most, are computed twice for each node, and not once more for each level above it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "proto/space/frame_grid.h"
#include "terrain/bounds/sparse_records.h"

namespace foreland::terrain {

// The error of each node, by the place of its record; heights must be there. Nothing if `onProgress`, which is called
// on the calling thread with the fraction done, returned false. The result does not depend on the number of threads.
// Time: levels times nodes; memory: a byte a node.
std::vector<proto::QuantisedError> measureSparseErrors(const proto::GridTopology& grid,
                                                       const proto::FrameGrid& positions, const SparseRecords& records,
                                                       unsigned threads, const std::function<bool(double)>& onProgress);

}  // namespace foreland::terrain
