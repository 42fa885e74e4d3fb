#include "terrain/bounds/block_bounds.h"

#include <algorithm>

namespace foreland::terrain {

namespace {

// A window of a lattice as a lattice of its own, on which fine nodes are what they are on the whole.
constexpr uint32_t kLocalRootLog2 = Blocks::kFineLog2 + 1;
static_assert(1u << kLocalRootLog2 == Blocks::kHalo);
static_assert(2 * static_cast<int>(kLocalRootLog2) - 1 == Blocks::kFineLevels);

proto::GeographicTables windowOf(const proto::GeographicTables& tables, const ErrorWindow& window) {
  proto::GeographicTables part = tables;
  if (tables.rows.empty()) return part;
  part.rows.assign(tables.rows.begin() + window.low_y, tables.rows.begin() + window.high_y + 1);
  part.columns.assign(tables.columns.begin() + window.low_x, tables.columns.begin() + window.high_x + 1);
  return part;
}

// Samples of a window that are data.
uint32_t dataAlong(uint32_t samples, uint32_t low, uint32_t high) {
  return samples <= low ? 0 : std::min(samples - low, high - low + 1);
}

}  // namespace

ErrorWindow Blocks::own(uint32_t column, uint32_t row) const {
  const uint32_t side = 1u << log2, x = column << log2, y = row << log2;
  return {x, y, std::min(x + side, grid.maxX()), std::min(y + side, grid.maxY())};
}

ErrorWindow Blocks::withHalo(uint32_t column, uint32_t row) const {
  const ErrorWindow w = own(column, row);
  return {w.low_x < kHalo ? 0 : w.low_x - kHalo, w.low_y < kHalo ? 0 : w.low_y - kHalo,
          std::min(w.high_x + kHalo, grid.maxX()), std::min(w.high_y + kHalo, grid.maxY())};
}

// The pages of the far borders, which own no square, are the last blocks'.
PageWindow Blocks::pages(int level, uint32_t column, uint32_t row) const {
  const uint32_t scale = static_cast<uint32_t>(grid.maxLevel() - level) / 2,
                 side = proto::GridTopology::kTileSide << scale, columns_a_block = (1u << log2) / side,
                 rows_a_block = columns_a_block << (level & 1);
  return {level, column * columns_a_block,
          column + 1 == columns() ? grid.pageColumns(level) : (column + 1) * columns_a_block, row * rows_a_block,
          row + 1 == rows() ? grid.pageRows(level) : (row + 1) * rows_a_block};
}

BlockBounder::BlockBounder(const Blocks& blocks, const proto::Frame& frame, const proto::GeographicTables& tables,
                           uint32_t column, uint32_t row)
    : blocks_(blocks),
      grid_(blocks.grid),
      frame_(frame),
      tables_(tables),
      column_(column),
      row_(row),
      own_(blocks.own(column, row)),
      halo_(blocks.withHalo(column, row)) {
  result_.errors.resize(size_t{widthOf(own_)} * heightOf(own_));
  const proto::GridShape& s = grid_.shape();
  const uint32_t width = dataAlong(s.samples_x, halo_.low_x, halo_.high_x),
                 height = dataAlong(s.samples_y, halo_.low_y, halo_.high_y);
  if (width < 2 || height < 2) return;
  const auto local = proto::GridTopology::create(
      {(widthOf(halo_) - 1) >> kLocalRootLog2, (heightOf(halo_) - 1) >> kLocalRootLog2, kLocalRootLog2, width, height});
  CHECK_TRUE(local.ok());
  local_ = *local;
}

std::vector<NodeRecord> BlockBounder::boundWindow(HaloHeights ground, uint32_t first_row, uint32_t last_row) const {
  const proto::GridShape& s = local_->shape();
  std::vector<NodeRecord> records(local_->slotCount());
  const proto::GeographicTables tables = windowOf(tables_, halo_);
  const bool done =
      computeBounds({.grid = *local_,
                     .frame = frame_,
                     .heights = {ground, s.samples_x, s.samples_y, 0, 0, widthOf(halo_)},
                     .min_errors = min_errors_,
                     .tables = &tables,
                     .first_row = first_row,
                     .last_row = last_row,
                     .nodes = records,
                     .threads = 1,
                     .store = [&](proto::Slot first, std::span<const NodeRecord> some) {
                       std::copy(some.begin(), some.end(), records.begin() + static_cast<ptrdiff_t>(first));
                       return true;
                     }});
  CHECK_TRUE(done);
  return records;
}

// What nodes get at one time is not saturated by those whose supports no row reaches; finish() does that.
void BlockBounder::addErrors(HaloHeights ground, uint32_t first_row, uint32_t last_row) {
  CHECK_EQ(ground.size(), size_t{widthOf(halo_)} * heightOf(halo_));
  CHECK_GE(first_row, halo_.low_y);
  CHECK_GE(last_row, first_row);
  if (local_) {
    min_errors_.resize(local_->slotCount());
    const auto records = boundWindow(ground, first_row - halo_.low_y, last_row - halo_.low_y);
    for (size_t i = 0; i < records.size(); ++i) min_errors_[i] = std::max(min_errors_[i], records[i].error());
  }
  addCoarseErrors(ground);
}

void BlockBounder::addFineErrors(HaloHeights ground) {
  if (!local_) return;
  const auto records = boundWindow(ground, 0, ~0u);
  for (uint32_t y = own_.low_y; y <= own_.high_y; ++y)
    for (uint32_t x = own_.low_x; x <= own_.high_x; ++x) {
      const proto::NodeId n = proto::NodeId::at(x - halo_.low_x, y - halo_.low_y);
      if (const int level = local_->level(n); level > 0)
        errorAt(x, y) = std::max(errorAt(x, y), records[local_->slot(n, level)].error());
    }
}

void BlockBounder::addCoarseErrors(HaloHeights ground) {
  const Heights heights{ground,      grid_.shape().samples_x, grid_.shape().samples_y, halo_.low_x,
                        halo_.low_y, widthOf(halo_)};
  // Corners of supports may lie beyond the data, where the window has heights, too.
  const CornerHeights corners{{ground, ~0u, ~0u, halo_.low_x, halo_.low_y, widthOf(halo_)}, 0};
  if (frame_.kind == proto::FrameKind::kPlanar)
    addCoarseErrors(PlanarError(grid_, frame_, heights, corners));
  else
    addCoarseErrors(GeographicError(grid_, frame_, heights, corners, tables_));
}

template <class Error>
void BlockBounder::addCoarseErrors(const Error& error) {
  constexpr uint32_t kStep = 1u << Blocks::kFineLog2;
  for (uint32_t y = own_.low_y; y <= own_.high_y; y += kStep)
    for (uint32_t x = own_.low_x; x <= own_.high_x; x += kStep) {
      const proto::NodeId n = proto::NodeId::at(x, y);
      const int level = grid_.level(n);
      if (level == 0 || level >= blocks_.coarsestFineLevel() || grid_.scaleLog2(n) >= blocks_.log2) continue;
      errorAt(x, y) = std::max(errorAt(x, y), proto::QuantisedError::roundUp(error.metres(n, own_)));
    }
}

BlockBounds BlockBounder::finish(HaloHeights ground, std::span<const HaloHeights> extremes) {
  CHECK_EQ(ground.size(), size_t{widthOf(halo_)} * heightOf(halo_));
  addFineErrors(ground);
  addCoarseErrors(ground);
  const auto positionsOf = [&](HaloHeights quanta) {
    const Heights everywhere{quanta, grid_.maxX() + 1, grid_.maxY() + 1, halo_.low_x, halo_.low_y, widthOf(halo_)};
    return RowPositions(grid_, frame_, everywhere, tables_);
  };
  const RowPositions positions = positionsOf(ground);
  std::vector<RowPositions> others;
  for (const HaloHeights quanta : extremes) others.push_back(positionsOf(quanta));
  for (int level = blocks_.coarsestFineLevel(); level <= grid_.maxLevel(); ++level)
    result_.reach.push_back(reachOf(grid_, positions, others, blocks_.pages(level, column_, row_)));
  return std::move(result_);
}

}  // namespace foreland::terrain
