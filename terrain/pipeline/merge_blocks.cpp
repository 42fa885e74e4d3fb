#include "terrain/pipeline/merge_blocks.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <optional>

#include "terrain/epochs/epoch_offsets.h"
#include "terrain/imagery/relief.h"
#include "terrain/parallel.h"
#include "terrain/pipeline/block_file.h"
#include "terrain/pipeline/block_files.h"
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
        files_(options.blocks, plan, blocks_),
        tables_(proto::FrameTransform(plan.frame), grid_.maxX(), grid_.maxY()),
        levels_(grid_, plan.frame),
        coarse_grid_(coarseGrid(grid_)),
        coarse_frame_(coarseFrame(plan.frame)),
        coarse_tables_(everySixteenth(tables_)),
        coarse_heights_(size_t{coarse_grid_.maxX() + 1} * (coarse_grid_.maxY() + 1)),
        raw_errors_(coarse_grid_.slotCount()),
        coarse_nodes_(coarse_grid_.slotCount()) {}

  Result<BuildReport> run() {
    auto dates = datesOf(plan_.epochs, plan_.epoch_blend, plan_.shape);
    if (!dates) return dates.error();
    auto objects = makeObjects(*dates);
    if (!objects) return objects.error();
    auto epochs = EpochSection::create(options_.output);
    if (!epochs) return epochs.error();
    if (Status s = addCoarseHeights(); !s.ok()) return s.error();
    if (Status s = addEpochs(*epochs); !s.ok()) return s.error();
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
                                       .epochs = &*epochs,
                                       .epoch_blend = plan_.epoch_blend,
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
  size_t coarseIndex(uint32_t x, uint32_t y) const {
    return size_t{y >> kFine} * (coarse_grid_.maxX() + 1) + (x >> kFine);
  }
  int32_t& coarseHeight(uint32_t x, uint32_t y) { return coarse_heights_[coarseIndex(x, y)]; }

  // By epoch, what of a block's samples is not as at the first epoch, and how much of it changes since the epoch
  // before. Blocks share their borders, so of their samples the last ones count where no other block has them.
  Status addEpochs(EpochSection& section) {
    std::vector<proto::LatticeWindow> moved(plan_.epochs.size());
    for (const BlockEpoch& epoch : plan_.epochs) reports_.push_back({.date = epoch.date});
    const Status seen = files_.forEach([&](const BlockFile& block, uint32_t column, uint32_t row) -> Status {
      const ErrorWindow own = blocks_.own(column, row);
      const proto::LatticeWindow samples =
          proto::LatticeWindow::common({own.low_x, own.low_y, widthOf(own) - (column + 1 < blocks_.columns() ? 1 : 0),
                                        heightOf(own) - (row + 1 < blocks_.rows() ? 1 : 0)},
                                       wholeOf(info_));
      const BlockLayer* before = nullptr;
      for (size_t i = 1; i < plan_.epochs.size(); ++i) {
        const BlockLayer* layer = block.layerAt(plan_.epochs[i].time);
        if (layer) moved[i] = proto::LatticeWindow::hull(moved[i], layer->window());
        if (layer != before)
          if (Status s = count(block, samples, before, layer, reports_[i]); !s.ok()) return s;
        before = layer;
      }
      return {};
    });
    if (!seen.ok()) return seen;
    for (size_t i = 0; i < plan_.epochs.size(); ++i) {
      if (i > 0) moved[i] = proto::LatticeWindow::hull(moved[i - 1], moved[i]);
      progress_.report("epochs", static_cast<double>(i) / static_cast<double>(plan_.epochs.size()));
      if (!progress_.keepGoing()) return stopped();
      if (Status s = addEpoch(static_cast<uint32_t>(i), moved[i], section); !s.ok()) return s;
    }
    if (!plan_.epochs.empty()) progress_.report("epochs", 1);
    return {};
  }

  Status count(const BlockFile& block, const proto::LatticeWindow& samples, const BlockLayer* before,
               const BlockLayer* after, EpochReport& report) const {
    std::vector<int32_t> old(samples.width), now(samples.width);
    for (uint32_t y = samples.y; y < samples.y + samples.height; ++y) {
      if (Status s = block.row(before, y, samples.x, old); !s.ok()) return s;
      if (Status s = block.row(after, y, samples.x, now); !s.ok()) return s;
      for (size_t i = 0; i < now.size(); ++i) {
        if (now[i] == old[i]) continue;
        ++report.changed_samples;
        report.max_m = std::max(report.max_m, std::abs(now[i] - old[i]) * plan_.frame.height_quantum_m);
      }
    }
    return {};
  }

  Status addEpoch(uint32_t number, const proto::LatticeWindow& moved, EpochSection& section) {
    const ReadOffsets read = [&](std::span<const uint32_t> rows, std::span<int32_t> out) {
      return files_.readOffsets(plan_.epochs[number].time, moved.x, moved.width, rows, out);
    };
    if (number == 0) coarse_grounds_.push_back(std::make_shared<const std::vector<int32_t>>(coarse_heights_));
    const Status added = terrain::addEpoch(grid_, number, {plan_.epochs[number].time, moved}, read, section);
    if (!added.ok()) return added;
    reports_[number].bytes = section.lastBytes();
    return number == 0 ? Status() : addCoarseGround(number, moved);
  }

  // Every 16th point at an epoch, beyond the data, too.
  Status addCoarseGround(uint32_t number, const proto::LatticeWindow& moved) {
    auto heights = std::make_shared<std::vector<int32_t>>(coarse_heights_);
    std::vector<int32_t> row(moved.width);
    auto out = heights->begin();
    for (uint32_t y = 0; y <= grid_.maxY(); y += 1u << kFine) {
      const uint32_t sample_y = std::min(y, info_.height - 1);
      const bool moves = sample_y - moved.y < moved.height;
      if (moves)
        if (Status s = files_.readOffsets(plan_.epochs[number].time, moved.x, moved.width, {&sample_y, 1}, row);
            !s.ok())
          return s;
      for (uint32_t x = 0; x <= grid_.maxX(); x += 1u << kFine, ++out)
        if (const uint32_t sample_x = std::min(x, info_.width - 1); moves && sample_x - moved.x < moved.width)
          *out += row[sample_x - moved.x];
    }
    const auto& before = coarse_grounds_.back();
    coarse_grounds_.push_back(*heights == *before ? before : std::move(heights));
    return {};
  }

  Status addCoarseHeights() {
    return files_.forEach([&](const BlockFile& block, uint32_t column, uint32_t row) -> Status {
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
      const Status read = files_.forEach([&](const BlockFile& block, uint32_t column, uint32_t row) -> Status {
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

  // A scene that changes in time has none: relief holds one ground only.
  Status addRelief(TileSection& tiles) {
    if (!plan_.epochs.empty()) return {};
    const HeightRows rows{info_.width, info_.height, [&](uint32_t first, uint32_t count, std::span<int32_t> out) {
                            return files_.readHeights(BlockFiles::kAtFirstEpoch, {0, first, info_.width, count}, out);
                          }};
    const auto made = terrain::addRelief(rows, plan_.frame, options_.threads, stage(progress_, "relief"), tiles);
    if (!made) return made.error();
    return *made ? Status() : Status(stopped());
  }

  // They stand on what blocks say of the samples around them.
  Result<Bytes> makeObjects(const proto::Epochs& dates) const {
    FirstFailure failure;
    const auto ground = groundOf(info_, plan_.frame, [&](uint32_t x, uint32_t y) {
      int32_t height = 0;
      failure.keep(files_.readHeights(BlockFiles::kAtFirstEpoch, {x, y, 1, 1}, {&height, 1}));
      return height;
    });
    auto section = makeObjectSection(options_.additions.objects, plan_.frame, dates, ground);
    if (!failure.status().ok()) return failure.status().error();
    return section;
  }

  Status addPicture(TileSection& tiles, SceneOrigin& origin) {
    const SceneAdditions& with = options_.additions;
    if (!with.picture) return {};
    const auto heightsAt = [&](int64_t when) {
      return HeightsByWindow{info_.width, info_.height,
                             [this, when](const SampleWindow& window, std::span<int32_t> out) {
                               return files_.readHeights(when, window, out);
                             }};
    };
    const BoundsOf boundsOf = plan_.epochs.empty() ? boundsOver(heightsAt(BlockFiles::kAtFirstEpoch), plan_.frame)
                                                   : boundsBetween(heightsAt(BlockLayer::kLowest),
                                                                   heightsAt(BlockLayer::kHighest), plan_.frame);
    const auto made = terrain::addPicture(*with.picture, boundsOf,
                                          {with.imagery_quality, with.attribution, options_.output, options_.threads},
                                          progress_, origin, tiles);
    if (!made) return made.error();
    imagery_ = *made;
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
    const auto block = files_.open(column, row);
    if (!block) return block.error();
    auto read = block->points();
    if (!read) return read.error();
    const Points points{blocks_.own(column, row), std::move(read).value()};
    addErrors(points);
    if (Status s = addErrorsOfAncestors(*block, points, column, row); !s.ok()) return s;
    for (int level = blocks_.coarsestFineLevel(); level <= grid_.maxLevel(); ++level)
      if (Status s = addPages(points, blocks_.pages(level, column, row), writer); !s.ok()) return s;
    return {};
  }

  void raise(NodeId n, QuantisedError error) {
    QuantisedError& all = raw_errors_[coarse_grid_.slot(NodeId::at(n.x() >> kFine, n.y() >> kFine))];
    all = std::max(all, error);
  }

  // Errors of the coarse nodes that the block knows.
  void addErrors(const Points& points) {
    const ErrorWindow& own = points.own;
    const std::lock_guard lock(mutex_);
    for (uint32_t y = own.low_y; y <= own.high_y; y += 1u << kFine)
      for (uint32_t x = own.low_x; x <= own.high_x; x += 1u << kFine) {
        const NodeId n = NodeId::at(x, y);
        if (const int level = grid_.level(n); level > 0 && level < blocks_.coarsestFineLevel())
          raise(n, points.at(n).error());
      }
  }

  // Its samples' share of the errors of coarser nodes, at the first epoch, and at each other one at which the block's
  // ground or that below a node's corners is another than at the epoch before.
  Status addErrorsOfAncestors(const BlockFile& block, const Points& points, uint32_t column, uint32_t row) {
    std::vector<int32_t> quanta(points.points.size());
    std::transform(points.points.begin(), points.points.end(), quanta.begin(), [](BlockPoint p) { return p.height(); });
    addErrorsOfAncestors(column, row, quanta, coarse_heights_, [](NodeId) { return true; });
    const BlockLayer* before = nullptr;
    for (uint32_t i = 1; i < plan_.epochs.size(); ++i) {
      const BlockLayer* layer = block.layerAt(plan_.epochs[i].time);
      const bool is_other = layer != before;
      before = layer;
      if (!is_other && coarse_grounds_[i] == coarse_grounds_[i - 1]) continue;
      std::vector<int32_t> then = quanta;
      if (Status s = moveTo(block, layer, points.own, then); !s.ok()) return s;
      addErrorsOfAncestors(column, row, then, *coarse_grounds_[i],
                           [&](NodeId n) { return is_other || cornersMove(n, i); });
    }
    return {};
  }

  // Adds a layer to the heights of those of a block's points that are samples.
  Status moveTo(const BlockFile& block, const BlockLayer* layer, const ErrorWindow& own,
                std::span<int32_t> quanta) const {
    std::vector<int32_t> difference(widthOf(own));
    for (uint32_t y = own.low_y; y <= std::min(own.high_y, info_.height - 1); ++y) {
      if (Status s = block.row(layer, y, own.low_x, difference); !s.ok()) return s;
      const size_t begin = size_t{y - own.low_y} * difference.size();
      for (size_t i = 0; i < difference.size(); ++i) quanta[begin + i] += difference[i];
    }
    return {};
  }

  // Whether the ground below a corner of a node's support is another than at the epoch before.
  bool cornersMove(NodeId n, uint32_t epoch) const {
    const auto moves = [&](NodeId v) {
      const size_t at = coarseIndex(v.x(), v.y());
      return (*coarse_grounds_[epoch])[at] != (*coarse_grounds_[epoch - 1])[at];
    };
    return std::ranges::any_of(grid_.endpoints(n), moves) || std::ranges::any_of(grid_.apexes(n), moves);
  }

  template <class IsWanted>
  void addErrorsOfAncestors(uint32_t column, uint32_t row, std::span<const int32_t> quanta,
                            std::span<const int32_t> coarse, const IsWanted& isWanted) {
    std::vector<std::pair<NodeId, QuantisedError>> found;
    const ErrorWindow own = blocks_.own(column, row);
    const Heights heights{quanta, grid_.shape().samples_x, grid_.shape().samples_y, own.low_x, own.low_y, widthOf(own)};
    const CornerHeights corners{{coarse, coarse_grid_.maxX() + 1, coarse_grid_.maxY() + 1}, kFine};
    const auto measure = [&](const auto& error) {
      forEachAncestor(blocks_, column, row, [&](NodeId n) {
        if (isWanted(n)) found.emplace_back(n, QuantisedError::roundUp(error.metres(n, own)));
      });
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
            .epochs = reports_,
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
  BlockFiles files_;
  proto::GeographicTables tables_;
  proto::SphereLevels levels_;
  proto::GridTopology coarse_grid_;
  proto::Frame coarse_frame_;
  proto::GeographicTables coarse_tables_;
  std::vector<int32_t> coarse_heights_;
  // By epoch, as coarse_heights_; the same as of the epoch before where none of it moves.
  std::vector<std::shared_ptr<const std::vector<int32_t>>> coarse_grounds_;
  std::vector<EpochReport> reports_;
  std::vector<QuantisedError> raw_errors_;  // by coarse slot
  std::vector<NodeRecord> coarse_nodes_;
  std::vector<std::vector<QuantisedRadius>> radii_;  // by fine level and page
  ImageryReport imagery_;
  std::mutex mutex_;  // of raw_errors_
};

}  // namespace

Status checkAdditions(const ElevationInfo& ground, const std::vector<EpochRequest>& epochs, proto::EpochBlend blend,
                      const SceneAdditions& additions) {
  if (Status s = checkDates(epochs); !s.ok()) return s;
  const auto grid = gridFor(ground);
  if (!grid) return grid.error();
  const auto dates = datesOf(epochs, blend, grid->shape());
  if (!dates) return dates.error();
  const auto made = makeObjectSection(additions.objects, ground.frame, *dates,
                                      groundOf(ground, ground.frame, [](uint32_t, uint32_t) { return 0; }));
  return made ? Status() : Status(made.error());
}

Result<BuildReport> mergeBlocks(const ElevationSource& source, const BlockPlan& plan, const MergeOptions& options,
                                const Progress& progress) {
  return Merge(source, plan, options, progress).run();
}

}  // namespace foreland::terrain
