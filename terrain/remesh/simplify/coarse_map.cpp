#include "terrain/remesh/simplify/coarse_map.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace foreland::terrain {

void CoarseMap::addRemoval(const OneRing& ring, const std::vector<glm::dvec2>& flat, size_t kept) {
  const auto number = static_cast<uint32_t>(removals_.size());
  removals_.push_back({flat_.size(), static_cast<uint32_t>(ring.size()), static_cast<uint32_t>(kept), ring.is_open});
  flat_.insert(flat_.end(), flat.begin(), flat.end());
  faces_.insert(faces_.end(), ring.faces.begin(), ring.faces.end());
  corners_.insert(corners_.end(), ring.corners.begin(), ring.corners.end());
  faces_.resize(flat_.size(), kNoIndex);
  corners_.resize(flat_.size(), 0);
  for (size_t i = 0; i < ring.faces.size(); ++i) {
    if (i != kept && (i + 1) % ring.size() != kept)
      history_[ring.faces[i]].push_back(number);
    else
      ends_[ring.faces[i]] = number;
  }
}

SurfacePoint CoarseMap::toOriginal(SurfacePoint at) const {
  for (auto before = static_cast<uint32_t>(removals_.size());;) {
    const auto& removals = history_[at.face];
    const auto later = std::lower_bound(removals.begin(), removals.end(), before);
    if (later == removals.begin()) return at;
    before = *std::prev(later);
    at = transfer(removals_[before], at, kAroundCentre);
  }
}

SurfacePoint CoarseMap::toCoarse(SurfacePoint at) const {
  for (uint32_t from = 0;;) {
    const auto& removals = history_[at.face];
    const auto next = std::lower_bound(removals.begin(), removals.end(), from);
    const uint32_t removal = next == removals.end() ? ends_[at.face] : *next;
    if (removal == kNoIndex) return at;
    from = removal + 1;
    at = transfer(removals_[removal], at, kFromKept);
  }
}

// The same point of the flat polygon in its other triangulation: by the faces around the centre, or by the fan from
// ring vertex `kept`.
SurfacePoint CoarseMap::transfer(const Removal& removal, const SurfacePoint& at, Triangulation to) const {
  const glm::dvec2* flat = flat_.data() + removal.begin;
  const uint32_t* faces = faces_.data() + removal.begin;
  const uint8_t* corners = corners_.data() + removal.begin;
  const auto next = [&](uint32_t i) { return i + 1 == removal.size ? 0 : i + 1; };
  const glm::dvec2 centre(0), from_apex = to == kAroundCentre ? flat[removal.kept] : centre;
  const glm::dvec2 to_apex = to == kAroundCentre ? centre : flat[removal.kept];
  uint32_t face = 0;
  while (face < removal.size && faces[face] != at.face) ++face;
  CHECK_LT(face, removal.size);
  const auto weight = [&](uint32_t k) { return at.weights[(corners[face] + k) % 3]; };
  const glm::dvec2 p = weight(0) * from_apex + weight(1) * flat[face] + weight(2) * flat[next(face)];
  // The face that contains the point; the nearest one if rounding puts it just outside of all.
  SurfacePoint best;
  glm::dvec3 best_weights;
  double best_least = -INFINITY;
  for (uint32_t i = 0; i < removal.size; ++i) {
    if (faces[i] == kNoIndex || (to == kFromKept && (i == removal.kept || next(i) == removal.kept))) continue;
    const glm::dvec3 weights = weightsIn(p, to_apex, flat[i], flat[next(i)]);
    const double least = std::min({weights.x, weights.y, weights.z});
    if (least > best_least) best_least = least, best_weights = cleanWeights(weights), face = i;
  }
  best.face = faces[face];
  for (int k = 0; k < 3; ++k) best.weights[(corners[face] + k) % 3] = best_weights[k];
  return best;
}

}  // namespace foreland::terrain
