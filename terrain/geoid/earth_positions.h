// From positions on a map to longitude and latitude on WGS84, by PROJ. One owner, one thread at a time.
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"

namespace foreland::terrain {

class EarthPositions {
 public:
  // Of a map's reference system as WKT, in its own units, easting before northing. An Error if it has no transformation
  // to WGS84: another body's, or a site's own.
  static Result<std::shared_ptr<EarthPositions>> of(const std::string& wkt);
  ~EarthPositions();

  // Replaces positions by degrees, longitude before latitude; NaN where there is no transformation.
  void toDegrees(std::span<glm::dvec2> positions) const;

 private:
  struct Parts;
  explicit EarthPositions(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace foreland::terrain
