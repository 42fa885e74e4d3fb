// Adds an epoch to the section of a scene file (store/tables/epoch_section.h): the offsets of all vertices that have
// some, in the order of their slots. Reads rows of samples, so that nobody has to hold a raster of offsets.
#pragma once

#include <functional>
#include <span>

#include "base/result.h"
#include "proto/section/epochs.h"
#include "proto/topology/grid.h"
#include "terrain/store/tables/epoch_section.h"

namespace foreland::terrain {

// Fills `out` with an epoch's offsets of some rows of samples, ascending, one row after the other: those of the columns
// of the epoch's window.
using ReadOffsets = std::function<Status(std::span<const uint32_t> rows, std::span<int32_t> out)>;

// `number` is the epoch's. Memory: 132 bytes a column of the window.
Status addEpoch(const proto::GridTopology& grid, uint32_t number, const proto::Epoch& epoch, const ReadOffsets& read,
                EpochSection& section);

}  // namespace foreland::terrain
