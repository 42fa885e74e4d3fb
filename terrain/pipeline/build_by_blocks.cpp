#include "terrain/pipeline/build_by_blocks.h"

#include "terrain/parallel.h"
#include "terrain/pipeline/block_file.h"
#include "terrain/pipeline/merge_blocks.h"
#include "terrain/pipeline/scene_parts.h"

namespace foreland::terrain {

namespace {

// Makes those of the blocks [first, end) of a row whose files are not there yet. `heights` holds their halos.
Status makeBlocks(const BlockPlan& plan, const ElevationInfo& info, const Blocks& blocks,
                  const std::filesystem::path& folder, uint32_t row, uint32_t first, uint32_t end,
                  const HeightWindow& heights, unsigned threads) {
  const proto::GeographicTables tables(proto::FrameTransform(plan.frame), blocks.grid.maxX(), blocks.grid.maxY());
  FirstFailure failure;
  parallelFor(
      end - first, threads,
      [&](uint64_t i, unsigned) {
        const auto column = static_cast<uint32_t>(first + i);
        const uint64_t id = plan.ids[uint64_t{row} * blocks.columns() + column];
        if (const auto kept = BlockFile::open(folder, blocks, column, row, id); kept && kept->points()) return;
        failure.keep(writeBlock(folder, plan, info, blocks, tables, column, row, id, heights));
      },
      [](uint64_t) { return true; });
  return failure.status();
}

}  // namespace

Result<BuildReport> buildByBlocks(ElevationSource& input, const WindowedOptions& options, const Progress& progress) {
  const std::vector<EpochRequest>& epochs = options.plan.epochs;
  if (Status s = checkAdditions(input.info(), epochs, options.plan.epoch_blend, options.additions); !s.ok())
    return s.error();
  std::filesystem::path folder = options.output;
  folder += ".blocks";
  std::error_code error;
  std::filesystem::create_directory(folder, error);
  if (error)
    return Error{ErrorCode::kIo, folder.string() + ": cannot make the folder that blocks wait in: " + error.message()};
  PlanOptions planning = options.plan;
  planning.voids = folder / "";
  const auto plan = planBlocks(input, planning, progress);
  if (!plan) {
    std::filesystem::remove(folder, error);  // unless something is in it
    return plan.error();
  }
  const auto grid = proto::GridTopology::create(plan->shape);
  const Blocks blocks{*grid, plan->block_log2};
  const GroundInTime ground(input, epochs, plan->voids);
  const ElevationInfo& info = input.info();
  progress.report("bounding", 0);
  const Status made = forEachBlocks(
      ground, blocks, options.plan.memory_bytes,
      [&](uint32_t row, uint32_t first, uint32_t end, const HeightWindow& heights) -> Status {
        for (uint32_t column = first; column < end; ++column)
          if (blockId(*plan, info, blocks, column, row, heights) !=
              plan->ids[uint64_t{row} * blocks.columns() + column])
            return changedWhileRead(info.title);
        if (Status s = makeBlocks(*plan, info, blocks, folder, row, first, end, heights, options.threads); !s.ok())
          return s;
        progress.report("bounding", (row + static_cast<double>(end) / blocks.columns()) / blocks.rows());
        return progress.keepGoing() ? Status() : Status(stopped());
      });
  if (!made.ok()) return made.error();
  auto built = mergeBlocks(input, *plan, {folder, options.output, options.threads, options.additions}, progress);
  if (built) std::filesystem::remove_all(folder, error);
  return built;
}

}  // namespace foreland::terrain
