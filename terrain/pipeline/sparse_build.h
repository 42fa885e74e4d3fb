// A scene file of ground that is fine in places (proto/section/page_directory.h): coarse levels everywhere, deep pages
// where somebody says that there is something to see. The file appears whole or not at all.
//
// Such a scene has no epochs yet. One caller; uses threads of its own while it runs. Time and
// memory are those of the nodes that are there: 8 bytes each, and 8 bytes a sample along each axis.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "base/result.h"
#include "proto/section/epochs.h"
#include "proto/section/page_directory.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/scene.h"
#include "terrain/store/scene_writer.h"
#include "terrain/store/stored_heights.h"

namespace foreland::terrain {

// A lattice of so many samples all of whose levels down to a spacing of 2^whole_log2 samples are whole.
[[nodiscard]] Result<proto::GridTopology> sparseGrid(uint32_t samples_x, uint32_t samples_y, uint32_t whole_log2);

// The first slots of the pages that are wanted of sparse levels. isWanted(spacing, window) is asked of a tile of a
// level whose nodes lie `spacing` samples apart (a power of two, and of the finest level 1), whether there is something
// to see at that spacing in it; where it says no it is asked of no finer level. Tiles share their borders, and reach
// beyond the data. Time: that of the tiles asked about.
using IsWanted = std::function<bool(uint32_t spacing, const proto::LatticeWindow& tile)>;
[[nodiscard]] std::vector<proto::Slot> pagesWhere(const proto::GridTopology& grid, const IsWanted& isWanted);

struct SparseGround {
  const proto::GridTopology& grid;
  proto::Frame frame;  // with its height quantum; a globe's gets the lowest ground (Frame::floor)
  // The pages that shall be there, by any of their slots, as pagesWhere() lists them; those of whole levels, and those
  // of the parents of their nodes, need not be among them.
  std::vector<proto::Slot> pages;
  // The height at a point of the lattice, in quanta, less than proto::kMaxHeight either way; beyond the data (shape's
  // samples) that of the nearest point of it. Of base vertices and of the nodes of all pages that will be there, those
  // of parents included. From any thread; asked more than once of a point it must say the same.
  std::function<int32_t(proto::NodeId)> height;
};

struct SparseOptions {
  std::filesystem::path output;
  unsigned threads = 0;  // 0: one per processor
  SceneOrigin origin{};
  SceneDatum datum{};
  PageCoding page_coding = PageCoding::kPlain;
  // Called once, when the ground is known and nothing is written yet: adds to the file what follows from the ground.
  // Of what it is given it may change origin, datum, objects and tiles, which must live until the scene is written.
  std::function<Status(const StoredHeights& ground, SceneWriter::About& about)> complete =
      [](const StoredHeights&, SceneWriter::About&) { return Status(); };
};

[[nodiscard]] Result<BuildReport> buildSparseScene(const SparseGround& ground, const SparseOptions& options,
                                                   const Progress& progress = {});

}  // namespace foreland::terrain
