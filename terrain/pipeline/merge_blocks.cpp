#include "terrain/pipeline/merge_blocks.h"

#include <algorithm>
#include <mutex>
#include <optional>

#include "terrain/imagery/relief.h"
#include "terrain/parallel.h"
#include "terrain/pipeline/block_file.h"
#include "terrain/pipeline/scene_parts.h"
#include "terrain/store/scene_writer.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;
using proto::QuantisedError;
using proto::QuantisedRadius;

constexpr uint32_t kFine = Blocks::kFineLog2;

// A frame whose lattice has every 16th point of another one's. Powers of two: nothing is rounded.
proto::Frame coarseFrame(proto::Frame frame) {
  constexpr double kStep = 1u << kFine;
  frame.anchor /= kStep;
  frame.axis_x_m *= kStep;
  frame.axis_y_m *= kStep;
  return frame;
}

proto::GeographicTables everySixteenth(const proto::GeographicTables& tables) {
  proto::GeographicTables some = tables;
  const auto thin = [](auto& values) {
    for (size_t i = 0; i << kFine < values.size(); ++i) values[i] = values[i << kFine];
    if (!values.empty()) values.resize(((values.size() - 1) >> kFine) + 1);
  };
  thin(some.rows), thin(some.columns);
  return some;
}

proto::GridTopology coarseGrid(const proto::GridTopology& grid) {
  const proto::GridShape& s = grid.shape();
  const proto::GridShape coarse{s.roots_x, s.roots_y, s.root_log2 - kFine, (grid.maxX() >> kFine) + 1,
                                (grid.maxY() >> kFine) + 1};
  return proto::GridTopology::create(coarse).value();
}

class Merge {
 public:
  Merge(const ElevationSource& source, const BlockPlan& plan, const MergeOptions& options, const Progress& progress)
      : info_(source.info()),
        source_(source),
        plan_(plan),
        options_(options),
        progress_(progress),
        grid_(proto::GridTopology::create(plan.shape).value()),
        blocks_{grid_, plan.block_log2},
        tables_(proto::FrameTransform(plan.frame), grid_.maxX(), grid_.maxY()),
        levels_(grid_, plan.frame),
        coarse_grid_(coarseGrid(grid_)),
        coarse_frame_(coarseFrame(plan.frame)),
        coarse_tables_(everySixteenth(tables_)),
        coarse_heights_(size_t{coarse_grid_.maxX() + 1} * (coarse_grid_.maxY() + 1)),
        raw_errors_(coarse_grid_.slotCount()),
        coarse_nodes_(coarse_grid_.slotCount()) {}

  Result<BuildReport> run() {
    auto objects = makeObjects();
    if (!objects) return objects.error();
    if (Status s = addCoarseHeights(); !s.ok()) return s.error();
    if (Status s = addRadii(); !s.ok()) return s.error();
    auto tiles = TileSection::create(options_.output);
    if (!tiles) return tiles.error();
    if (Status s = addRelief(*tiles); !s.ok()) return s.error();
    SceneOrigin origin{.title = info_.title,
                       .crs_wkt = info_.crs_wkt,
                       .notes = info_.notes,
                       .voids_filled = info_.voids_filled + plan_.voids_filled};
    for (const std::string& note : {plan_.quantum_note, plan_.voids_note})
      if (!note.empty()) origin.notes.push_back(note);
    if (Status s = addPicture(*tiles, origin); !s.ok()) return s.error();
    auto writer = SceneWriter::create(options_.output,
                                      {.shape = grid_.shape(),
                                       .frame = plan_.frame,
                                       .heights = plan_.range,
                                       .origin = origin,
                                       .objects = std::move(*objects),
                                       .datum = datumOf(info_.vertical, info_.inputs, plan_.frame.height_quantum_m),
                                       .page_coding = options_.additions.page_coding,
                                       .threads = options_.threads,
                                       .tiles = &*tiles,
                                       .mapping = FileMapping::kNone});
    if (!writer) return writer.error();
    if (Status s = addFineNodes(*writer); !s.ok()) return s.error();
    if (Status s = addCoarseNodes(*writer); !s.ok()) return s.error();
    fillBase(
        grid_.shape(), [&](uint32_t x, uint32_t y) { return coarseHeight(x, y); }, *writer);
    if (!progress_.keepGoing()) return stopped();
    progress_.report("writing", 0);
    const auto id = writer->finish();
    if (!id) return id.error();
    progress_.report("writing", 1);
    return report(origin, *writer, *id);
  }

 private:
  Result<BlockFile> open(uint32_t column, uint32_t row) const {
    return BlockFile::open(options_.blocks, blocks_, column, row,
                           plan_.ids[uint64_t{row} * blocks_.columns() + column]);
  }
  template <class Visit>
  Status forEachBlock(const Visit& visit) const {
    for (uint32_t row = 0; row < blocks_.rows(); ++row)
      for (uint32_t column = 0; column < blocks_.columns(); ++column) {
        const auto block = open(column, row);
        if (!block) return block.error();
        if (Status s = visit(*block, column, row); !s.ok()) return s;
      }
    return {};
  }

  int32_t& coarseHeight(uint32_t x, uint32_t y) {
    return coarse_heights_[size_t{y >> kFine} * (coarse_grid_.maxX() + 1) + (x >> kFine)];
  }

  Status addCoarseHeights() {
    return forEachBlock([&](const BlockFile& block, uint32_t column, uint32_t row) -> Status {
      const auto heights = block.coarseHeights();
      if (!heights) return heights.error();
      const ErrorWindow own = blocks_.own(column, row);
      auto at = heights->begin();
      for (uint32_t y = own.low_y; y <= own.high_y; y += 1u << kFine)
        for (uint32_t x = own.low_x; x <= own.high_x; x += 1u << kFine) coarseHeight(x, y) = *at++;
      return {};
    });
  }

  // Of the pages of fine levels, from the finest to the coarsest.
  Status addRadii() {
    radii_.resize(Blocks::kFineLevels);
    for (int level = grid_.maxLevel(); level >= blocks_.coarsestFineLevel(); --level) {
      auto& radii = radiiOf(level);
      radii.resize((grid_.levelOffset(level + 1) - grid_.levelOffset(level)) / proto::kPageSlots);
      const auto below = [&](uint32_t column, uint32_t row) { return radius(level + 1, column, row); };
      const Status read = forEachBlock([&](const BlockFile& block, uint32_t column, uint32_t row) -> Status {
        const auto reach = block.reach(level);
        if (!reach) return reach.error();
        const PageWindow pages = blocks_.pages(level, column, row);
        auto at = reach->begin();
        for (uint32_t y = pages.first_row; y < pages.last_row; ++y)
          for (uint32_t x = pages.first_column; x < pages.last_column; ++x)
            radii[pageIndex(level, x, y)] = pageRadius(grid_, levels_, {level, x, y}, *at++, below);
        return {};
      });
      if (!read.ok()) return read;
    }
    return {};
  }
  std::vector<QuantisedRadius>& radiiOf(int level) {
    return radii_[static_cast<size_t>(level - blocks_.coarsestFineLevel())];
  }
  uint64_t pageIndex(int level, uint32_t column, uint32_t row) const {
    return (grid_.pageAt({level, column, row}) - grid_.levelOffset(level)) / proto::kPageSlots;
  }
  QuantisedRadius radius(int level, uint32_t column, uint32_t row) {
    return radiiOf(level)[pageIndex(level, column, row)];
  }

  Status addRelief(TileSection& tiles) {
    const HeightRows rows{info_.width, info_.height, [&](uint32_t first, uint32_t count, std::span<int32_t> out) {
                            return readHeights({0, first, info_.width, count}, out);
                          }};
    const auto made = terrain::addRelief(rows, plan_.frame, options_.threads, stage(progress_, "relief"), tiles);
    if (!made) return made.error();
    return *made ? Status() : Status(stopped());
  }

  // They stand on what blocks say of the samples around them.
  Result<Bytes> makeObjects() const {
    FirstFailure failure;
    const auto ground = groundOf(info_, plan_.frame, [&](uint32_t x, uint32_t y) {
      int32_t height = 0;
      failure.keep(readHeights({x, y, 1, 1}, {&height, 1}));
      return height;
    });
    auto section = makeObjectSection(options_.additions.objects, plan_.frame, proto::Epochs(), ground);
    if (!failure.status().ok()) return failure.status().error();
    return section;
  }

  Status addPicture(TileSection& tiles, SceneOrigin& origin) {
    const SceneAdditions& with = options_.additions;
    if (!with.picture) return {};
    const BoundsOf boundsOf =
        boundsOver({info_.width, info_.height,
                    [&](const SampleWindow& window, std::span<int32_t> out) { return readHeights(window, out); }},
                   plan_.frame);
    const auto made = terrain::addPicture(*with.picture, boundsOf,
                                          {with.imagery_quality, with.attribution, options_.output, options_.threads},
                                          progress_, origin, tiles);
    if (!made) return made.error();
    imagery_ = *made;
    return {};
  }

  // Of samples, row by row. Any thread.
  Status readHeights(const SampleWindow& window, std::span<int32_t> out) const {
    const auto first = [&](uint32_t at, uint32_t count) { return std::min(at >> blocks_.log2, count - 1); };
    const uint32_t last_x = window.x + window.width - 1, last_y = window.y + window.height - 1;
    for (uint32_t row = first(window.y, blocks_.rows()); row <= first(last_y, blocks_.rows()); ++row)
      for (uint32_t column = first(window.x, blocks_.columns()); column <= first(last_x, blocks_.columns()); ++column)
        if (Status s = readPart(column, row, window, out); !s.ok()) return s;
    return {};
  }
  // What of a window is in a block.
  Status readPart(uint32_t column, uint32_t row, const SampleWindow& window, std::span<int32_t> out) const {
    const auto block = open(column, row);
    if (!block) return block.error();
    const ErrorWindow own = blocks_.own(column, row);
    const uint32_t x = std::max(window.x, own.low_x), end_x = std::min(window.x + window.width, own.high_x + 1),
                   end_y = std::min(window.y + window.height, own.high_y + 1);
    std::vector<BlockPoint> part(end_x - x);
    for (uint32_t y = std::max(window.y, own.low_y); y < end_y; ++y) {
      if (Status s = block->row(y, x, part); !s.ok()) return s;
      std::ranges::transform(part,
                             out.begin() + static_cast<ptrdiff_t>(size_t{y - window.y} * window.width + x - window.x),
                             &BlockPoint::height);
    }
    return {};
  }

  Status addFineNodes(SceneWriter& writer) {
    FirstFailure failure;
    progress_.report("merging", 0);
    const bool done = parallelFor(
        blocks_.count(), options_.threads,
        [&](uint64_t i, unsigned) {
          failure.keep(addBlock(static_cast<uint32_t>(i % blocks_.columns()),
                                static_cast<uint32_t>(i / blocks_.columns()), writer));
        },
        [&](uint64_t count) {
          progress_.report("merging", static_cast<double>(count) / static_cast<double>(blocks_.count()));
          return progress_.keepGoing();
        });
    if (!failure.status().ok()) return failure.status();
    return done ? Status() : Status(stopped());
  }

  struct Points {
    ErrorWindow own;
    std::vector<BlockPoint> points;
    BlockPoint at(NodeId n) const { return points[size_t{n.y() - own.low_y} * widthOf(own) + (n.x() - own.low_x)]; }
  };

  Status addBlock(uint32_t column, uint32_t row, SceneWriter& writer) {
    const auto block = open(column, row);
    if (!block) return block.error();
    auto read = block->points();
    if (!read) return read.error();
    const Points points{blocks_.own(column, row), std::move(read).value()};
    addErrors(points, column, row);
    for (int level = blocks_.coarsestFineLevel(); level <= grid_.maxLevel(); ++level)
      if (Status s = addPages(points, blocks_.pages(level, column, row), writer); !s.ok()) return s;
    return {};
  }

  void raise(NodeId n, QuantisedError error) {
    QuantisedError& all = raw_errors_[coarse_grid_.slot(NodeId::at(n.x() >> kFine, n.y() >> kFine))];
    all = std::max(all, error);
  }

  // Errors of coarse nodes: those that the block knows, and its samples' share of its ancestors'.
  void addErrors(const Points& points, uint32_t column, uint32_t row) {
    std::vector<std::pair<NodeId, QuantisedError>> found;
    const ErrorWindow& own = points.own;
    for (uint32_t y = own.low_y; y <= own.high_y; y += 1u << kFine)
      for (uint32_t x = own.low_x; x <= own.high_x; x += 1u << kFine) {
        const NodeId n = NodeId::at(x, y);
        if (const int level = grid_.level(n); level > 0 && level < blocks_.coarsestFineLevel())
          found.emplace_back(n, points.at(n).error());
      }
    std::vector<int32_t> quanta(points.points.size());
    std::transform(points.points.begin(), points.points.end(), quanta.begin(), [](BlockPoint p) { return p.height(); });
    const Heights heights{quanta, grid_.shape().samples_x, grid_.shape().samples_y, own.low_x, own.low_y, widthOf(own)};
    const CornerHeights corners{{coarse_heights_, coarse_grid_.maxX() + 1, coarse_grid_.maxY() + 1}, kFine};
    const auto measure = [&](const auto& error) {
      forEachAncestor(blocks_, column, row,
                      [&](NodeId n) { found.emplace_back(n, QuantisedError::roundUp(error.metres(n, own))); });
    };
    if (plan_.frame.kind == proto::FrameKind::kPlanar)
      measure(PlanarError(grid_, plan_.frame, heights, corners));
    else
      measure(GeographicError(grid_, plan_.frame, heights, corners, tables_));
    const std::lock_guard lock(mutex_);
    for (const auto& [n, error] : found) raise(n, error);
  }

  // One row of tiles after the other, each of which is a run of slots.
  Status addPages(const Points& points, const PageWindow& pages, SceneWriter& writer) {
    const bool sides = pages.level & 1;
    const uint32_t rows = sides ? 2 : 1;
    std::vector<NodeRecord> records(size_t{pages.columns()} * rows * proto::kPageSlots);
    for (uint32_t row = pages.first_row; row < pages.last_row; row += rows) {
      const proto::Slot first = grid_.pageAt({pages.level, pages.first_column, row});
      for (size_t page = 0; page < records.size(); page += proto::kPageSlots)
        addPage(points, pages.level, first + page, std::span(records).subspan(page).first<proto::kPageSlots>());
      if (Status s = writer.put(first, records); !s.ok()) return s;
      if (pages.level < coarse_grid_.maxLevel() + 1)
        std::copy(records.begin(), records.end(), coarse_nodes_.begin() + static_cast<ptrdiff_t>(first));
    }
    return {};
  }

  void addPage(const Points& points, int level, proto::Slot first, std::span<NodeRecord> records) {
    const proto::GridTopology::PageNodes nodes = grid_.pageNodes(level, first);
    const proto::PagePlace place = grid_.pagePlace(first);
    const QuantisedRadius page_radius = radius(level, place.column, place.row);
    for (uint32_t i = 0; i < proto::kPageSlots; ++i) {
      const NodeId n = nodes.at(i);
      if (!grid_.contains(n) || n.x() > points.own.high_x || n.y() > points.own.high_y) {
        records[i] = {};
        continue;
      }
      const auto ends = grid_.endpoints(n, level);
      const BlockPoint p = points.at(n);
      const int32_t middle = proto::middleOf(points.at(ends[0]).height(), points.at(ends[1]).height());
      records[i] = NodeRecord::of(p.height(), p.height() - middle, p.error(), page_radius);
    }
  }

  // Coarse levels, as a lattice of every 16th point whose errors are known.
  Status addCoarseNodes(SceneWriter& writer) {
    FirstFailure failure;
    const Heights heights{coarse_heights_, coarse_grid_.maxX() + 1, coarse_grid_.maxY() + 1};
    const bool done = computeBounds({.grid = coarse_grid_,
                                     .frame = coarse_frame_,
                                     .heights = heights,
                                     .raw_errors = raw_errors_,
                                     .from_level = coarse_grid_.maxLevel() - 1,
                                     .spheres = &levels_,
                                     .tables = &coarse_tables_,
                                     .nodes = coarse_nodes_,
                                     .threads = options_.threads,
                                     .store =
                                         [&](proto::Slot first, std::span<const NodeRecord> records) {
                                           std::copy(records.begin(), records.end(),
                                                     coarse_nodes_.begin() + static_cast<ptrdiff_t>(first));
                                           return failure.keep(writer.put(first, records));
                                         },
                                     .onProgress = [&](double) { return progress_.keepGoing(); }});
    if (!failure.status().ok()) return failure.status();
    return done ? Status() : Status(stopped());
  }

  BuildReport report(const SceneOrigin& origin, const SceneWriter& writer, uint64_t id) const {
    const double quantum_m = plan_.frame.height_quantum_m;
    return {.width = info_.width,
            .height = info_.height,
            .samples = uint64_t{info_.width} * info_.height,
            .voids_filled = origin.voids_filled,
            .notes = origin.notes,
            .height_quantum_m = quantum_m,
            .levels = grid_.maxLevel(),
            .nodes = nodeCount(grid_),
            .file_bytes = writer.fileBytes(),
            .scene_id = id,
            .lowest_m = plan_.range.lowest * quantum_m,
            .highest_m = plan_.range.highest * quantum_m,
            .epochs = {},
            .imagery = imagery_,
            .warnings = source_.warnings()};
  }

  const ElevationInfo& info_;
  const ElevationSource& source_;
  const BlockPlan& plan_;
  const MergeOptions& options_;
  const Progress& progress_;
  proto::GridTopology grid_;
  Blocks blocks_;
  proto::GeographicTables tables_;
  proto::SphereLevels levels_;
  proto::GridTopology coarse_grid_;
  proto::Frame coarse_frame_;
  proto::GeographicTables coarse_tables_;
  std::vector<int32_t> coarse_heights_;
  std::vector<QuantisedError> raw_errors_;  // by coarse slot
  std::vector<NodeRecord> coarse_nodes_;
  std::vector<std::vector<QuantisedRadius>> radii_;  // by fine level and page
  ImageryReport imagery_;
  std::mutex mutex_;  // of raw_errors_
};

}  // namespace

Status checkAdditions(const ElevationInfo& ground, const SceneAdditions& additions) {
  for (const ObjectRequest& object : additions.objects) {
    const auto model = MappedSurface::open(object.model);
    if (!model) return model.error();
    if (!(*model)->poseTimes().empty())
      return Error{ErrorCode::kUnsupported, object.model.string() +
                                                ": has poses at several dates, and a scene that changes in time is not "
                                                "made by blocks yet; foreland build makes it at once"};
  }
  const auto made = makeObjectSection(additions.objects, ground.frame, proto::Epochs(),
                                      groundOf(ground, ground.frame, [](uint32_t, uint32_t) { return 0; }));
  return made ? Status() : Status(made.error());
}

Result<BuildReport> mergeBlocks(const ElevationSource& source, const BlockPlan& plan, const MergeOptions& options,
                                const Progress& progress) {
  return Merge(source, plan, options, progress).run();
}

}  // namespace foreland::terrain
