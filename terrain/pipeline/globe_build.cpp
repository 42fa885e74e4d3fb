#include "terrain/pipeline/globe_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "proto/space/cube_map.h"
#include "proto/space/frame.h"
#include "terrain/imagery/globe_imagery.h"
#include "terrain/imagery/globe_relief.h"
#include "terrain/pipeline/globe_refinement.h"
#include "terrain/pipeline/globe_residual.h"
#include "terrain/pipeline/scene_parts.h"
#include "terrain/pipeline/sparse_build.h"
#include "terrain/store/bilinear.h"

namespace foreland::terrain {

namespace {

using proto::GridTopology;
using proto::NodeId;

constexpr double kAlike = 1.01;      // resolutions that differ by less are the same
constexpr uint32_t kCoarsest = 6;    // whole levels go down to this at least: then a page is on one face
constexpr uint32_t kMostWhole = 13;  // 4e8 vertices
// Drawn meshes name their vertices by lattice positions in floats (KeyframeMesh::parameters), which are exact up to
// 2^24: those of six faces of 2^21 steps are. With 2^22 odd columns beyond the fourth face would get their neighbours'
// names.
constexpr uint32_t kMostDeep = 21;
static_assert((6u << kMostDeep) < 1u << 24 && kMostDeep <= GridTopology::kMaxCubeLog2);
constexpr uint32_t kFinerThanInsets = 2;  // halvings beyond an inset's resolution that a residual may ask for
constexpr uint32_t kNet = 9;              // directions along each side of a patch

uint32_t log2For(double quarter_m, double spacing_m) {
  return std::max(kCoarsest,
                  static_cast<uint32_t>(std::max(0.0, std::ceil(std::log2(quarter_m / (spacing_m * kAlike))))));
}

double quarterOf(const GlobeInfo& info) { return 0.5 * std::numbers::pi * info.semi_major_m; }

// Steps along a face where an input alone counts, as a power of two.
uint32_t deepestOf(const GlobeInfo& info, size_t input, bool has_residual) {
  const uint32_t own = log2For(quarterOf(info), info.inputs[input].spacing_m);
  const bool may_be_finer = has_residual && input + 1 < info.inputs.size();
  return may_be_finer ? std::max(own, std::min(own + kFinerThanInsets, kMostDeep)) : own;
}

// The directions of a window of the lattice, which lies on one face, and of as much again as a node's support reaches.
GlobePatch patchOf(const GridTopology& grid, uint32_t spacing, const proto::LatticeWindow& window) {
  const uint32_t k = grid.shape().root_log2, face = window.x >> k;
  const double step = 2.0 / grid.rootSize(), x = window.x - (face << k);
  const glm::dvec2 low(x - spacing, 1.0 * window.y - spacing),
      size(window.width - 1.0 + 2 * spacing, window.height - 1.0 + 2 * spacing);
  const auto direction = [&](double u, double v) {
    const glm::dvec2 at = (low + size * glm::dvec2(u, v)) * step - 1.0;
    return proto::cubeVector({face, at.x, at.y});
  };
  GlobePatch patch{.middle = glm::normalize(direction(0.5, 0.5)), .angle_rad = 0, .side = kNet, .directions = {}};
  for (uint32_t j = 0; j < kNet; ++j)
    for (uint32_t i = 0; i < kNet; ++i) {
      const glm::dvec3 d = direction(i / (kNet - 1.0), j / (kNet - 1.0));
      patch.directions.push_back(d);
      patch.angle_rad =
          std::max(patch.angle_rad, std::atan2(glm::length(glm::cross(patch.middle, d)), glm::dot(patch.middle, d)));
    }
  return patch;
}

// Pages whose nodes stand in for something: as long as nodes twice as far apart would be further apart than samples.
std::vector<proto::Slot> pagesOf(const GlobeSource& source, const GridTopology& grid) {
  const double step_m = quarterOf(source.info()) / grid.rootSize();
  return pagesWhere(grid, [&](uint32_t spacing, const proto::LatticeWindow& tile) {
    return 2 * spacing * step_m > kAlike * source.spacingIn(patchOf(grid, spacing, tile));
  });
}

SceneDatum datumOf(const GlobeInfo& info, const GridTopology& grid, const std::vector<double>& residuals_m,
                   double height_quantum_m) {
  SceneDatum datum{info.vertical, {}};
  const proto::GridShape& shape = grid.shape();
  for (size_t i = 0; i < info.inputs.size(); ++i)
    for (const std::string& file : info.inputs[i].files)
      datum.inputs.push_back({.name = file,
                              .vertical = info.inputs[i].vertical,
                              .window = {0, 0, shape.samples_x, shape.samples_y},
                              .may_have_voids = i + 1 < info.inputs.size(),
                              .residual_m = residuals_m[i] + 0.5 * height_quantum_m,
                              .feather_m = info.inputs[i].feather_m});
  return datum;
}

std::vector<int> deepestLevels(const GlobeInfo& info) {
  std::vector<int> levels;
  for (size_t i = 0; i < info.inputs.size(); ++i) levels.push_back(2 * static_cast<int>(deepestOf(info, i, true)) - 1);
  return levels;
}

// Heights are rounded here, but not where the residual is asked for.
void warnOfResiduals(const GlobeInfo& info, const std::vector<double>& found_m, double asked_m, double quantum_m,
                     std::vector<std::string>& warnings) {
  for (size_t i = 0; i + 1 < info.inputs.size(); ++i)
    if (found_m[i] > asked_m + 0.5 * quantum_m)
      warnings.push_back(fmt::format(
          "{}: the globe is up to {:.3g} m off its samples, more than the {:g} m that were asked for; a finer lattice "
          "would be more than {} times as fine as they are, or finer than a globe can be",
          info.inputs[i].files.front(), found_m[i], asked_m, 1 << kFinerThanInsets));
}

// The tiles of a globe, which follow from its ground.
class GlobeTiles {
 public:
  GlobeTiles(const GlobeOptions& options, const proto::Frame& frame, const Progress& progress)
      : options_(options), frame_(frame), progress_(progress) {}

  Status add(const StoredHeights& ground, SceneWriter::About& about) {
    about.has_sea = options_.has_sea;
    if (Status s = addObjects(ground, about); !s.ok()) return s;
    auto tiles = TileSection::create(options_.output);
    if (!tiles) return tiles.error();
    tiles_.emplace(std::move(*tiles));
    const SparseGroundBounds bounds(ground, frame_);
    const auto relief =
        addGlobeRelief(ground, bounds, frame_, options_.output, options_.threads, stage("relief"), *tiles_);
    if (!relief) return relief.error();
    if (!*relief) return stopped();
    if (options_.picture != nullptr)
      if (Status s = addPicture(bounds, about.origin); !s.ok()) return s;
    about.tiles = &*tiles_;
    return {};
  }
  const ImageryReport& imagery() const { return imagery_; }

 private:
  KeepGoing stage(std::string_view name) const {
    progress_.report(name, 0);
    return [this, name](double fraction) {
      progress_.report(name, fraction);
      return progress_.keepGoing();
    };
  }
  // On the ground between samples as triangles have it, but for the choice of their diagonals.
  Status addObjects(const StoredHeights& ground, SceneWriter::About& about) const {
    auto dates = proto::Epochs::create(about.shape, {}, proto::EpochBlend::kLinear);
    if (!dates) return dates.error();
    auto objects = makeObjectSection(options_.objects, frame_, *dates, [&](double x, double y) {
      const uint32_t steps = frame_.face_steps, face = std::min(static_cast<uint32_t>(x / steps), 5u);
      const auto metres = [&](uint32_t i, uint32_t j) {
        return ground.exactAt(ground.grid().nameIn(face, NodeId::at(face * steps + i, j))) * frame_.height_quantum_m;
      };
      return std::optional(bilinear(steps + 1, steps + 1, x - 1.0 * face * steps, y, metres));
    });
    if (!objects.ok()) return objects.error();
    about.objects = std::move(*objects);
    return {};
  }
  Status addPicture(const SparseGroundBounds& bounds, SceneOrigin& origin) {
    const BoundsOf boundsOf = [&](const proto::LatticeBox& box, std::vector<glm::dvec3>&) { return bounds.over(box); };
    const ImageryOptions how{options_.imagery_quality, options_.attribution, options_.output, options_.threads};
    const auto report = addGlobeImagery(*options_.picture, frame_.face_steps, boundsOf, how, stage("imagery"), *tiles_);
    if (!report) return report.error();
    if (!report->is_complete) return stopped();
    imagery_ = *report;
    describePicture(options_.picture->notes(), imagery_, origin);
    return {};
  }

  const GlobeOptions& options_;
  const proto::Frame& frame_;
  const Progress& progress_;
  std::optional<TileSection> tiles_;
  ImageryReport imagery_;
};

Error stoppedEarly() { return {ErrorCode::kIo, "stopped before the scene was complete; nothing was written"}; }

}  // namespace

Result<GlobeDepth> depthOf(const GlobeInfo& info, std::optional<double> residual_m) {
  GlobeDepth depth{.whole_log2 = deepestOf(info, info.inputs.size() - 1, false), .deepest_log2 = 0};
  for (size_t i = 0; i < info.inputs.size(); ++i)
    depth.deepest_log2 = std::max(depth.deepest_log2, deepestOf(info, i, residual_m.has_value()));
  if (depth.whole_log2 > kMostWhole)
    return Error{ErrorCode::kLimit, info.title + ": its samples are " + std::to_string(info.inputs.back().spacing_m) +
                                        " m apart, and a globe is at most " +
                                        std::to_string(quarterOf(info) / (1 << kMostWhole)) +
                                        " m fine everywhere; give what is finer as an --inset"};
  if (depth.deepest_log2 > kMostDeep)
    return Error{ErrorCode::kLimit,
                 info.title + ": an inset's samples are less than " +
                     std::to_string(quarterOf(info) / (1 << kMostDeep)) +
                     " m apart, which is the finest that a globe can be; make it coarser with gdal_translate -tr"};
  return depth;
}

Result<BuildReport> buildGlobe(const GlobeSource& source, const GlobeOptions& options, const Progress& progress) {
  const GlobeInfo& info = source.info();
  if (!(options.height_quantum_m > 0) || !std::isfinite(options.height_quantum_m))
    return Error{ErrorCode::kInvalidArgument, "the vertical step must be a positive number of metres"};
  const auto depth = depthOf(info, options.residual_m);
  if (!depth.ok()) return depth.error();
  const auto grid =
      GridTopology::create(GridTopology::cubeShape(depth->deepest_log2, 2 * (depth->deepest_log2 - depth->whole_log2)));
  if (!grid.ok()) return grid.error();
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGlobe;
  frame.height_quantum_m = options.height_quantum_m;
  frame.semi_major_m = info.semi_major_m;
  frame.flattening = info.flattening;
  frame.face_steps = grid->rootSize();
  const proto::FrameTransform transform(frame);
  const auto height = [&](NodeId v) {
    const proto::CubePlace p = grid->cube().placeOf(v);
    const double step = 2.0 / grid->rootSize();
    const glm::dvec3 direction = proto::cubeVector({p.face, p.x * step - 1, p.y * step - 1});
    return static_cast<int32_t>(
        std::lround(std::clamp(source.heightAt(direction).metres / options.height_quantum_m, -4e6, 4e6)));
  };
  const auto stage = [&](std::string_view name) {
    return [&progress, name](double fraction) {
      progress.report(name, fraction);
      return progress.keepGoing();
    };
  };
  progress.report("choosing", 0);
  auto chosen = options.residual_m ? pagesWithin(*options.residual_m, source, *grid, frame, deepestLevels(info),
                                                 options.threads, stage("choosing"))
                                   : std::optional(pagesOf(source, *grid));
  if (!chosen) return stoppedEarly();
  std::vector<proto::Slot> pages = std::move(*chosen);
  const auto residuals_m = globeResiduals(source, *grid, frame, pages, height, options.threads, stage("comparing"));
  if (!residuals_m) return stoppedEarly();
  SceneOrigin origin{.title = info.title, .crs_wkt = {}, .notes = info.notes, .voids_filled = info.voids_filled};
  GlobeTiles tiles(options, frame, progress);
  auto report = buildSparseScene(
      {*grid, frame, std::move(pages), height},
      {options.output, options.threads, std::move(origin), datumOf(info, *grid, *residuals_m, options.height_quantum_m),
       options.page_coding,
       [&](const StoredHeights& ground, SceneWriter::About& about) { return tiles.add(ground, about); }},
      progress);
  if (!report.ok()) return report;
  report->warnings = info.warnings;
  if (options.residual_m)
    warnOfResiduals(info, *residuals_m, *options.residual_m, options.height_quantum_m, report->warnings);
  report->imagery = tiles.imagery();
  return report;
}

}  // namespace foreland::terrain
