// How deep a globe must be to lie close to its insets.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "proto/space/frame.h"
#include "proto/topology/grid.h"
#include "terrain/globe_source.h"

namespace foreland::terrain {

// The pages of sparse levels with which the ground is no further above or below that of the source than `residual_m`
// at all samples of its insets, edges that are mixed with what is below among them: at each sample as many levels as
// that takes, counted from the last one without which it would be further off. `deepest` says for each input down to
// which level pages may be there; where that does not suffice the ground is as close as it can be. Heights are those
// before they are rounded. Nothing if `keepGoing` returned false. Time: that of a height of the source for about four
// vertices a sample; memory: that of the vertices around a row of samples, for each thread.
std::optional<std::vector<proto::Slot>> pagesWithin(double residual_m, const GlobeSource& source,
                                                    const proto::GridTopology& grid, const proto::Frame& frame,
                                                    std::span<const int> deepest, unsigned threads,
                                                    const std::function<bool(double)>& keepGoing);

}  // namespace foreland::terrain
