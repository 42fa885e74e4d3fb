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

class BlockPass {
 public:
  BlockPass(const Blocks& blocks, const proto::Frame& frame, const proto::GeographicTables& tables, uint32_t column,
            uint32_t row, std::span<const int32_t> quanta)
      : blocks_(blocks),
        grid_(blocks.grid),
        frame_(frame),
        tables_(tables),
        column_(column),
        row_(row),
        own_(blocks.own(column, row)),
        halo_(blocks.withHalo(column, row)),
        quanta_(quanta) {
    CHECK_EQ(quanta.size(), size_t{widthOf(halo_)} * heightOf(halo_));
    result_.errors.resize(size_t{widthOf(own_)} * heightOf(own_));
  }

  BlockBounds run() {
    addFineErrors();
    addCoarseErrors();
    addReach();
    return std::move(result_);
  }

 private:
  proto::QuantisedError& errorAt(uint32_t x, uint32_t y) {
    return result_.errors[size_t{y - own_.low_y} * widthOf(own_) + (x - own_.low_x)];
  }
  // Samples of the window that are data.
  uint32_t dataAlong(uint32_t samples, uint32_t low, uint32_t high) const {
    return samples <= low ? 0 : std::min(samples - low, high - low + 1);
  }

  void addFineErrors() {
    const proto::GridShape& s = grid_.shape();
    const uint32_t width = dataAlong(s.samples_x, halo_.low_x, halo_.high_x),
                   height = dataAlong(s.samples_y, halo_.low_y, halo_.high_y);
    if (width < 2 || height < 2) return;  // no support of the block holds data
    const proto::GridShape shape{(widthOf(halo_) - 1) >> kLocalRootLog2, (heightOf(halo_) - 1) >> kLocalRootLog2,
                                 kLocalRootLog2, width, height};
    const auto local = proto::GridTopology::create(shape);
    CHECK_TRUE(local.ok());
    std::vector<NodeRecord> records(local->slotCount());
    const proto::GeographicTables tables = windowOf(tables_, halo_);
    const bool done =
        computeBounds({.grid = *local,
                       .frame = frame_,
                       .heights = {quanta_, width, height, 0, 0, widthOf(halo_)},
                       .tables = &tables,
                       .nodes = records,
                       .threads = 1,
                       .store = [&](proto::Slot first, std::span<const NodeRecord> some) {
                         std::copy(some.begin(), some.end(), records.begin() + static_cast<ptrdiff_t>(first));
                         return true;
                       }});
    CHECK_TRUE(done);
    for (uint32_t y = own_.low_y; y <= own_.high_y; ++y)
      for (uint32_t x = own_.low_x; x <= own_.high_x; ++x) {
        const proto::NodeId n = proto::NodeId::at(x - halo_.low_x, y - halo_.low_y);
        if (const int level = local->level(n); level > 0) errorAt(x, y) = records[local->slot(n, level)].error();
      }
  }

  void addCoarseErrors() {
    const Heights heights{quanta_,     grid_.shape().samples_x, grid_.shape().samples_y, halo_.low_x,
                          halo_.low_y, widthOf(halo_)};
    // Corners of supports may lie beyond the data, where the window has heights, too.
    const CornerHeights corners{{quanta_, ~0u, ~0u, halo_.low_x, halo_.low_y, widthOf(halo_)}, 0};
    if (frame_.kind == proto::FrameKind::kPlanar)
      addCoarseErrors(PlanarError(grid_, frame_, heights, corners));
    else
      addCoarseErrors(GeographicError(grid_, frame_, heights, corners, tables_));
  }

  template <class Error>
  void addCoarseErrors(const Error& error) {
    constexpr uint32_t kStep = 1u << Blocks::kFineLog2;
    for (uint32_t y = own_.low_y; y <= own_.high_y; y += kStep)
      for (uint32_t x = own_.low_x; x <= own_.high_x; x += kStep) {
        const proto::NodeId n = proto::NodeId::at(x, y);
        const int level = grid_.level(n);
        if (level == 0 || level >= blocks_.coarsestFineLevel() || grid_.scaleLog2(n) >= blocks_.log2) continue;
        errorAt(x, y) = proto::QuantisedError::roundUp(error.metres(n, own_));
      }
  }

  void addReach() {
    const Heights everywhere{quanta_, grid_.maxX() + 1, grid_.maxY() + 1, halo_.low_x, halo_.low_y, widthOf(halo_)};
    const RowPositions positions(grid_, frame_, everywhere, tables_);
    for (int level = blocks_.coarsestFineLevel(); level <= grid_.maxLevel(); ++level)
      result_.reach.push_back(reachOf(grid_, positions, blocks_.pages(level, column_, row_)));
  }

  const Blocks& blocks_;
  const proto::GridTopology& grid_;
  const proto::Frame& frame_;
  const proto::GeographicTables& tables_;
  uint32_t column_, row_;
  ErrorWindow own_, halo_;
  std::span<const int32_t> quanta_;
  BlockBounds result_;
};

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

BlockBounds boundBlock(const Blocks& blocks, const proto::Frame& frame, const proto::GeographicTables& tables,
                       uint32_t column, uint32_t row, std::span<const int32_t> quanta) {
  return BlockPass(blocks, frame, tables, column, row, quanta).run();
}

}  // namespace foreland::terrain
