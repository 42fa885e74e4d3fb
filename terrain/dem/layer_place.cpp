#include "terrain/dem/layer_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>

#include "terrain/dem/mosaic/mosaic_source.h"

namespace foreland::terrain {

namespace {

constexpr int kNet = 33;  // points along each side that places are found out from
constexpr uint32_t kRowsAtOnce = 256;
constexpr uint64_t kMostOfALayer = uint64_t{1} << 32;

// Points spread over samples (0, 0) to `last`, the corners among them.
std::vector<glm::dvec2> netOver(glm::dvec2 last) {
  std::vector<glm::dvec2> net;
  for (int y = 0; y < kNet; ++y)
    for (int x = 0; x < kNet; ++x) net.push_back(last * (glm::dvec2(x, y) / (kNet - 1.0)));
  return net;
}

bool isWithin(glm::dvec2 p, glm::dvec2 last) { return p.x >= 0 && p.y >= 0 && p.x <= last.x && p.y <= last.y; }

glm::dvec2 lastOf(const Mosaic& mosaic) { return {mosaic.width - 1.0, mosaic.height - 1.0}; }
glm::dvec2 lastOf(const LatticePlace& lattice) { return {lattice.width - 1.0, lattice.height - 1.0}; }

// The places of the samples that the lattice and the raster share, on the raster; and the box of the latter.
std::vector<glm::dvec2> survey(const Mosaic& mosaic, const LatticePlace& lattice, LayerPlace& out) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  std::vector<glm::dvec2> own = netOver(lastOf(mosaic)), shared, other = netOver(lastOf(lattice));
  std::vector<glm::dvec2> on_lattice = own;
  out.places.toLattice(on_lattice);
  out.low = glm::dvec2(kFar), out.high = glm::dvec2(-kFar);
  bool all_known = true;
  for (size_t i = 0; i < own.size(); ++i) {
    all_known = all_known && !std::isnan(on_lattice[i].x);
    if (std::isnan(on_lattice[i].x)) continue;
    out.low = glm::min(out.low, on_lattice[i]), out.high = glm::max(out.high, on_lattice[i]);
    if (isWithin(on_lattice[i], lastOf(lattice))) shared.push_back(own[i]);
  }
  if (!all_known) out.low = glm::dvec2(-kFar), out.high = glm::dvec2(kFar);
  out.places.toSamples(other);
  for (const glm::dvec2& p : other)
    if (isWithin(p, lastOf(mosaic))) shared.push_back(p);
  return shared;
}

// Columns and rows of a raster, or a part of it.
struct Crop {
  glm::uvec2 first{0, 0}, size{0, 0};
};

Crop cropTo(const Mosaic& mosaic, const LatticePlace& lattice, const SamplePlaces& places, double margin) {
  const Crop all{{0, 0}, {mosaic.width, mosaic.height}};
  std::vector<glm::dvec2> net = netOver(lastOf(lattice));
  places.toSamples(net);
  glm::dvec2 low = lastOf(mosaic), high(0);
  for (const glm::dvec2& p : net) {
    if (std::isnan(p.x)) return all;
    low = glm::min(low, p), high = glm::max(high, p);
  }
  const glm::dvec2 ring = margin + 4.0 + 0.05 * (high - low);
  low = glm::clamp(glm::floor(low - ring), glm::dvec2(0), lastOf(mosaic) - 1.0);
  high = glm::clamp(glm::ceil(high + ring), low + 1.0, lastOf(mosaic));
  return {glm::uvec2(low), glm::uvec2(high - low) + 1u};
}

}  // namespace

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

namespace {

struct OpenGroup {
  std::optional<int> priority;
  std::vector<Tile> tiles;

  // Insets that lie apart are groups apart, for what is between them would take memory.
  bool takes(const LaidTile& laid) const {
    return priority == laid.priority && isOnOneLattice(tiles.front(), laid.tile) &&
           (!priority || std::ranges::any_of(tiles, [&](const Tile& t) { return touch(t, laid.tile); }));
  }
};

}  // namespace

Result<std::vector<TileGroup>> groupTiles(std::vector<LaidTile> tiles) {
  std::vector<OpenGroup> open;
  for (LaidTile& laid : tiles) {
    OpenGroup* taken = nullptr;
    for (auto group = open.begin(); group != open.end();) {
      if (!group->takes(laid)) {
        ++group;
      } else if (taken == nullptr) {
        taken = &*group++;
      } else {  // it lies between the two
        std::ranges::move(group->tiles, std::back_inserter(taken->tiles));
        group = open.erase(group);  // which lies behind the one that takes its tiles
      }
    }
    if (taken == nullptr) taken = &open.emplace_back(OpenGroup{laid.priority, {}});
    taken->tiles.push_back(std::move(laid.tile));
  }
  std::vector<TileGroup> groups;
  for (OpenGroup& g : open) {
    TileGroup group{g.priority, g.tiles.front().raster->info().name, {}};
    if (g.tiles.size() > 1) group.name += fmt::format(" and {} more", g.tiles.size() - 1);
    auto mosaic = makeMosaic(std::move(g.tiles));
    if (!mosaic.ok()) return mosaic.error();
    group.mosaic = std::move(*mosaic);
    groups.push_back(std::move(group));
  }
  return groups;
}

Result<LayerPlace> placeLayer(const TileGroup& group, const LatticePlace& lattice) {
  const Mosaic& mosaic = group.mosaic;
  auto places = SamplePlaces::of(lattice, mosaic.map, {mosaic.width, mosaic.height}, group.name);
  if (!places.ok()) return places.error();
  LayerPlace out{.places = std::move(*places)};
  const std::vector<glm::dvec2> shared = survey(mosaic, lattice, out);
  std::vector<double> columns, rows;
  for (const glm::dvec2& p : shared) {
    std::vector<glm::dvec2> around{p, p + glm::dvec2(1, 0), p + glm::dvec2(0, 1)};
    out.places.toLattice(around);
    if (std::isnan(around[0].x + around[1].x + around[2].x)) continue;
    columns.push_back(glm::distance(around[0], around[1]));
    rows.push_back(glm::distance(around[0], around[2]));
  }
  out.meets_lattice = !columns.empty();
  if (out.meets_lattice) out.spacing = {medianOf(columns), medianOf(rows)};
  return out;
}

Result<Layer> readLayer(TileGroup& group, const LayerPlace& place, const LatticePlace& lattice, uint32_t margin,
                        std::vector<std::string>& warnings) {
  const Crop crop = cropTo(group.mosaic, lattice, place.places, margin);
  if (uint64_t{crop.size.x} * crop.size.y > kMostOfALayer)
    return Error{ErrorCode::kLimit,
                 fmt::format("{}: {} x {} of its samples lie on the scene, more than 2^32; make it coarser with "
                             "gdal_translate -tr",
                             group.name, crop.size.x, crop.size.y)};
  ElevationInfo info;
  info.width = group.mosaic.width;
  info.height = group.mosaic.height;
  RasterPlacement as_in_the_file;
  as_in_the_file.is_row_reversed = false;
  const auto source = mosaicSource(std::move(group.mosaic), as_in_the_file, std::move(info));
  const uint32_t width = source->info().width;
  Layer layer;
  layer.name = group.name;
  layer.samples = {crop.size.x, crop.size.y, {}};
  layer.samples.metres.reserve(size_t{crop.size.x} * crop.size.y);
  std::vector<float> rows;
  for (uint32_t row = 0; row < crop.size.y; row += kRowsAtOnce) {
    const uint32_t count = std::min(kRowsAtOnce, crop.size.y - row);
    rows.resize(size_t{count} * width);
    if (Status s = source->readRows(crop.first.y + row, count, rows); !s.ok()) return s.error();
    for (uint32_t i = 0; i < count; ++i) {
      const auto from = rows.begin() + static_cast<std::ptrdiff_t>(size_t{i} * width + crop.first.x);
      layer.samples.metres.insert(layer.samples.metres.end(), from, from + crop.size.x);
    }
  }
  for (const std::string& warning : source->warnings()) warnings.push_back(warning);
  const auto places = std::make_shared<const SamplePlaces>(place.places);
  const glm::dvec2 first(crop.first);
  layer.to_samples = [places, first](std::span<glm::dvec2> positions) {
    places->toSamples(positions);
    for (glm::dvec2& p : positions) p -= first;
  };
  layer.to_lattice = [places, first](std::span<glm::dvec2> positions) {
    for (glm::dvec2& p : positions) p += first;
    places->toLattice(positions);
  };
  // A net over curved borders misses a little of them.
  const glm::dvec2 ring = place.spacing + 0.02 * (place.high - place.low);
  layer.low = place.low - ring, layer.high = place.high + ring;
  return layer;
}

}  // namespace foreland::terrain
