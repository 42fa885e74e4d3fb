// All blocks of a plan, as files in a folder: what they say of samples, wherever these are. Any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <utility>

#include "base/result.h"
#include "terrain/imagery/ground_bounds.h"
#include "terrain/pipeline/block_file.h"
#include "terrain/pipeline/block_plan.h"

namespace foreland::terrain {

// An Error of any of these names the block that is missing, damaged or another one.
class BlockFiles {
 public:
  // Neither plan nor blocks are copied.
  BlockFiles(std::filesystem::path folder, const BlockPlan& plan, const Blocks& blocks)
      : folder_(std::move(folder)), plan_(plan), blocks_(blocks) {}

  Result<BlockFile> open(uint32_t column, uint32_t row) const;
  // Calls visit(block, column, row) for all blocks.
  Status forEach(const std::function<Status(const BlockFile& block, uint32_t column, uint32_t row)>& visit) const;

  // Heights of samples, row by row: at the first epoch, or BlockLayer's kLowest or kHighest.
  static constexpr int64_t kAtFirstEpoch = INT64_MIN;
  Status readHeights(int64_t when, const SampleWindow& window, std::span<int32_t> out) const;
  // By how much some ascending rows of samples, `width` of them from `x` on, differ at a date from the first epoch.
  Status readOffsets(Time date, uint32_t x, uint32_t width, std::span<const uint32_t> rows,
                     std::span<int32_t> out) const;

 private:
  Status readPart(uint32_t column, uint32_t row, int64_t when, const SampleWindow& window,
                  std::span<int32_t> out) const;
  // The block that a sample is in along one axis; of two that share it the later one.
  uint32_t blockAlong(uint32_t at, uint32_t count) const { return std::min(at >> blocks_.log2, count - 1); }

  std::filesystem::path folder_;
  const BlockPlan& plan_;
  const Blocks& blocks_;
};

}  // namespace foreland::terrain
