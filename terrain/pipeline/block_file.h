// One block of a scene that is made block by block, as a file that is named by its id (block_plan.h): it appears whole
// or not at all, and knows what it is of. Heights and errors of all lattice points of the block, its heights every 16
// points, and how far its pages reach. Pure but for the file; any thread.
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

// Makes a block of its heights and writes it. An Error names the file.
Status writeBlock(const std::filesystem::path& folder, const BlockPlan& plan, const ElevationInfo& info,
                  const Blocks& blocks, const proto::GeographicTables& tables, uint32_t column, uint32_t row,
                  uint64_t id, const HeightWindow& heights);

class BlockFile {
 public:
  // An Error: the file is not there, is no block, or is another one than the plan's.
  static Result<BlockFile> open(const std::filesystem::path& folder, const Blocks& blocks, uint32_t column,
                                uint32_t row, uint64_t id);

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

  std::filesystem::path path_;
  InputFile file_;
  ErrorWindow own_;
  uint64_t checksum_ = 0, bytes_ = 0, coarse_at_ = 0;
  int coarsest_ = 0;
  std::vector<uint64_t> reach_at_;  // by fine level
  std::vector<uint64_t> reach_count_;
};

}  // namespace foreland::terrain
