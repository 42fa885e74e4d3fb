// One block of a scene that is made block by block, as a file that is named by its id (block_plan.h): it appears whole
// or not at all, and knows what it is of. Heights and errors of all lattice points of the block, its heights every 16
// points, and how far its pages reach; where the ground changes in time, layers of what it is then. Pure but for the
// file; any thread.
#pragma once

#include <filesystem>
#include <vector>

#include "base/result.h"
#include "terrain/bounds/block_bounds.h"
#include "terrain/pipeline/block_plan.h"
#include "terrain/store/file/input_file.h"

namespace foreland::terrain {

std::filesystem::path blockPath(const std::filesystem::path& folder, uint64_t id);

// The height (24 bits) and the error (8 bits) of a lattice point.
struct BlockPoint {
  uint32_t bits = 0;
  static BlockPoint of(int32_t height, proto::QuantisedError error) {
    return {static_cast<uint32_t>(height) << 8 | error.value};
  }
  int32_t height() const { return static_cast<int32_t>(bits) >> 8; }
  proto::QuantisedError error() const { return {static_cast<uint8_t>(bits)}; }
};

// By how much a block's samples differ from the heights at the first epoch: from a date on, or at the lowest and the
// highest at any time. Elsewhere in the block they do not. A file has the dates first, ascending, and then both others;
// or it has none.
struct BlockLayer {
  static constexpr int64_t kLowest = INT64_MAX - 1, kHighest = INT64_MAX;  // no dates (proto::Epochs::kMaxTime_us)
  int64_t time_us = 0;
  uint32_t x = 0, y = 0, width = 0, height = 0;  // samples
  uint64_t at = 0;                               // of i32 quanta, row by row; bytes after the header
  uint64_t checksum = 0;                         // XXH64 of these

  proto::LatticeWindow window() const { return {x, y, width, height}; }
  uint64_t bytes() const { return sizeof(int32_t) * uint64_t{width} * height; }
};
static_assert(sizeof(BlockLayer) == 40);

// Makes a block of its heights and writes it. An Error names the file.
Status writeBlock(const std::filesystem::path& folder, const BlockPlan& plan, const ElevationInfo& info,
                  const Blocks& blocks, const proto::GeographicTables& tables, uint32_t column, uint32_t row,
                  uint64_t id, const HeightWindow& heights);

class BlockFile {
 public:
  // An Error: the file is not there, is no block, or is another one than the plan's.
  static Result<BlockFile> open(const std::filesystem::path& folder, const Blocks& blocks, uint32_t column,
                                uint32_t row, uint64_t id);

  // Of the ground from a date on; null if it is as at the first epoch.
  const BlockLayer* layerAt(Time date) const;
  // kLowest or kHighest; null if the block does not change in time.
  const BlockLayer* extreme(int64_t which) const;
  // Differences of some samples of a row of the block.
  Status row(const BlockLayer* layer, uint32_t y, uint32_t first, std::span<int32_t> out) const;

  // All of the block's points, row by row, if nothing of the file is damaged.
  Result<std::vector<BlockPoint>> points() const;
  // Some of a row.
  Status row(uint32_t y, uint32_t first, std::span<BlockPoint> out) const;
  // Every 16th point of every 16th row.
  Result<std::vector<int32_t>> coarseHeights() const;
  // Of a fine level's pages.
  Result<std::vector<PageReach>> reach(int level) const;

 private:
  BlockFile() = default;
  Error damaged() const;
  Status read(uint64_t offset, std::span<uint8_t> out) const;
  Status readLayers(uint64_t count, uint64_t bytes);

  std::filesystem::path path_;
  InputFile file_;
  ErrorWindow own_;
  std::vector<BlockLayer> layers_;
  uint64_t checksum_ = 0, bytes_ = 0, coarse_at_ = 0;
  int coarsest_ = 0;
  std::vector<uint64_t> reach_at_;  // by fine level
  std::vector<uint64_t> reach_count_;
};

}  // namespace foreland::terrain
