#include "terrain/epochs/epoch_offsets.h"

#include <algorithm>
#include <vector>

#include "terrain/bounds/node_row.h"

namespace foreland::terrain {

namespace {

class EpochPass {
 public:
  EpochPass(const proto::GridTopology& grid, uint32_t number, const proto::Epoch& epoch, const ReadOffsets& read,
            EpochSection& section)
      : grid_(grid),
        number_(number),
        moved_(epoch.moved),
        end_x_(endOf(moved_.x + moved_.width, grid.shape().samples_x, grid.maxX())),
        end_y_(endOf(moved_.y + moved_.height, grid.shape().samples_y, grid.maxY())),
        read_(read),
        section_(section) {}

  Status run() {
    if (Status s = addBases(); !s.ok()) return s;
    for (int number = 1; number <= grid_.maxLevel(); ++number) {
      const NodeLevel level(grid_, number);
      const uint32_t tile = 2 * level.s * kTileCells, last = std::min(level.bands(), (end_y_ - 1) / tile + 1);
      for (uint32_t band = moved_.y / tile; band < last; ++band)
        if (Status s = addBand(level, band); !s.ok()) return s;
    }
    return {};
  }

 private:
  // Where the window ends; beyond the data if it reaches the border, whose samples are repeated there.
  static uint32_t endOf(uint32_t end, uint32_t samples, uint32_t last) { return end == samples ? last + 1 : end; }

  // Those of the rows y, y + step, ... that the window has.
  Status load(uint32_t y, uint32_t step, uint32_t count) {
    rows_.clear();
    for (uint32_t i = 0; i < count; ++i, y += step)
      if (y >= moved_.y && y < end_y_) rows_.push_back(std::min(y, moved_.y + moved_.height - 1));
    rows_.erase(std::unique(rows_.begin(), rows_.end()), rows_.end());
    offsets_.resize(rows_.size() * moved_.width);
    return rows_.empty() ? Status() : read_(rows_, offsets_);
  }
  // Of a vertex on one of these rows.
  int32_t at(proto::NodeId v) const {
    if (v.x() < moved_.x || v.x() >= end_x_ || v.y() < moved_.y || v.y() >= end_y_) return 0;
    const uint32_t y = std::min(v.y(), moved_.y + moved_.height - 1),
                   column = std::min(v.x() - moved_.x, moved_.width - 1);
    const auto row = std::lower_bound(rows_.begin(), rows_.end(), y) - rows_.begin();
    return offsets_[static_cast<size_t>(row) * moved_.width + column];
  }

  Status addBases() {
    const uint32_t step = std::max(grid_.rootSize() / 2, 1u);
    for (uint32_t y = (moved_.y + step - 1) / step * step; y < end_y_; y += step) {
      if (Status s = load(y, step, 1); !s.ok()) return s;
      for (uint32_t x = (moved_.x + step - 1) / step * step; x < end_x_; x += step) {
        const proto::NodeId v = proto::NodeId::at(x, y);
        if (const int32_t quanta = at(v); quanta != 0 && grid_.isBase(v))
          section_.add(proto::BaseOffset{number_, proto::baseVertexNumber(grid_, v), quanta});
      }
    }
    return {};
  }

  Status addBand(const NodeLevel& level, uint32_t band) {
    const uint32_t tile = 2 * level.s * kTileCells, y = band * tile;
    const Status loaded = level.sides ? load(y, level.s, 2 * kTileCells) : load(y + level.s, 2 * level.s, kTileCells);
    if (!loaded.ok() || rows_.empty()) return loaded;
    const proto::Slot begin = grid_.levelOffset(level.level),
                      each = (grid_.levelOffset(level.level + 1) - begin) / level.bands(), first = begin + band * each;
    for (proto::Slot page = first; page < first + each; page += proto::kPageSlots) {
      const uint32_t x = grid_.pagePlace(page).column * tile;
      if (x >= end_x_ || x + tile <= moved_.x) continue;
      if (Status s = addPage(level.level, page); !s.ok()) return s;
    }
    return {};
  }

  Status addPage(int level, proto::Slot first) {
    const proto::GridTopology::PageNodes nodes = grid_.pageNodes(level, first);
    constexpr uint32_t kSlots = std::tuple_size_v<OffsetBlock>;
    for (uint32_t begin = 0; begin < proto::kPageSlots; begin += kSlots) {
      OffsetBlock block{};
      bool moves = false;
      for (uint32_t i = 0; i < kSlots; ++i) {
        const proto::NodeId n = nodes.at(begin + i);
        if (!grid_.contains(n)) continue;
        block[i] = at(n);
        moves |= block[i] != 0;
      }
      if (!moves) continue;
      if (Status s = section_.add(static_cast<uint32_t>((first + begin) / kSlots), block); !s.ok()) return s;
    }
    return {};
  }

  const proto::GridTopology& grid_;
  uint32_t number_;
  proto::LatticeWindow moved_;
  uint32_t end_x_, end_y_;
  const ReadOffsets& read_;
  EpochSection& section_;
  std::vector<uint32_t> rows_;
  std::vector<int32_t> offsets_;
};

}  // namespace

Status addEpoch(const proto::GridTopology& grid, uint32_t number, const proto::Epoch& epoch, const ReadOffsets& read,
                EpochSection& section) {
  if (Status s = section.add(epoch); !s.ok() || epoch.moved.isEmpty()) return s;
  return EpochPass(grid, number, epoch, read, section).run();
}

}  // namespace foreland::terrain
