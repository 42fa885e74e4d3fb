#include "terrain/pipeline/block_files.h"

#include <algorithm>
#include <vector>

namespace foreland::terrain {

Result<BlockFile> BlockFiles::open(uint32_t column, uint32_t row) const {
  return BlockFile::open(folder_, blocks_, column, row, plan_.ids[uint64_t{row} * blocks_.columns() + column]);
}

Status BlockFiles::forEach(
    const std::function<Status(const BlockFile& block, uint32_t column, uint32_t row)>& visit) const {
  for (uint32_t row = 0; row < blocks_.rows(); ++row)
    for (uint32_t column = 0; column < blocks_.columns(); ++column) {
      const auto block = open(column, row);
      if (!block) return block.error();
      if (Status s = visit(*block, column, row); !s.ok()) return s;
    }
  return {};
}

Status BlockFiles::readHeights(int64_t when, const SampleWindow& window, std::span<int32_t> out) const {
  const uint32_t last_row = blockAlong(window.y + window.height - 1, blocks_.rows()),
                 last_column = blockAlong(window.x + window.width - 1, blocks_.columns());
  for (uint32_t row = blockAlong(window.y, blocks_.rows()); row <= last_row; ++row)
    for (uint32_t column = blockAlong(window.x, blocks_.columns()); column <= last_column; ++column)
      if (Status s = readPart(column, row, when, window, out); !s.ok()) return s;
  return {};
}

// What of a window is in a block.
Status BlockFiles::readPart(uint32_t column, uint32_t row, int64_t when, const SampleWindow& window,
                            std::span<int32_t> out) const {
  const auto block = open(column, row);
  if (!block) return block.error();
  const ErrorWindow own = blocks_.own(column, row);
  const uint32_t x = std::max(window.x, own.low_x), end_x = std::min(window.x + window.width, own.high_x + 1),
                 end_y = std::min(window.y + window.height, own.high_y + 1);
  const BlockLayer* layer = when == kAtFirstEpoch ? nullptr : block->extreme(when);
  std::vector<BlockPoint> part(end_x - x);
  std::vector<int32_t> difference(part.size());
  for (uint32_t y = std::max(window.y, own.low_y); y < end_y; ++y) {
    if (Status s = block->row(y, x, part); !s.ok()) return s;
    if (Status s = block->row(layer, y, x, difference); !s.ok()) return s;
    std::ranges::transform(part, difference,
                           out.begin() + static_cast<ptrdiff_t>(size_t{y - window.y} * window.width + x - window.x),
                           [](BlockPoint p, int32_t more) { return p.height() + more; });
  }
  return {};
}

Status BlockFiles::readOffsets(Time date, uint32_t x, uint32_t width, std::span<const uint32_t> rows,
                               std::span<int32_t> out) const {
  const uint32_t first = blockAlong(x, blocks_.columns()), last = blockAlong(x + width - 1, blocks_.columns());
  for (size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    const uint32_t block_row = blockAlong(rows[begin], blocks_.rows());
    while (end < rows.size() && blockAlong(rows[end], blocks_.rows()) == block_row) ++end;
    for (uint32_t column = first; column <= last; ++column) {
      const auto block = open(column, block_row);
      if (!block) return block.error();
      const ErrorWindow own = blocks_.own(column, block_row);
      const uint32_t from = std::max(x, own.low_x), to = std::min(x + width, own.high_x + 1);
      const BlockLayer* layer = block->layerAt(date);
      for (size_t i = begin; i < end; ++i)
        if (Status s = block->row(layer, rows[i], from, out.subspan(i * width + (from - x), to - from)); !s.ok())
          return s;
    }
  }
  return {};
}

}  // namespace foreland::terrain
