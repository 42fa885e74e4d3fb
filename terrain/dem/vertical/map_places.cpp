#include "terrain/dem/vertical/map_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace foreland::terrain {

Result<MapPlaces> MapPlaces::of(const Georeference& map, const std::string& name) {
  MapPlaces out;
  out.map_ = map;
  if (map.crs_wkt.empty() && map.kind != MapKind::kGeographic)
    return Error{ErrorCode::kInvalidArgument,
                 name +
                     ": no reference system says where on the earth its samples are, so no geoid is known over it; "
                     "name one with gdal_translate -a_srs"};
  if (map.crs_wkt.empty()) return out;
  auto positions = EarthPositions::of(map.crs_wkt);
  if (!positions) return Error{positions.error().code, name + ": " + positions.error().message};
  out.positions_ = *positions;
  return out;
}

void MapPlaces::toDegrees(std::span<glm::dvec2> samples) const {
  const auto& t = map_.transform;
  for (glm::dvec2& s : samples) s = {t[0] + s.x * t[1] + s.y * t[2], t[3] + s.x * t[4] + s.y * t[5]};
  if (positions_) return positions_->toDegrees(samples);
  for (glm::dvec2& s : samples) s *= map_.unit * 180 / std::numbers::pi;
}

EarthBox MapPlaces::box(uint32_t width, uint32_t height) const {
  constexpr int kSteps = 8;
  constexpr double kMargin = 0.1;  // degrees
  std::vector<glm::dvec2> net;
  for (int row = 0; row <= kSteps; ++row)
    for (int column = 0; column <= kSteps; ++column)
      net.emplace_back((width - 1.0) * column / kSteps, (height - 1.0) * row / kSteps);
  toDegrees(net);
  EarthBox box{180, 90, -180, -90};
  for (const glm::dvec2& p : net) {
    if (std::isnan(p.x)) continue;
    box = {std::min(box.west, p.x - kMargin), std::min(box.south, p.y - kMargin), std::max(box.east, p.x + kMargin),
           std::max(box.north, p.y + kMargin)};
  }
  return box;
}

}  // namespace foreland::terrain
