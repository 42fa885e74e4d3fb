// How far a globe's ground at full resolution lies from the samples that it was made of.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "proto/section/page_directory.h"
#include "proto/space/frame.h"
#include "terrain/globe_source.h"

namespace foreland::terrain {

// For each input the largest difference in height, metres, at its samples where it alone counts at the sample and at
// the corners of the triangle that is drawn there; 0 if there are none. The triangle is the finest that nodes of
// `pages`, and of those that they need, make. Nothing if `keepGoing` returned false. O(samples times levels).
std::optional<std::vector<double>> globeResiduals(const GlobeSource& source, const proto::GridTopology& grid,
                                                  const proto::Frame& frame, const std::vector<proto::Slot>& pages,
                                                  const std::function<int32_t(proto::NodeId)>& height, unsigned threads,
                                                  const std::function<bool(double)>& keepGoing);

}  // namespace foreland::terrain
