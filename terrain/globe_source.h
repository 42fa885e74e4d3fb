// Elevation of a whole body as the builder of globes sees it: a height wherever there is a direction. Implemented by
// terrain/dem (files) and by tests (formulas).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/space/vertical.h"

namespace foreland::terrain {

// What a globe is put together from, the uppermost first and the base last.
struct GlobeInput {
  std::vector<std::string> files;
  std::string vertical;  // what its heights counted from; empty if that is not stated
  double spacing_m = 0;  // between its samples, in the middle of it
  double feather_m = 0;  // over which its edges are mixed with what lies below it
  uint64_t samples = 0;
};

struct GlobeInfo {
  double semi_major_m = 6378137.0, flattening = 1 / 298.257223563;
  std::string title;               // file names, for people
  std::string crs_wkt;             // of the base; empty if none
  std::vector<std::string> notes;  // what was assumed about the input, a sentence each
  std::vector<std::string> warnings;
  // Undulations are at degrees: (longitude, latitude), from -180 to 180 and from -90 to 90.
  proto::VerticalDatum vertical{};
  uint64_t voids_filled = 0;
  std::vector<GlobeInput> inputs;
};

// A part of the body's surface: directions in rows, `side` times `side`, and a cone around their middle that holds all.
struct GlobePatch {
  glm::dvec3 middle{0, 0, 1};
  double angle_rad = 0;
  uint32_t side = 0;
  std::vector<glm::dvec3> directions;  // of any length
};

struct GlobeHeight {
  static constexpr int kMixed = -1;

  double metres = 0;
  int owner = kMixed;  // the input that alone counts, an index of GlobeInfo::inputs
};

struct GlobeSample {
  glm::dvec3 direction;  // of length 1
  double metres;
};

// Directions are normals of the ellipsoid, in the body's own axes: x towards longitude 0 on the equator, z to the north
// pole. Heights are above the ellipsoid. Immutable; any thread.
class GlobeSource {
 public:
  virtual ~GlobeSource() = default;
  virtual const GlobeInfo& info() const = 0;
  // `direction` has any length but 0.
  virtual GlobeHeight heightAt(const glm::dvec3& direction) const = 0;
  // The distance between samples of the finest input that may count somewhere in a patch; metres.
  virtual double spacingIn(const GlobePatch& patch) const = 0;
  // Appends the samples of a row of an input that are no voids, wherever it counts. Rows are below rowsOf().
  virtual uint32_t rowsOf(size_t input) const = 0;
  virtual void samplesOf(size_t input, uint32_t row, std::vector<GlobeSample>& out) const = 0;
};

}  // namespace foreland::terrain
