#include "terrain/dem/compare_source.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "terrain/dem/datum.h"
#include "terrain/dem/insets/feather.h"
#include "terrain/dem/layer_place.h"
#include "terrain/dem/tiles.h"
#include "terrain/geo/geodesy.h"

namespace foreland::terrain {

namespace {

bool isUnder(const std::vector<proto::LatticeWindow>& windows, glm::dvec2 p) {
  return std::ranges::any_of(windows, [&](const proto::LatticeWindow& w) {
    const glm::dvec2 low(w.x, w.y), high = low + glm::dvec2(w.width, w.height);
    return p.x > low.x - 1 && p.y > low.y - 1 && p.x < high.x && p.y < high.y;
  });
}

double differenceAt(const LatticeHeights& scene, glm::dvec2 p, double height_m) {
  const glm::uvec2 last(scene.lattice.width - 1, scene.lattice.height - 1);
  const glm::uvec2 cell = glm::min(glm::uvec2(p), last - 1u);
  const glm::dvec2 t = p - glm::dvec2(cell);
  const auto along = [&](uint32_t y) { return (1 - t.x) * scene.at(cell.x, y) + t.x * scene.at(cell.x + 1, y); };
  const double bilinear = (1 - t.y) * along(cell.y) + t.y * along(cell.y + 1);
  return std::max(std::fabs(drawnHeight(last, p, scene.at) - height_m), std::fabs(bilinear - height_m));
}

Result<SourceDifference> compare(LaidTile tile, const LatticeHeights& scene, const SourceExtent& extent) {
  SourceDifference out{.name = std::filesystem::path(tile.tile.raster->info().name).filename().string()};
  std::vector<LaidTile> one;
  one.push_back(std::move(tile));
  auto groups = groupTiles(std::move(one));
  if (!groups.ok()) return groups.error();
  auto place = placeLayer(groups->front(), scene.lattice);
  if (!place.ok()) return place.error();
  // Heights alone count from a cell of either grid beyond the feather on.
  const glm::dvec2 lattice_m = sampleSpacing(scene.lattice.frame, scene.lattice.width, scene.lattice.height),
                   own_m = place->spacing * lattice_m;
  const double reach_m = extent.feather_m + 2 * std::max({lattice_m.x, lattice_m.y, own_m.x, own_m.y});
  const auto margin = static_cast<uint32_t>(std::min(1e6, reach_m / std::min(own_m.x, own_m.y)));
  std::vector<std::string> ignored;
  auto layer = readLayer(groups->front(), *place, scene.lattice, margin, ignored);
  if (!layer.ok()) return layer.error();
  const Samples& s = layer->samples;
  const std::vector<float> weights = featherWeights(s, own_m, reach_m);
  std::vector<glm::dvec2> row(s.width);
  for (uint32_t y = 0; y < s.height; ++y) {
    for (uint32_t x = 0; x < s.width; ++x) row[x] = {x, y};
    layer->to_lattice(row);
    for (uint32_t x = 0; x < s.width; ++x) {
      const glm::dvec2 p = row[x];
      if (std::isnan(s.at(x, y))) continue;
      const bool is_inside =
          p.x >= 0 && p.y >= 0 && p.x <= scene.lattice.width - 1.0 && p.y <= scene.lattice.height - 1.0;
      if (!is_inside || weights[size_t{y} * s.width + x] < 1 || isUnder(extent.above, p)) {
        ++out.left_out;
        continue;
      }
      out.largest_m = std::max(out.largest_m, differenceAt(scene, p, s.at(x, y)));
      ++out.compared;
    }
  }
  return out;
}

}  // namespace

Result<std::vector<SourceDifference>> compareSource(
    const std::filesystem::path& file, const OpenOptions& options, const LatticeHeights& scene,
    const std::function<Result<SourceExtent>(const std::string& name)>& extentOf) {
  std::vector<std::string> notes;
  OpenOptions placed = options;
  placed.keeps_map = true;
  auto tiles = openTiles({file}, placed, notes);
  if (!tiles.ok()) return tiles.error();
  const auto datum = alignHeights(*tiles, options, notes);
  if (!datum.ok()) return datum.error();
  std::vector<SourceDifference> all;
  for (Tile& tile : *tiles) {
    const auto extent = extentOf(std::filesystem::path(tile.raster->info().name).filename().string());
    if (!extent.ok()) return extent.error();
    auto difference = compare({std::move(tile), std::nullopt}, scene, *extent);
    if (!difference.ok()) return difference.error();
    all.push_back(std::move(*difference));
  }
  return all;
}

}  // namespace foreland::terrain
