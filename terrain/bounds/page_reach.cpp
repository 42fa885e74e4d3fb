#include "terrain/bounds/page_reach.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "terrain/bounds/node_row.h"

namespace foreland::terrain {

namespace {

// Positions on one lattice row, by number of the node or sample from `first` on.
struct Row {
  bool used = false;
  uint32_t y = 0, first = 0, last = 0;
  std::vector<double> x, y_m, z;
};

enum class Content : uint8_t { kSamples, kMiddles };

// Numbers [first, last) of a row, as far as it has them.
void load(const RowPositions& positions, const NodeRow& row, uint32_t first, uint32_t last, Content content, Row& out) {
  out.used = true, out.y = row.y, out.first = std::min(first, row.count), out.last = std::min(last, row.count);
  const size_t count = out.last - out.first;
  for (auto* column : {&out.x, &out.y_m, &out.z}) column->resize(count);
  NodeRow part = row;
  part.first_x = row.first_x + out.first * row.step_x;
  part.count = static_cast<uint32_t>(count);
  const RowPositions::Out to{out.x.data(), out.y_m.data(), out.z.data()};
  content == Content::kSamples ? positions.fill(part, to) : positions.fillMiddles(part, to);
}

class ReachPass {
 public:
  ReachPass(const proto::GridTopology& grid, const RowPositions& positions, std::span<const RowPositions> extremes,
            const PageWindow& pages)
      : grid_(grid),
        positions_(positions),
        extremes_(extremes),
        pages_(pages),
        level_(grid, pages.level),
        first_(pages.first_column * kTileCells),
        last_(pages.last_column * kTileCells),
        squares_(pages.count(), PageReach{{-1, -1, -1, -1, -1, -1}}) {}

  std::vector<PageReach> run() {
    const uint32_t rows_a_page = level_.sides ? kTileCells / 2 : kTileCells;
    const uint32_t end = std::min(pages_.last_row * rows_a_page, level_.cellRows());
    for (uint32_t cell = pages_.first_row * rows_a_page; cell < end; ++cell) {
      if (!level_.sides) {
        centres(cell);
      } else if (level_.level == grid_.maxLevel()) {
        samples(cell, level_.row(2 * cell));
        if (cell < level_.cells_y) samples(cell, level_.row(2 * cell + 1));
      } else {
        sides(cell, level_.row(2 * level_.s * cell));
        if (cell < level_.cells_y) sides(cell, level_.row(2 * level_.s * cell + level_.s));
      }
    }
    for (PageReach& page : squares_)
      for (double& square : page.metres)
        if (square >= 0) square = std::sqrt(square);
    return std::move(squares_);
  }

 private:
  // Rows of the next level; three at a time are enough for one of this level.
  const Row& below(uint32_t y, uint32_t first, uint32_t last) {
    for (const Row& row : kept_)
      if (row.used && row.y == y) return row;
    Row& row = kept_[oldest_];
    oldest_ = (oldest_ + 1) % kept_.size();
    load(positions_, NodeLevel(grid_, level_.level + 1).row(y), first, last, Content::kMiddles, row);
    return row;
  }

  // Takes the squares of the distances of own nodes i to the numbers `each` * i + `offset` of another row, whose nodes
  // stand in pages `page_row` from the southernmost that counts.
  void include(uint32_t cell, const Row& other, uint32_t each, int64_t offset, uint32_t page_row) {
    const uint32_t rows_a_page = level_.sides ? kTileCells / 2 : kTileCells;
    PageReach* pages = &squares_[size_t{cell / rows_a_page - pages_.first_row} * pages_.columns()];
    const bool has_pages = level_.level < grid_.maxLevel();
    for (uint32_t i = own_.first; i < own_.last; ++i) {
      const int64_t number = int64_t{each} * i + offset;
      if (number < other.first || number >= other.last) continue;
      const size_t a = i - own_.first, b = static_cast<size_t>(number - other.first);
      const double dx = other.x[b] - own_.x[a], dy = other.y_m[b] - own_.y_m[a], dz = other.z[b] - own_.z[a],
                   square = dx * dx + dy * dy + dz * dz;
      const auto column = static_cast<int64_t>(i / kTileCells), child = number / kTileCells;
      size_t place = 0;
      if (has_pages)
        place = level_.sides ? static_cast<size_t>(child - 2 * column + 1) + 3 * page_row
                             : static_cast<size_t>(child - column) + 2 * page_row;
      double& most = pages[static_cast<size_t>(column) - pages_.first_column].metres[place];
      most = square > most ? square : most;
    }
  }

  void centres(uint32_t cell) {
    const uint32_t s = level_.s, y = 2 * s * cell + s, half = kTileCells / 2, below_page = 2 * (cell / kTileCells);
    load(positions_, level_.row(y), first_, last_, Content::kMiddles, own_);
    const Row& beside = below(y, first_, last_ + 1);
    include(cell, beside, 1, 0, cell / half - below_page);
    include(cell, beside, 1, 1, cell / half - below_page);
    include(cell, below(y - s, first_, last_), 1, 0, cell / half - below_page);
    include(cell, below(y + s, first_, last_), 1, 0, (cell + 1) / half - below_page);
  }

  void sides(uint32_t cell, const NodeRow& row) {
    load(positions_, row, first_, last_, Content::kMiddles, own_);
    const uint32_t half = level_.s / 2, page = cell / (kTileCells / 2);
    const int64_t west = row.first_x == 0 ? -1 : 0;
    const uint32_t from = first_ == 0 ? 0 : 2 * first_ - 1, to = 2 * last_;
    const auto across = [&](uint32_t y) {
      const uint32_t page_row = y / (2 * half) / kTileCells + 1 - page;
      const Row& children = below(y, from, to);
      include(cell, children, 2, west, page_row);
      include(cell, children, 2, west + 1, page_row);
    };
    if (row.y >= half) across(row.y - half);
    if (row.y + half <= grid_.maxY()) across(row.y + half);
  }

  // The lattice points around a finest side, and its own.
  void samples(uint32_t cell, const NodeRow& row) {
    load(positions_, row, first_, last_, Content::kMiddles, own_);
    samples(positions_, cell, row);
    for (const RowPositions& positions : extremes_) samples(positions, cell, row);
  }
  void samples(const RowPositions& positions, uint32_t cell, const NodeRow& row) {
    const bool along_x = row.first_x == 1;
    Row& other = kept_[0];
    const NodeRow beside = along_x ? NodeRow{row.y, 0, 2, row.count + 1, 1} : NodeRow{row.y, 1, 2, row.count - 1, 1};
    load(positions, beside, first_ == 0 ? 0 : first_ - 1, last_ + 1, Content::kSamples, other);
    include(cell, other, 1, along_x ? 0 : -1, 0);
    include(cell, other, 1, along_x ? 1 : 0, 0);
    for (int64_t y = int64_t{row.y} - 1; y <= int64_t{row.y} + 1; ++y) {
      if (y < 0 || y > grid_.maxY()) continue;
      NodeRow here = row;
      here.y = static_cast<uint32_t>(y);
      load(positions, here, first_, last_, Content::kSamples, other);
      include(cell, other, 1, 0, 0);
    }
  }

  const proto::GridTopology& grid_;
  const RowPositions& positions_;
  std::span<const RowPositions> extremes_;
  const PageWindow& pages_;
  NodeLevel level_;
  uint32_t first_, last_;  // cells along x
  std::vector<PageReach> squares_;
  Row own_;
  std::array<Row, 3> kept_;
  size_t oldest_ = 0;
};

}  // namespace

std::vector<PageReach> reachOf(const proto::GridTopology& grid, const RowPositions& positions,
                               std::span<const RowPositions> extremes, const PageWindow& pages) {
  return ReachPass(grid, positions, extremes, pages).run();
}

}  // namespace foreland::terrain
