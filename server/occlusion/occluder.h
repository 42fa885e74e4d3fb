// A surface that lies below the terrain everywhere, at every scene time, and is nowhere steep, for asking Embree
// whether it blocks a line of sight. The only wrapper of Embree in the server.
//
// Its vertices are lattice points `stride` samples apart, lowered until
//   * its triangles lie below the terrain at full resolution (by kBelow_m at least), and
//   * between any two points of it the height differs by at most steepness() times their horizontal distance.
// The second makes sampling exact (block_test.h): what blocks one line of sight blocks all that are near to it, if it
// blocks it with some height to spare. In the scene frame, whose z axis must point up to within a few degrees all over
// the scene: create() refuses scenes that are larger.
//
// Immutable after creation; any thread may cast rays. Memory: about 30 bytes a vertex.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>

#include "base/result.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

struct OccluderOptions {
  size_t max_vertices = 4u << 20;
  size_t max_bytes = std::numeric_limits<ptrdiff_t>::max();  // of Embree's memory
};

class Occluder {
 public:
  static constexpr double kBelow_m = 0.25;       // more than the rounding of positions to floats
  static constexpr double kMaxExtent_m = 400e3;  // of a scene: up turns by 2 degrees from its middle to its border

  // kUnsupported for a scene that extends beyond kMaxExtent_m; kLimit if memory does not suffice. O(samples); uses all
  // cores.
  static Result<std::shared_ptr<const Occluder>> create(const Hierarchy& hierarchy,
                                                        const OccluderOptions& options = {});
  ~Occluder();
  Occluder(const Occluder&) = delete;
  Occluder& operator=(const Occluder&) = delete;

  // Whether the segment from `from` to `from + way` meets the surface. Scene frame, metres. Costs less if it does so
  // near its end than if near its beginning.
  bool blocks(const glm::dvec3& from, const glm::dvec3& way) const;

  double steepness() const { return steepness_; }  // metres of height per metre of horizontal distance
  uint32_t stride() const { return stride_; }
  size_t bytes() const { return bytes_; }

 private:
  struct Embree;
  Occluder() = default;

  std::unique_ptr<Embree> embree_;
  glm::dvec3 origin_{0};
  double steepness_ = 0;
  uint32_t stride_ = 1;
  size_t bytes_ = 0;
};

}  // namespace foreland::server
