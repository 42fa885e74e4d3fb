// The one-to-one map between a surface and its simplification: the sequence of vertex removals, each kept as the two
// triangulations of one flat polygon (one_ring.h). Undoing the removals in reverse order carries any point of the
// coarse mesh to a point exactly on the original, and neighbours to neighbours. Immutable once made; any thread may
// read it.
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

  // Records that the centre of `ring`, flattened to `flat`, was collapsed into ring vertex `kept`: the faces without
  // `kept` take it as their corner instead of the centre, the others vanish. Faces keep their indices.
  void addRemoval(const OneRing& ring, const std::vector<glm::dvec2>& flat, size_t kept);

  // From the coarse mesh to the original. Cost: about four removals are undone for each halving of the vertex count.
  SurfacePoint toOriginal(SurfacePoint at) const;
  // From the original to the coarse mesh: the inverse of toOriginal, up to rounding.
  SurfacePoint toCoarse(SurfacePoint at) const;

 private:
  struct Removal {
    uint64_t begin = 0;  // of its ring in `flat_`, `faces_`, `corners_`
    uint32_t size = 0, kept = 0;
    bool is_open = false;
  };
  enum Triangulation : uint8_t { kAroundCentre, kFromKept };
  SurfacePoint transfer(const Removal& removal, const SurfacePoint& at, Triangulation to) const;

  std::vector<Removal> removals_;
  std::vector<glm::dvec2> flat_;
  std::vector<uint32_t> faces_;  // kNoIndex after the last face of an open ring
  std::vector<uint8_t> corners_;
  std::vector<std::vector<uint32_t>> history_;  // of each face: the removals that changed it but kept it, ascending
  std::vector<uint32_t> ends_;                  // of each face: the removal in which it vanished, or kNoIndex
};

}  // namespace foreland::terrain
