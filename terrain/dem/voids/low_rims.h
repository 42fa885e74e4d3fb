// At which heights large regions of voids are filled flat. Memory: half a megabyte for each such region, whatever its
// rim. Pure but for the rows that are read; one thread.
#pragma once

#include <cstdint>
#include <vector>

#include "base/result.h"
#include "terrain/dem/voids/row_cache.h"
#include "terrain/dem/voids/void_regions.h"

namespace foreland::terrain {

// Of each region of at least `least` samples: the tenth percentile of the finite heights beside its samples, each of
// which counts as often as it lies beside one. Not a number for others. Not all samples may be void. Reads rows beside
// large regions, twice, each time from south to north.
Result<std::vector<float>> lowRims(const VoidRegions& found, double least, uint32_t width, uint32_t height,
                                   const ReadRow& read);

}  // namespace foreland::terrain
