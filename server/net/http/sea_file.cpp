#include "server/net/http/sea_file.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/bytes.h"

namespace foreland::server {

namespace {

constexpr uint32_t kColourSide = 181;  // of thinned undulations: 2 degrees around the earth

// Each value less what the three before it, west, south and south-west, foretell: west + south - south-west, where
// values beyond the grid are 0.
void putValues(const proto::UndulationGrid& grid, ByteWriter& out) {
  std::vector<int32_t> before(grid.columns + size_t{1}), row(grid.columns + size_t{1});
  for (uint32_t y = 0; y < grid.rows; ++y) {
    for (uint32_t x = 0; x < grid.columns; ++x) {
      row[x + 1] = static_cast<int32_t>(std::lround(grid.metres[size_t{y} * grid.columns + x] / kSeaStep_m));
      out.putZigzag(row[x + 1] - (row[x] + before[x + 1] - before[x]));
    }
    before.swap(row);
  }
}

}  // namespace

std::string seaFile(bool has_sea, const proto::UndulationGrid& undulations) {
  const proto::UndulationGrid grid = has_sea ? undulations : proto::thinned(undulations, kColourSide);
  Bytes bytes;
  ByteWriter out(bytes);
  for (const uint32_t value : {uint32_t{has_sea}, grid.columns, grid.rows, 0u}) out.put(value);
  const double max_error_m = grid.isEmpty() ? 0 : grid.max_error_m + 0.5 * kSeaStep_m;
  for (const double value : {grid.first.x, grid.first.y, grid.step.x, grid.step.y, kSeaStep_m, max_error_m})
    out.put(value);
  putValues(grid, out);
  return {bytes.begin(), bytes.end()};
}

}  // namespace foreland::server
