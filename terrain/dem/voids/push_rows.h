// One step of a push-pull pyramid, row by row: the voids of a level become what a coarser one has there, and are then
// relaxed by Gauss-Seidel sweeps. All sweeps go over the rows at once, one row behind the other, which is the order of
// operations of one sweep after the other. Memory: 14 rows. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/result.h"
#include "terrain/dem/voids/row_cache.h"

namespace foreland::terrain {

// Voids of a row: from the first, to one past the last.
using RunsOfRow = std::vector<std::pair<uint32_t, uint32_t>>;

struct RowLevel {
  uint32_t width = 0, height = 0;
};

struct PushInput {
  RowLevel fine;
  RowLevel coarse;             // half as many samples, rounded up
  ReadRow readFine;            // voids are not finite
  ReadRow readCoarse;          // without voids
  std::vector<bool> has_void;  // rows of the fine level
};

// Called with the filled rows that have voids, from south to north; after row y at the earliest when row y + 8 was
// read.
using TakeRow = std::function<Status(uint32_t y, std::span<const float> row, const RunsOfRow& runs)>;

Status pushRows(const PushInput& input, const TakeRow& take);

}  // namespace foreland::terrain
