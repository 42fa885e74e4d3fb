// Where a scene's lattice lies in the coordinates of its reference system, for GDAL. One owner, one thread.
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <string>

#include "base/result.h"
#include "terrain/dem/formats/gdal_dataset.h"
#include "terrain/dem/pictures/open_pictures.h"

namespace foreland::terrain {

class LatticeMap {
 public:
  // An Error if scenes of this kind have no position that pictures could be laid at.
  static Result<LatticeMap> of(const PictureLattice& lattice);

  // Null without a reference system.
  void* referenceSystem() const { return crs_.get(); }
  // GDAL's transform for a raster of texels whose upper left corner is at a lattice position; the texel's size is in
  // lattice steps.
  std::array<double, 6> transform(const glm::dvec2& upper_left, const glm::dvec2& texel) const;

 private:
  glm::dvec2 origin_{0, 0}, axis_x_{1, 0}, axis_y_{0, 1};  // of lattice (0, 0), and to its neighbours
  GdalReferenceSystem crs_;
};

}  // namespace foreland::terrain
