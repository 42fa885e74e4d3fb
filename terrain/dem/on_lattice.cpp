#include "terrain/dem/on_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>
#include <vector>

#include "base/check.h"
#include "terrain/dem/datum.h"
#include "terrain/dem/layer_place.h"
#include "terrain/dem/mosaic_info.h"
#include "terrain/dem/tiles.h"

namespace foreland::terrain {

namespace {

class WindowSource final : public ElevationSource {
 public:
  WindowSource(ElevationInfo info, std::vector<float> metres, std::vector<std::string> warnings)
      : info_(std::move(info)), metres_(std::move(metres)), warnings_(std::move(warnings)) {}

  const ElevationInfo& info() const override { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    CHECK_EQ(out.size(), size_t{count} * info_.width);
    const auto from = metres_.begin() + static_cast<std::ptrdiff_t>(size_t{first} * info_.width);
    std::copy(from, from + static_cast<std::ptrdiff_t>(out.size()), out.begin());
    return {};
  }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  ElevationInfo info_;
  std::vector<float> metres_;
  std::vector<std::string> warnings_;
};

// The positions of the lattice that hold a layer.
proto::LatticeWindow windowOf(const Layer& layer, const LatticePlace& lattice) {
  const glm::dvec2 last(lattice.width - 1.0, lattice.height - 1.0);
  const glm::dvec2 low = glm::clamp(glm::floor(layer.low), glm::dvec2(0), last),
                   high = glm::clamp(glm::ceil(layer.high), low, last);
  const glm::uvec2 first(low), size = glm::uvec2(high - low) + 1u;
  return {first.x, first.y, size.x, size.y};
}

std::vector<float> heightsIn(const proto::LatticeWindow& window, const Layer& layer) {
  std::vector<float> metres;
  metres.reserve(size_t{window.width} * window.height);
  std::vector<glm::dvec2> row(window.width);
  for (uint32_t y = 0; y < window.height; ++y) {
    for (uint32_t x = 0; x < window.width; ++x) row[x] = {window.x + x, window.y + y};
    layer.to_samples(row);
    for (const glm::dvec2& p : row) metres.push_back(static_cast<float>(cubicHeight(layer.samples, p)));
  }
  return metres;
}

// A frame whose lattice begins at the window's corner.
proto::Frame frameOf(proto::Frame frame, const proto::LatticeWindow& window) {
  frame.anchor -= glm::dvec2(window.x, window.y);
  frame.latitude0_rad += window.y * frame.latitude_step_rad;
  frame.longitude0_rad += window.x * frame.longitude_step_rad;
  return frame;
}

}  // namespace

Result<std::unique_ptr<ElevationSource>> openOnLattice(const std::filesystem::path& file, const OpenOptions& options,
                                                       const ElevationInfo& lattice) {
  std::vector<std::string> notes, warnings;
  OpenOptions placed = options;
  placed.keeps_map = true;
  auto tiles = openTiles({file}, placed, notes);
  if (!tiles.ok()) return tiles.error();
  const auto datum = alignHeights(*tiles, options, notes);
  if (!datum.ok()) return datum.error();
  std::vector<LaidTile> laid;
  for (Tile& tile : *tiles) laid.push_back({std::move(tile), std::nullopt});
  auto groups = groupTiles(std::move(laid));
  if (!groups.ok()) return groups.error();
  TileGroup& group = groups->front();
  if (groups->size() > 1)
    return Error{ErrorCode::kUnsupported, group.name + ": its rasters are of different grids; name a file of one"};
  const LatticePlace place{lattice.frame, lattice.width, lattice.height, lattice.crs_wkt, lattice.title};
  const auto layer_place = placeLayer(group, place);
  if (!layer_place.ok()) return layer_place.error();
  if (!layer_place->meets_lattice)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: it lies beyond {}; name a file of the same place", group.name, lattice.title)};
  ElevationInfo info;
  info.title = titleOf(group.mosaic);
  info.crs_wkt = lattice.crs_wkt;
  info.notes = std::move(notes);
  if (*datum) info.vertical.name = (*datum)->scene.name;
  const auto layer = readLayer(group, *layer_place, place, 2, warnings);
  if (!layer.ok()) return layer.error();
  const proto::LatticeWindow window = windowOf(*layer, place);
  info.frame = frameOf(lattice.frame, window);
  info.width = window.width;
  info.height = window.height;
  return std::unique_ptr<ElevationSource>(
      std::make_unique<WindowSource>(std::move(info), heightsIn(window, *layer), std::move(warnings)));
}

}  // namespace foreland::terrain
