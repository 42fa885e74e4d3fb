#include "terrain/pipeline/sparse_source.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "terrain/bounds/heights.h"
#include "terrain/imagery/sparse_ground.h"
#include "terrain/pipeline/scene_parts.h"
#include "terrain/pipeline/sparse_build.h"
#include "terrain/store/bilinear.h"

namespace foreland::terrain {

namespace {

using proto::NodeId;

Status checkOptions(const ElevationInfo& info, const BuildOptions& options) {
  if (options.epochs.empty()) return {};
  return Error{ErrorCode::kUnsupported, info.title + ": a scene of " + std::to_string(info.width) + " x " +
                                            std::to_string(info.height) +
                                            " positions is fine in places only, and has no epochs yet; leave these "
                                            "out, or cut out its surroundings"};
}

// What of a scene follows from its ground.
class Completion {
 public:
  Completion(const ElevationSource& source, const BuildOptions& options, const proto::Frame& frame,
             const Progress& progress)
      : source_(source), options_(options), frame_(frame), progress_(progress) {}

  Status operator()(const StoredHeights& ground, SceneWriter::About& about) {
    const ElevationInfo& info = source_.info();
    const auto metres = [&](uint32_t x, uint32_t y) { return ground.at(NodeId::at(x, y)) * frame_.height_quantum_m; };
    about.datum = datumOf(info.vertical, source_.sparse()->inputsAgainst(metres), frame_.height_quantum_m);
    auto dates = proto::Epochs::create(about.shape, {}, proto::EpochBlend::kLinear);
    if (!dates) return dates.error();
    auto objects = makeObjectSection(options_.additions.objects, frame_, *dates, [&](double x, double y) {
      const bool is_inside = x >= 0 && y >= 0 && x <= info.width - 1.0 && y <= info.height - 1.0;
      return is_inside ? std::optional(bilinear(info.width, info.height, x, y, metres)) : std::nullopt;
    });
    if (!objects.ok()) return objects.error();
    about.objects = std::move(*objects);
    return addTiles(ground, about);
  }
  const ImageryReport& imagery() const { return imagery_; }

 private:
  Status addTiles(const StoredHeights& ground, SceneWriter::About& about) {
    auto tiles = TileSection::create(options_.output);
    if (!tiles) return tiles.error();
    tiles_.emplace(std::move(*tiles));
    const SparseGroundBounds bounds(ground, frame_);
    const auto relief = addSparseRelief(ground, bounds, frame_, options_.threads, stage(progress_, "relief"), *tiles_);
    if (!relief) return relief.error();
    if (!*relief) return stopped();
    if (options_.additions.picture != nullptr)
      if (Status s = addPicture(bounds, about.origin); !s.ok()) return s;
    about.tiles = &*tiles_;
    return {};
  }

  Status addPicture(const SparseGroundBounds& bounds, SceneOrigin& origin) {
    const BoundsOf boundsOf = [&](const proto::LatticeBox& box, std::vector<glm::dvec3>&) { return bounds.over(box); };
    const auto report = terrain::addPicture(
        *options_.additions.picture, boundsOf,
        {options_.additions.imagery_quality, options_.additions.attribution, options_.output, options_.threads},
        progress_, origin, *tiles_);
    if (!report) return report.error();
    imagery_ = *report;
    return {};
  }

  const ElevationSource& source_;
  const BuildOptions& options_;
  const proto::Frame& frame_;
  const Progress& progress_;
  std::optional<TileSection> tiles_;
  ImageryReport imagery_;
};

}  // namespace

Result<BuildReport> buildSparseScene(const ElevationSource& source, const BuildOptions& options,
                                     const Progress& progress) {
  const ElevationInfo& info = source.info();
  const SparseHeights& heights = *source.sparse();
  if (Status s = checkOptions(info, options); !s.ok()) return s.error();
  const auto grid = sparseGrid(info.width, info.height, heights.wholeLog2());
  if (!grid.ok()) return grid.error();
  proto::Frame frame = info.frame;
  frame.height_quantum_m = options.height_quantum_m;
  std::atomic<bool> fits{true};
  const auto height = [&](NodeId n) {
    const double h = heights.heightAt(std::min(n.x(), info.width - 1), std::min(n.y(), info.height - 1));
    const auto quanta = quantised(static_cast<float>(h), options.height_quantum_m);
    if (!quanta) fits = false;
    return quanta.value_or(0);
  };
  const auto isWanted = [&](uint32_t spacing, const proto::LatticeWindow& w) { return heights.isFineIn(spacing, w); };
  progress.report("reading", 0);
  std::vector<proto::Slot> pages = pagesWhere(*grid, isWanted);
  progress.report("reading", 1);
  Completion completion(source, options, frame, progress);
  auto report = buildSparseScene(
      {*grid, frame, std::move(pages), height},
      {.output = options.output,
       .threads = options.threads,
       .origin = {info.title, info.crs_wkt, info.notes, info.voids_filled},
       .page_coding = options.additions.page_coding,
       .complete = [&](const StoredHeights& ground, SceneWriter::About& about) { return completion(ground, about); }},
      {.report = progress.report, .keepGoing = [&] { return fits && progress.keepGoing(); }});
  if (!fits)
    return Error{ErrorCode::kLimit, info.title + ": a height does not fit steps of " +
                                        std::to_string(options.height_quantum_m) +
                                        " m; use a larger --vertical-step or name the void value with --nodata"};
  if (!report.ok()) return report;
  report->imagery = completion.imagery();
  report->warnings = source.warnings();
  return report;
}

}  // namespace foreland::terrain
