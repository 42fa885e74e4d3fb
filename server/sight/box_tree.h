// The only place of server/sight that knows Embree: boxes in a tree, and which of them a straight segment may pass
// through. The boxes are user geometry: Embree never sees what is in them. They are widened by what floats lose, so no
// box is missed; some are visited that the segment only passes near. Threads: one owner until commit(), which builds on
// the calling thread alone; after it any thread may cast.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>

#include "base/result.h"

namespace foreland::server {

struct Box {
  glm::dvec3 low{1e300}, high{-1e300};
  void add(const glm::dvec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
};

class BoxTree {
 public:
  // `reach_m`: no box goes farther from `origin` along an axis. `margin_m`: by which all boxes are widened, too.
  struct Space {
    glm::dvec3 origin{0};
    double reach_m = 0, margin_m = 0;
  };
  BoxTree(const Space& space, uint64_t max_bytes);
  ~BoxTree();
  BoxTree(BoxTree&&) noexcept;
  BoxTree& operator=(BoxTree&&) noexcept;

  using BoxOf = std::function<Box(uint32_t number)>;
  // Boxes that stand where they are. Before all instances, once.
  [[nodiscard]] Status addBoxes(uint32_t count, BoxOf box_of);
  // Boxes in a frame of their own, of whose instances none is scaled less than `scale`. Returns their number.
  [[nodiscard]] Result<uint32_t> addPart(uint32_t count, BoxOf box_of, double scale);
  // A point p of a part stands at linear * p + offset. Instances are numbered from 0.
  [[nodiscard]] Status addInstance(uint32_t part, const glm::dmat3& linear, const glm::dvec3& offset);
  // kLimit if memory does not suffice.
  [[nodiscard]] Status commit();

  static constexpr int32_t kNoInstance = -1;
  // Ends may be anywhere. A visit is called for boxes, for some twice, and returns the share of the segment after which
  // no box matters any more; negative: none.
  using Visit = std::function<double(int32_t instance, uint32_t box)>;
  // The nearest to `from` about first.
  void castInOrder(const glm::dvec3& from, const glm::dvec3& to, const Visit& visit) const;
  // In any order, which costs less: until a visit returns a negative share.
  void cast(const glm::dvec3& from, const glm::dvec3& to, const Visit& visit) const;

  uint64_t bytes() const;  // Embree's

 private:
  struct Embree;
  std::unique_ptr<Embree> embree_;
};

}  // namespace foreland::server
