// The map between a surface and its simplification, one to one: a row of steps, each of which took one vertex out, kept
// as the two fillings of one flat polygon (one_ring.h). Following the steps back carries any place on the coarse mesh
// to its place on the original, exactly on it, and neighbours to neighbours. Immutable once made; any thread may read
// it.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "terrain/remesh/original/surface_point.h"
#include "terrain/remesh/simplify/one_ring.h"

namespace foreland::terrain {

class CoarseMap {
 public:
  explicit CoarseMap(size_t faces) : history_(faces), ends_(faces, kNoIndex) {}

  // The centre of `ring`, laid out as `flat`, is taken out by letting the faces that do not hold ring vertex `kept`
  // reach there instead. Faces keep their numbers.
  void addStep(const Ring& ring, const std::vector<glm::dvec2>& flat, size_t kept);

  // From the coarse mesh to the original. Cost: about four steps for each halving of the vertices.
  SurfacePoint carryBack(SurfacePoint at) const;
  // From the original to the coarse mesh: the inverse, but for rounding.
  SurfacePoint carryForth(SurfacePoint at) const;

 private:
  struct Step {
    uint64_t begin = 0;  // of its ring in `flat_`, `faces_`, `corners_`
    uint32_t size = 0, kept = 0;
    bool is_open = false;
  };
  enum Filling : uint8_t { kToCentre, kToKept };
  SurfacePoint refill(const Step& step, const SurfacePoint& at, Filling to) const;

  std::vector<Step> steps_;
  std::vector<glm::dvec2> flat_;
  std::vector<uint32_t> faces_;  // kNoIndex behind the last one of an open ring
  std::vector<uint8_t> corners_;
  std::vector<std::vector<uint32_t>> history_;  // of each face: the steps that changed it and left it, ascending
  std::vector<uint32_t> ends_;                  // of each face: the step that took it away, or kNoIndex
};

}  // namespace foreland::terrain
