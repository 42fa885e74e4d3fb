#include "terrain/pipeline/sparse_build.h"

#include <algorithm>

#include "terrain/bounds/sparse_bounds.h"
#include "terrain/pipeline/scene_parts.h"

namespace foreland::terrain {

using proto::GridTopology;
using proto::NodeId;
using proto::NodeRecord;
using proto::Slot;

Result<GridTopology> sparseGrid(uint32_t samples_x, uint32_t samples_y, uint32_t whole_log2) {
  if (samples_x < 2 || samples_y < 2 || samples_x > GridTopology::kMaxSamples || samples_y > GridTopology::kMaxSamples)
    return Error{ErrorCode::kUnsupported, std::to_string(samples_x) + " x " + std::to_string(samples_y) +
                                              " lattice positions; a scene needs at least 2 and at most 2^20 a side"};
  proto::GridShape shape = GridTopology::shapeFor(samples_x, samples_y);
  shape.sparse_levels = 2 * std::min(whole_log2, shape.root_log2 - 1);
  return GridTopology::create(shape);
}

namespace {

class PageFinder {
 public:
  PageFinder(const GridTopology& grid, const IsWanted& isWanted) : grid_(grid), isWanted_(isWanted) {}

  // A tile of the squares of 2^(scale + 1) samples, of whose centres and sides a page and two are.
  void visit(uint32_t scale, uint32_t column, uint32_t row) {
    const int centres = grid_.levelOfScale(scale), sides = centres + 1;
    const uint32_t spacing = 1u << scale, side = GridTopology::kTileSide << scale;
    if (column >= grid_.pageColumns(sides) || 2 * row >= grid_.pageRows(sides)) return;
    // A tile may reach beyond the lattice, whose coordinates then still are far below 2^32.
    const proto::LatticeWindow tile{column * side, row * side, side + 1, side + 1};
    if (tile.x > grid_.maxX() || tile.y > grid_.maxY() || !isWanted_(spacing, tile)) return;
    if (centres > grid_.wholeLevels() && row < grid_.pageRows(centres) && column < grid_.pageColumns(centres))
      add({centres, column, row});
    if (sides > grid_.wholeLevels()) {
      add({sides, column, 2 * row});
      if (2 * row + 1 < grid_.pageRows(sides)) add({sides, column, 2 * row + 1});
    }
    if (scale == 0) return;
    for (const uint32_t north : {0u, 1u})
      for (const uint32_t east : {0u, 1u}) visit(scale - 1, 2 * column + east, 2 * row + north);
  }
  std::vector<Slot> take() { return std::move(pages_); }

 private:
  void add(const proto::PagePlace& page) { pages_.push_back(grid_.pageAt(page)); }

  const GridTopology& grid_;
  const IsWanted& isWanted_;
  std::vector<Slot> pages_;
};

}  // namespace

std::vector<Slot> pagesWhere(const GridTopology& grid, const IsWanted& isWanted) {
  if (grid.shape().sparse_levels == 0) return {};
  PageFinder finder(grid, isWanted);
  const uint32_t scale = (grid.shape().sparse_levels - 1) / 2;  // of the coarsest sparse level
  const int sides = grid.levelOfScale(scale) + 1;
  for (uint32_t row = 0; 2 * row < grid.pageRows(sides); ++row)
    for (uint32_t column = 0; column < grid.pageColumns(sides); ++column) finder.visit(scale, column, row);
  return finder.take();
}

namespace {

struct BaseVertices {
  std::vector<int32_t> corners, centres;
};

BaseVertices baseOf(const SparseGround& ground) {
  const proto::GridShape& shape = ground.grid.shape();
  const uint32_t size = 1u << shape.root_log2;
  BaseVertices base;
  for (uint32_t y = 0; y <= shape.roots_y; ++y)
    for (uint32_t x = 0; x <= shape.roots_x; ++x) {
      const uint32_t root_x = std::min(x, shape.roots_x - 1);
      base.corners.push_back(ground.height(ground.grid.nameIn(root_x, NodeId::at(x * size, y * size))));
    }
  for (uint32_t y = 0; y < shape.roots_y; ++y)
    for (uint32_t x = 0; x < shape.roots_x; ++x)
      base.centres.push_back(ground.height(NodeId::at(x * size + size / 2, y * size + size / 2)));
  return base;
}

// Of the vertices that are there; padding is left out, for it holds zeros.
struct Found {
  HeightRange range{proto::kMaxHeight, -proto::kMaxHeight};
  uint64_t nodes = 0;

  void add(int32_t height) {
    range.lowest = std::min(range.lowest, height);
    range.highest = std::max(range.highest, height);
  }
  // Those of a page of the grid.
  void addPage(const GridTopology& grid, Slot first, std::span<const NodeRecord> records) {
    for (size_t i = 0; i < records.size(); ++i)
      if (grid.node(first + i) != NodeId{}) add(records[i].height()), ++nodes;
  }
};

Found find(const GridTopology& grid, const proto::PageDirectory& pages, const BaseVertices& base,
           std::span<const NodeRecord> records) {
  Found found;
  for (const auto* heights : {&base.corners, &base.centres})
    for (const int32_t height : *heights) found.add(height);
  pages.forEachPage([&](Slot first, uint64_t place) {
    found.addPage(grid, first, records.subspan(place * proto::kPageSlots, proto::kPageSlots));
  });
  return found;
}

}  // namespace

Result<BuildReport> buildSparseScene(const SparseGround& ground, const SparseOptions& options,
                                     const Progress& progress) {
  const GridTopology& grid = ground.grid;
  const std::vector<proto::PageBlock> blocks = proto::blocksOf(grid, ground.pages);
  const auto pages = proto::PageDirectory::create(grid, blocks);
  if (!pages) return pages.error();
  const BaseVertices base = baseOf(ground);
  std::vector<NodeRecord> records(pages->pageCount() * proto::kPageSlots);
  progress.report("bounding", 0);
  const auto onProgress = [&](double fraction) {
    progress.report("bounding", fraction);
    return progress.keepGoing();
  };
  if (!computeSparseBounds({.grid = grid,
                            .frame = ground.frame,
                            .pages = *pages,
                            .base = {base.corners, base.centres},
                            .height = ground.height,
                            .records = records,
                            .threads = options.threads,
                            .onProgress = onProgress}))
    return stopped();
  const Found found = find(grid, *pages, base, records);
  proto::Frame frame = ground.frame;
  if (frame.kind == proto::FrameKind::kGlobe) frame.origin.height_m = found.range.lowest * frame.height_quantum_m;
  SceneWriter::About about{.shape = grid.shape(),
                           .frame = frame,
                           .heights = found.range,
                           .origin = options.origin,
                           .datum = options.datum,
                           .page_coding = options.page_coding,
                           .threads = options.threads,
                           .pages = blocks};
  if (Status s = options.complete({grid, *pages, records, {base.corners, base.centres}}, about); !s.ok())
    return s.error();
  progress.report("writing", 0);
  auto writer = SceneWriter::create(options.output, about);
  if (!writer.ok()) return writer.error();
  std::ranges::copy(base.corners, writer->corners().begin());
  std::ranges::copy(base.centres, writer->centres().begin());
  if (Status status = writer->put(0, records); !status.ok()) return status.error();
  const auto id = writer->finish();
  if (!id.ok()) return id.error();
  progress.report("writing", 1);
  const proto::GridShape& shape = grid.shape();
  return BuildReport{.width = shape.samples_x,
                     .height = shape.samples_y,
                     .samples = found.nodes + base.corners.size() + base.centres.size(),
                     .voids_filled = about.origin.voids_filled,
                     .notes = about.origin.notes,
                     .height_quantum_m = ground.frame.height_quantum_m,
                     .levels = grid.maxLevel(),
                     .nodes = found.nodes,
                     .file_bytes = writer->fileBytes(),
                     .scene_id = *id,
                     .lowest_m = found.range.lowest * ground.frame.height_quantum_m,
                     .highest_m = found.range.highest * ground.frame.height_quantum_m,
                     .epochs = {},
                     .imagery = {}};
}

}  // namespace foreland::terrain
