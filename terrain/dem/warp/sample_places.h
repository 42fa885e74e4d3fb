// Where the samples of a raster lie on the lattice of a scene, whatever the reference systems of both. One owner, one
// thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "proto/space/frame.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

// The lattice that rasters are laid on.
struct LatticePlace {
  proto::Frame frame;
  uint32_t width = 0, height = 0;  // samples
  std::string crs_wkt;             // empty if none
  std::string name;                // of the input whose lattice it is, for messages
};

class SamplePlaces {
 public:
  // `map` is resolved (mosaic/placement.h). An Error names both files and the way out: the raster has no position, one
  // of the two has no reference system, or PROJ knows no transformation between them.
  static Result<SamplePlaces> of(const LatticePlace& lattice, const Georeference& map, glm::uvec2 size,
                                 const std::string& name);

  // Replaces positions on the lattice by columns and rows of the raster, and back; NaN where there is no
  // transformation. A position within 1e-6 samples of whole ones becomes whole, so samples that lie on the lattice are
  // met exactly.
  void toSamples(std::span<glm::dvec2> positions) const;
  void toLattice(std::span<glm::dvec2> positions) const;

  // Whether PROJ knows only a transformation that leaves the difference between the datums out, which may be 200 m.
  bool isBallpark() const { return is_ballpark_; }

 private:
  struct Transformation;

  std::array<double, 6> lattice_{}, raster_{};  // map position = (t0 + x t1 + y t2, t3 + x t4 + y t5)
  // A turn of longitudes and the middle one, on either map; no turn on maps without longitudes.
  struct Longitudes {
    double turn = 0, middle = 0;
  };
  static void toIndices(const std::array<double, 6>& map, const Longitudes& longitudes,
                        std::span<glm::dvec2> positions);

  Longitudes lattice_longitudes_, raster_longitudes_;
  std::shared_ptr<const Transformation> transformation_;  // null where both are on one map
  bool is_ballpark_ = false;
};

}  // namespace foreland::terrain
