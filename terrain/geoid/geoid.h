// How far a geoid lies above the WGS84 ellipsoid, by PROJ's grids. Nothing is downloaded: a grid that is not there is
// an Error that names it and where it comes from. One owner, one thread at a time.
#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/result.h"

namespace foreland::terrain {

// West, south, east, north; degrees on WGS84.
struct EarthBox {
  double west = -180, south = -90, east = 180, north = 90;
};

// The lines of a grid of undulations: longitude and latitude of its south-western value and the step between values.
struct GridLines {
  glm::dvec2 first_degrees, step_degrees;
};

class Geoid {
 public:
  // "egm96", "egm2008", or the name of a file (.gtx, .tif) that PROJ reads as a grid of undulations.
  static Result<std::shared_ptr<Geoid>> open(const std::string& choice);
  // The surface that heights of a compound reference system (WKT) count from, for places in `box`. An Error: PROJ knows
  // no transformation to the ellipsoid, or has not got its grid.
  static Result<std::shared_ptr<Geoid>> ofReferenceSystem(const std::string& wkt, const EarthBox& box);

  ~Geoid();

  // For people: EGM96, EGM2008, a file's name, the vertical reference system's name. Two geoids of one name are the
  // same.
  const std::string& name() const;
  // Metres at places (longitude, latitude; degrees on WGS84); NaN where the grid has none. At least `out.size()`
  // places.
  void undulations(std::span<const glm::dvec2> degrees, std::span<double> out) const;
  // Nothing if they are not known: undulations are then not piecewise bilinear between known lines.
  std::optional<GridLines> lines() const;

 private:
  struct Parts;
  explicit Geoid(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace foreland::terrain
