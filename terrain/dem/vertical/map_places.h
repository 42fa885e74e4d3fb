// Where the samples of a map are on the earth. One owner, one thread at a time.
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "terrain/dem/raster/raster.h"
#include "terrain/geoid/earth_positions.h"
#include "terrain/geoid/geoid.h"

namespace foreland::terrain {

class MapPlaces {
 public:
  // `map` is resolved (mosaic/placement.h). An Error, which calls the input `name`: nothing says where the map is, or
  // it is not on the earth.
  static Result<MapPlaces> of(const Georeference& map, const std::string& name);

  // Replaces columns and rows by longitudes and latitudes, degrees on WGS84; NaN where there is no transformation.
  void toDegrees(std::span<glm::dvec2> samples) const;
  // Of a raster of so many samples: its border's, with a margin.
  EarthBox box(uint32_t width, uint32_t height) const;

 private:
  Georeference map_;
  std::shared_ptr<const EarthPositions> positions_;  // null where the map is in degrees of no reference system
};

}  // namespace foreland::terrain
