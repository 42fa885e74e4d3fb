// What has to be known of all of an elevation source before its blocks (terrain/bounds/block_bounds.h) can be made
// apart: found by looks at all of its samples, window by window; one, and three where there are voids. One caller.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/bounds/block_bounds.h"
#include "terrain/elevation_source.h"
#include "terrain/epochs/read_epoch.h"
#include "terrain/pipeline/build.h"
#include "terrain/pipeline/void_fill.h"

namespace foreland::terrain {

// A date of a scene that changes in time.
struct BlockEpoch {
  Time time;
  std::string date;  // as the user wrote it
};

std::vector<BlockEpoch> datesOf(const std::vector<EpochRequest>& epochs);

struct BlockPlan {
  proto::GridShape shape;
  proto::Frame frame;  // with the height quantum
  uint32_t block_log2 = 10;
  HeightRange range{};
  std::string quantum_note{};   // empty if the quantum was not widened
  std::vector<uint64_t> ids{};  // of blocks, row by row: of all that a block follows from
  std::vector<BlockEpoch> epochs{};
  proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
  // Blocks are of the source with its voids filled (GroundInTime); null if it has none.
  std::shared_ptr<const VoidFill> voids{};
  uint64_t voids_filled = 0;
  std::string voids_note{};

  uint64_t id() const;  // of the plan
};

struct PlanOptions {
  double height_quantum_m = 0.1;
  bool widen_quantum = false;  // as BuildOptions has it
  uint64_t memory_bytes = 1ull << 30;
  uint32_t block_log2 = 10;
  std::vector<EpochRequest> epochs{};  // as BuildOptions has them
  proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
  // What voids are filled with is kept in a file: this, its id and ".voids" are its name. It stays.
  std::filesystem::path voids{};
};

// An Error: what blocks cannot make.
[[nodiscard]] Result<BlockPlan> planBlocks(ElevationSource& source, const PlanOptions& options,
                                           const Progress& progress = {});

// What is in the plan that follows from the source, the quantum and the blend alone; the rest is left out.
[[nodiscard]] Result<BlockPlan> emptyPlan(const ElevationSource& source, double height_quantum_m, uint32_t block_log2,
                                          proto::EpochBlend blend = proto::EpochBlend::kLinear);

// A source as blocks are made of it: with the first epoch laid over it and its voids filled, and the other epochs. What
// it is made of has to outlive it.
class GroundInTime {
 public:
  // Epochs by checkEpochs(); `voids` may be null.
  GroundInTime(ElevationSource& source, const std::vector<EpochRequest>& epochs, std::shared_ptr<const VoidFill> voids);
  ElevationSource& first() const { return *ground_; }
  const ElevationInfo& info() const { return ground_->info(); }
  const std::vector<EpochRequest>& epochs() const { return epochs_; }

 private:
  std::shared_ptr<ElevationSource> laid_, ground_;
  std::shared_ptr<const VoidFill> voids_;
  const std::vector<EpochRequest>& epochs_;
};

// Heights in metres of some columns and rows of a source.
struct HeightWindow {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  std::vector<float> metres{};
  std::vector<EpochSamples> epochs{};  // what they say of these; of the first, which is in `metres`, nothing
  // Of any lattice point whose nearest sample is in the window.
  float at(const ElevationInfo& info, uint32_t at_x, uint32_t at_y) const {
    return metres[size_t{std::min(at_y, info.height - 1) - y} * width + (std::min(at_x, info.width - 1) - x)];
  }
};
Result<HeightWindow> readWindow(const GroundInTime& ground, const ErrorWindow& window);
// The samples of a window that are data.
proto::LatticeWindow samplesIn(const ErrorWindow& window, const ElevationInfo& info);

// The id of a block whose window with its halo was read: of its heights, where it is, and the plan but for its ids and
// its dates: an epoch that says nothing of a block does not rename it.
uint64_t blockId(const BlockPlan& plan, const ElevationInfo& info, const Blocks& blocks, uint32_t column, uint32_t row,
                 const HeightWindow& heights);

// Calls visit(row, first column, end, their heights with halos) for all blocks, as many at a time as a third of the
// memory holds.
Status forEachBlocks(
    const GroundInTime& ground, const Blocks& blocks, uint64_t memory_bytes,
    const std::function<Status(uint32_t row, uint32_t first, uint32_t end, const HeightWindow& heights)>& visit);

}  // namespace foreland::terrain
