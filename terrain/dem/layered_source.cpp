#include "terrain/dem/layered_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "terrain/dem/insets/feather.h"
#include "terrain/dem/insets/refined_tiles.h"
#include "terrain/dem/layer_place.h"
#include "terrain/dem/mosaic/mosaic_source.h"
#include "terrain/dem/mosaic_info.h"
#include "terrain/geo/geodesy.h"

namespace foreland::terrain {

namespace {

constexpr double kMostHalvings = 30;  // far more than a scene holds
constexpr int kFinerThanInsets = 2;   // halvings beyond the finest inset's resolution that a residual may ask for
constexpr uint64_t kMostOfAScene = uint64_t{1} << 32, kMostOfASparseScene = uint64_t{1} << 37,
                   kMostOfItsSide = 1u << 20;
// A lattice is whole up to so many positions, or to so many for each that somebody knows something of.
constexpr uint64_t kSmall = uint64_t{1} << 22, kPositionsForData = 4;
constexpr uint32_t kRowsOfBase = 256;

struct PlacedGroup {
  TileGroup group;
  LayerPlace place;
  double feather_m = 0;
  std::vector<ElevationInput> inputs{};  // windows on the base's lattice

  // Whether it lies below the base: insets where they are coarser, other inputs where they are not finer.
  bool isBelow() const { return place.resolution() > (group.priority ? kAlike : 1 / kAlike); }
  // So often the base's lattice is halved until it is as fine.
  int ownDepth() const {
    return static_cast<int>(std::clamp(std::ceil(-std::log2(place.resolution() * kAlike)), 0.0, kMostHalvings));
  }
};

// The base with its place.
struct Base {
  Mosaic mosaic;
  RasterPlacement placement;
  LatticePlace lattice;
};

Status place(Base& base, const OpenOptions& options) {
  const Mosaic& m = base.mosaic;
  auto placement = placeRaster(m.map, {titleOf(m), m.width, m.height, 0, 0}, options);
  if (!placement.ok()) return placement.error();
  base.placement = std::move(*placement);
  base.lattice = {base.placement.frame, m.width, m.height, m.map.crs_wkt, m.tiles.front().raster->info().name};
  return {};
}

Result<std::vector<PlacedGroup>> placeGroups(std::vector<TileGroup> groups, const LatticePlace& lattice) {
  std::vector<PlacedGroup> placed;
  for (TileGroup& group : groups) {
    auto place = placeLayer(group, lattice);
    if (!place.ok()) return place.error();
    placed.push_back({.group = std::move(group), .place = std::move(*place)});
  }
  return placed;
}

// Widens the base's lattice to hold other inputs; insets do not count. False if it holds them.
Result<bool> extend(Base& base, const std::vector<PlacedGroup>& groups) {
  Mosaic& m = base.mosaic;
  glm::dvec2 low(0), high(m.width - 1.0, m.height - 1.0);
  std::string widest;
  for (const PlacedGroup& g : groups) {
    if (g.group.priority || !std::isfinite(g.place.low.x + g.place.low.y + g.place.high.x + g.place.high.y)) continue;
    // What lies less than a hundredth of a sample outside is rounding.
    const glm::dvec2 as_it_was = high - low;
    low = glm::min(low, glm::floor(g.place.low + 0.01)), high = glm::max(high, glm::ceil(g.place.high - 0.01));
    if (high - low != as_it_was) widest = g.group.name;
  }
  const glm::dvec2 size = high - low + 1.0;
  if (std::max(size.x, size.y) > kMostOfItsSide || size.x * size.y > kMostOfAScene)
    return Error{
        ErrorCode::kLimit,
        fmt::format(
            "{} and {}: together {:.0f} x {:.0f} samples, more than a scene holds; leave out what lies far away",
            base.lattice.name, widest, size.x, size.y)};
  const glm::uvec2 before(-low), after(glm::uvec2(size) - glm::uvec2(m.width, m.height) - before);
  if (before + after == glm::uvec2(0)) return false;
  const uint32_t columns = base.placement.is_column_reversed ? after.x : before.x,
                 rows = base.placement.is_row_reversed ? after.y : before.y;
  m.width += before.x + after.x, m.height += before.y + after.y;
  for (Tile& tile : m.tiles) tile.column += columns, tile.row += rows;
  auto& t = m.map.transform;
  t[0] -= columns * t[1] + rows * t[2];
  t[3] -= columns * t[4] + rows * t[5];
  return true;
}

// The groups where they are on the widened lattice.
Status placeAnew(Base& base, std::vector<PlacedGroup>& groups, const OpenOptions& options) {
  if (Status s = place(base, options); !s.ok()) return s;
  for (PlacedGroup& g : groups) {
    auto anew = placeLayer(g.group, base.lattice);
    if (!anew.ok()) return anew.error();
    g.place = std::move(*anew);
  }
  return {};
}

Status checkPlaces(const std::vector<PlacedGroup>& groups, const Base& base) {
  for (const PlacedGroup& g : groups)
    if (g.group.priority && !g.place.meets_lattice)
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{}: it lies beyond {}; name insets of the same place, or name it as another input and "
                               "not as an --inset",
                               g.group.name, base.lattice.name)};
  return {};
}

// The window of a group's tile on the lattice; empty where they share nothing.
proto::LatticeWindow windowOf(const Tile& tile, const LayerPlace& place, const LatticePlace& lattice) {
  constexpr uint32_t kSteps = 32;
  std::vector<glm::dvec2> net;
  const glm::dvec2 first(tile.column, tile.row),
      size(tile.raster->info().width - 1.0, tile.raster->info().height - 1.0);
  for (uint32_t y = 0; y <= kSteps; ++y)
    for (uint32_t x = 0; x <= kSteps; ++x) net.push_back(first + size * glm::dvec2(x, y) / double(kSteps));
  place.places.toLattice(net);
  const glm::dvec2 last(lattice.width - 1.0, lattice.height - 1.0);
  glm::dvec2 low = last, high(0);
  for (const glm::dvec2& p : net) {
    if (std::isnan(p.x)) return {0, 0, lattice.width, lattice.height};
    low = glm::min(low, p), high = glm::max(high, p);
  }
  low = glm::max(glm::floor(low), glm::dvec2(0)), high = glm::min(glm::ceil(high), last);
  if (!(low.x <= high.x && low.y <= high.y)) return {};
  const glm::uvec2 at(low), count = glm::uvec2(high - low) + 1u;
  return {at.x, at.y, count.x, count.y};
}

std::vector<ElevationInput> inputsOf(const PlacedGroup& g, const LatticePlace& lattice) {
  std::vector<ElevationInput> inputs;
  for (const Tile& tile : g.group.mosaic.tiles)
    if (const auto window = windowOf(tile, g.place, lattice); !window.isEmpty())
      inputs.push_back({.name = std::filesystem::path(tile.raster->info().name).filename().string(),
                        .window = window,
                        .vertical = tile.vertical,
                        .may_have_voids = true,
                        .is_on_lattice = false,
                        .feather_m = g.feather_m});
  return inputs;
}

// Insets of a higher priority lie over others, and all over other inputs.
auto rankOf(const PlacedGroup& g) {
  return std::tuple(!g.isBelow(), g.group.priority.has_value(), g.group.priority.value_or(0));
}

double featherOf(const PlacedGroup& g, glm::dvec2 base_spacing_m, const OpenOptions& options) {
  if (options.feather_m) return *options.feather_m;
  const glm::dvec2 sides = glm::dvec2(g.group.mosaic.width, g.group.mosaic.height) * g.place.spacing;
  const double spacing_m = std::min(base_spacing_m.x, base_spacing_m.y);
  return spacing_m * defaultFeather(sides);
}

Result<Samples> readBase(Base base, const ElevationInfo& info, std::vector<std::string>& warnings) {
  const auto source = mosaicSource(std::move(base.mosaic), base.placement, info);
  Samples out{info.width, info.height, std::vector<float>(size_t{info.width} * info.height)};
  for (uint32_t row = 0; row < out.height; row += kRowsOfBase) {
    const uint32_t count = std::min(kRowsOfBase, out.height - row);
    const auto rows = std::span(out.metres).subspan(size_t{row} * out.width, size_t{count} * out.width);
    if (Status s = source->readRows(row, count, rows); !s.ok()) return s.error();
  }
  for (const std::string& warning : source->warnings()) warnings.push_back(warning);
  return out;
}

void addTitle(const PlacedGroup& g, ElevationInfo& info) {
  if (info.title.size() <= 200) info.title += ", " + titleOf(g.group.mosaic);
}

std::string ballparkWarning(const PlacedGroup& g, const Base& base) {
  return fmt::format(
      "{} and {}: PROJ knows no exact transformation between their reference systems on this machine, so "
      "places may be off by up to 200 m; `projsync --file` or the package proj-data brings the grids",
      base.lattice.name, g.group.name);
}

class LayeredSource final : public ElevationSource, public SparseHeights {
 public:
  LayeredSource(LayerStack stack, std::vector<PlacedGroup> groups, ElevationInfo info,
                std::vector<std::string> warnings)
      : stack_(std::move(stack)), groups_(std::move(groups)), info_(std::move(info)), warnings_(std::move(warnings)) {}

  // Halves the lattice as often as the layers need.
  Status refine(const OpenOptions& options, const std::string& base_name);

  const ElevationInfo& info() const override { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    CHECK_EQ(out.size(), size_t{count} * info_.width);
    for (uint32_t i = 0; i < count; ++i) tiles_->readRow(first + i, out.subspan(size_t{i} * info_.width, info_.width));
    return {};
  }
  std::vector<std::string> warnings() const override { return warnings_; }

  const SparseHeights* sparse() const override { return is_sparse_ ? this : nullptr; }
  uint32_t wholeLog2() const override { return static_cast<uint32_t>(depth_); }
  bool isFineIn(uint32_t spacing, const proto::LatticeWindow& window) const override {
    return tiles_->isFineIn(spacing, {window.x, window.y}, {window.width, window.height});
  }
  double heightAt(uint32_t x, uint32_t y) const override { return tiles_->heightAt({x, y}); }
  std::vector<ElevationInput> inputsAgainst(
      const std::function<double(uint32_t x, uint32_t y)>& surface) const override;

 private:
  glm::u64vec2 sizeAt(int depth) const;
  bool isSparseAt(int depth, const OpenOptions& options) const;
  std::vector<int> depthsAt(int depth, const OpenOptions& options) const;
  Status checkSize(int depth, const OpenOptions& options, const std::string& base_name) const;
  void fillVoids();
  void refineInfo(int depth);
  std::vector<ElevationInput> allInputs(const std::vector<LayerResidual>& residuals) const;
  void describeLayers(const OpenOptions& options);
  void warn(const std::vector<Overlap>& overlaps, const std::string& base_name);

  LayerStack stack_;
  std::vector<PlacedGroup> groups_;  // of the stack's layers
  ElevationInfo info_;
  std::vector<std::string> warnings_;
  std::unique_ptr<RefinedTiles> tiles_;
  std::vector<ElevationInput> of_base_;
  int depth_ = 0;  // so often the base's lattice was halved
  bool is_sparse_ = false;
};

glm::u64vec2 LayeredSource::sizeAt(int depth) const {
  return {(uint64_t{stack_.base.width - 1} << depth) + 1, (uint64_t{stack_.base.height - 1} << depth) + 1};
}

// Of a lattice that is halved so often.
bool LayeredSource::isSparseAt(int depth, const OpenOptions& options) const {
  if (depth == 0 || options.lattice == LatticeChoice::kWhole) return false;
  if (options.lattice == LatticeChoice::kSparse) return true;
  const glm::dvec2 size(sizeAt(depth));
  const std::vector<int> depths = depthsAt(depth, options);
  const glm::dvec2 last(stack_.base.width - 1.0, stack_.base.height - 1.0);
  double known = (last.x + 1) * (last.y + 1);
  for (size_t i = stack_.below; i < stack_.layers.size(); ++i) {
    const glm::dvec2 on_base = glm::min(stack_.layers[i].high, last) - glm::max(stack_.layers[i].low, glm::dvec2(0));
    known += std::max(on_base.x, 0.0) * std::max(on_base.y, 0.0) * std::ldexp(1.0, 2 * depths[i]);
  }
  return size.x * size.y > std::max(kSmall, kPositionsForData * static_cast<uint64_t>(known));
}

// So many halvings each layer takes.
std::vector<int> LayeredSource::depthsAt(int depth, const OpenOptions& options) const {
  std::vector<int> depths;
  for (const PlacedGroup& g : groups_)
    depths.push_back(std::min(depth, g.isBelow() ? 0 : g.ownDepth() + (options.residual_m ? kFinerThanInsets : 0)));
  return depths;
}

Status LayeredSource::checkSize(int depth, const OpenOptions& options, const std::string& base_name) const {
  const glm::u64vec2 size = sizeAt(depth);
  const bool is_sparse = isSparseAt(depth, options);
  const uint64_t most = is_sparse ? kMostOfASparseScene : kMostOfAScene;
  if (std::max(size.x, size.y) <= kMostOfItsSide && size.x * size.y < most) return {};
  const auto finest = std::ranges::min_element(
      groups_, {}, [](const PlacedGroup& g) { return g.isBelow() ? 1e300 : g.place.resolution(); });
  return Error{
      ErrorCode::kLimit,
      fmt::format("{} and {}: at the resolution of the second the first has {} x {} samples; a scene {} at "
                  "most 2^20 a side and 2^{} in all. Cut out the surroundings of the second with "
                  "gdal_translate -projwin, or allow a larger --residual",
                  base_name, finest->group.name, size.x, size.y,
                  is_sparse || options.lattice == LatticeChoice::kAuto ? "holds" : "that changes in time holds",
                  is_sparse ? 37 : 32)};
}

void LayeredSource::fillVoids() {
  if (std::ranges::none_of(stack_.base.metres, [](float h) { return std::isnan(h); })) return;
  FilledBase filled = fillBase(stack_);
  if (!filled.note.empty()) info_.notes.push_back(filled.note);
  info_.voids_filled = filled.filled;
  stack_.bottom = std::move(filled.samples);
}

Status LayeredSource::refine(const OpenOptions& options, const std::string& base_name) {
  int own = 0;
  for (const PlacedGroup& g : groups_)
    if (!g.isBelow()) own = std::max(own, g.ownDepth());
  const int most = options.residual_m ? own + kFinerThanInsets : own;
  const double bound_m = options.residual_m.value_or(0);
  std::vector<Overlap> overlaps;
  for (depth_ = options.residual_m ? 0 : own;; ++depth_) {
    if (Status s = checkSize(depth_, options, base_name); !s.ok()) {
      if (depth_ <= own) return s;
      --depth_;  // which holds
      break;
    }
    if (depth_ > 0 && stack_.bottom.metres.empty()) fillVoids();
    overlaps.assign(stack_.layers.size(), {});
    is_sparse_ = isSparseAt(depth_, options);
    tiles_ = std::make_unique<RefinedTiles>(
        stack_,
        RefinedTiles::Options{
            .depth = depth_,
            .depths = is_sparse_ ? depthsAt(depth_, options) : std::vector<int>(stack_.layers.size(), depth_),
            .residual_m = bound_m,
            .is_sparse = is_sparse_},
        overlaps);
    if (depth_ == most || std::ranges::all_of(tiles_->residuals(), [&](const LayerResidual& r) {
          return r.largest_m.value_or(0) <= bound_m;
        }))
      break;
  }
  refineInfo(depth_);
  describeLayers(options);
  warn(overlaps, base_name);
  return {};
}

void LayeredSource::refineInfo(int depth) {
  const double times = std::ldexp(1.0, depth);
  info_.width = tiles_->size().x;
  info_.height = tiles_->size().y;
  proto::Frame& f = info_.frame;
  f.anchor *= times;
  f.axis_x_m /= times;
  f.axis_y_m /= times;
  f.latitude_step_rad /= times;
  f.longitude_step_rad /= times;
  info_.vertical.undulations.first *= times;
  info_.vertical.undulations.step *= times;
  const auto refine = [&](std::vector<ElevationInput>& inputs) {
    for (ElevationInput& input : inputs) {
      proto::LatticeWindow& w = input.window;
      w.x <<= depth, w.y <<= depth;
      w.width = ((w.width - 1) << depth) + 1, w.height = ((w.height - 1) << depth) + 1;
    }
  };
  refine(info_.inputs);
  for (PlacedGroup& g : groups_) refine(g.inputs);
}

// The uppermost comes first.
std::vector<ElevationInput> LayeredSource::allInputs(const std::vector<LayerResidual>& residuals) const {
  std::vector<ElevationInput> inputs;
  for (size_t i = groups_.size(); i-- > 0;) {
    if (i + 1 == stack_.below) inputs.insert(inputs.end(), of_base_.begin(), of_base_.end());
    for (ElevationInput input : groups_[i].inputs) {
      input.residual_m = residuals[i].largest_m.value_or(input.residual_m);
      inputs.push_back(std::move(input));
    }
  }
  if (stack_.below == 0) inputs.insert(inputs.end(), of_base_.begin(), of_base_.end());
  return inputs;
}

std::vector<ElevationInput> LayeredSource::inputsAgainst(
    const std::function<double(uint32_t x, uint32_t y)>& surface) const {
  return allInputs(tiles_->residualsAgainst([&](glm::uvec2 at) { return surface(at.x, at.y); }));
}

void LayeredSource::describeLayers(const OpenOptions& options) {
  for (size_t i = groups_.size(); i-- > 0;) {
    const PlacedGroup& g = groups_[i];
    const LayerResidual& residual = tiles_->residuals()[i];
    const std::string name = std::filesystem::path(g.group.name).filename().string();
    info_.notes.push_back(
        name +
        (g.isBelow() ? ": it is not finer than the base, so it shows only where that has no data"
                     : ": it was laid over the base") +
        fmt::format("; its edges are mixed with what is below over {:.4g} m, and ", g.feather_m) +
        (residual.largest_m
             ? fmt::format("where it alone counts the scene was within {:.3g} m of {} of its samples, before "
                           "heights were rounded",
                           *residual.largest_m, residual.samples)
             : std::string("nowhere does it count alone")));
    if (options.residual_m && residual.largest_m.value_or(0) > *options.residual_m)
      warnings_.push_back(fmt::format(
          "{}: the scene is up to {:.3g} m off its samples, more than the {:g} m that were asked for; a finer "
          "lattice would be more than {} times as fine as they are",
          name, *residual.largest_m, *options.residual_m, 1 << kFinerThanInsets));
  }
  of_base_ = std::move(info_.inputs);
  info_.inputs = allInputs(tiles_->residuals());
}

void LayeredSource::warn(const std::vector<Overlap>& overlaps, const std::string& base_name) {
  for (size_t i = 0; i < overlaps.size(); ++i)
    if (const auto doubt = overlaps[i].doubt())
      warnings_.push_back(base_name + " and " + groups_[i].group.name + " do not agree where they overlap: " + *doubt);
}

}  // namespace

Result<std::unique_ptr<ElevationSource>> layeredSource(Mosaic mosaic, std::vector<LaidTile> tiles,
                                                       const OpenOptions& options, const std::optional<Datum>& datum,
                                                       std::vector<std::string> notes) {
  Base base{std::move(mosaic), {}, {}};
  if (Status s = place(base, options); !s.ok()) return s.error();
  auto grouped = groupTiles(std::move(tiles));
  if (!grouped.ok()) return grouped.error();
  auto placed = placeGroups(std::move(*grouped), base.lattice);
  if (!placed.ok()) return placed.error();
  const auto is_wider = extend(base, *placed);
  if (!is_wider.ok()) return is_wider.error();
  if (*is_wider)
    if (Status s = placeAnew(base, *placed, options); !s.ok()) return s.error();
  if (Status s = checkPlaces(*placed, base); !s.ok()) return s.error();
  sortUpwards(*placed, rankOf);
  auto info = describeMosaic(base.mosaic, base.placement, datum, InputList::kAlways, std::move(notes));
  if (!info.ok()) return info.error();
  const glm::dvec2 spacing_m = sampleSpacing(info->frame, info->width, info->height);
  std::vector<std::string> warnings;
  LayerStack stack;
  for (PlacedGroup& g : *placed) {
    g.feather_m = featherOf(g, spacing_m, options);
    g.inputs = inputsOf(g, base.lattice);
    addTitle(g, *info);
    info->notes.insert(info->notes.end(), g.group.mosaic.notes.begin(), g.group.mosaic.notes.end());
    if (g.place.places.isBallpark()) warnings.push_back(ballparkWarning(g, base));
    const glm::dvec2 own_spacing_m = g.place.spacing * spacing_m;
    const auto margin = static_cast<uint32_t>(std::min(1e6, g.feather_m / std::min(own_spacing_m.x, own_spacing_m.y)));
    auto layer = readLayer(g.group, g.place, base.lattice, margin, warnings);
    if (!layer.ok()) return layer.error();
    layer->weights = featherWeights(layer->samples, own_spacing_m, g.feather_m);
    stack.layers.push_back(std::move(*layer));
    stack.below += g.isBelow();
  }
  const std::string name = base.lattice.name;
  auto samples = readBase(std::move(base), *info, warnings);
  if (!samples.ok()) return samples.error();
  stack.base = std::move(*samples);
  if (stack.below > 0) {
    const double feather_m = placed->front().feather_m;
    stack.base_weights = featherWeights(stack.base, spacing_m, feather_m);
    for (ElevationInput& input : info->inputs) input.feather_m = feather_m;
  }
  auto source =
      std::make_unique<LayeredSource>(std::move(stack), std::move(*placed), std::move(*info), std::move(warnings));
  if (Status s = source->refine(options, name); !s.ok()) return s.error();
  return std::unique_ptr<ElevationSource>(std::move(source));
}

}  // namespace foreland::terrain
