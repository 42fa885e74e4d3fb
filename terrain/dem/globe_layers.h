// Elevation rasters of any grid over the base of a globe. One owner; once made, any thread.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/insets/layer_stack.h"
#include "terrain/dem/layer_place.h"
#include "terrain/dem/layered_source.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/globe_source.h"

namespace foreland::terrain {

// Longitude and latitude in degrees of a direction, and back to one of length 1.
glm::dvec2 degreesOf(const glm::dvec3& direction);
glm::dvec3 directionOf(glm::dvec2 degrees);

// The lattice of whole degrees that layers are placed on: (0, 0) is 180 degrees west at the south pole.
LatticePlace degreeLattice(const Georeference& base, const std::string& name);

class GlobeLayer {
 public:
  GlobeLayer(Layer layer, glm::dvec2 spacing_m);
  GlobeLayer(GlobeLayer&&) = default;

  const Layer& layer() const { return layer_; }
  double spacing() const { return spacing_m_; }
  // Whether a cone around a direction of length 1 may meet its samples.
  bool mayMeet(const glm::dvec3& middle, double angle_rad) const;
  // Whether it has samples in a patch, or next to it.
  bool meets(const GlobePatch& patch) const;
  // Columns and rows of its samples; NaN where there is no transformation.
  void toSamples(std::vector<glm::dvec2>& degrees) const;
  // Appends the samples of a row that are no voids.
  void samplesOf(uint32_t row, std::vector<GlobeSample>& out) const;

 private:
  Layer layer_;
  double spacing_m_;
  glm::dvec3 middle_{0, 0, 1};
  double angle_rad_ = 4;               // of a cone around the middle that holds all samples
  std::unique_ptr<std::mutex> mutex_;  // PROJ's transformations belong to one thread at a time
};

// The layers of what is laid over a base, the lowest first: other inputs that are finer than the base's samples, then
// insets by priority. What is coarser is left out with a note. Describes each in `inputs`, in the same order.
Result<std::vector<GlobeLayer>> globeLayers(std::vector<LaidTile> tiles, const LatticePlace& lattice,
                                            double base_spacing_m, const OpenOptions& options, GlobeInfo& info,
                                            std::vector<GlobeInput>& inputs);

}  // namespace foreland::terrain
