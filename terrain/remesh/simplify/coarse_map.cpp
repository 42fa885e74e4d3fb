#include "terrain/remesh/simplify/coarse_map.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace foreland::terrain {

void CoarseMap::addStep(const Ring& ring, const std::vector<glm::dvec2>& flat, size_t kept) {
  const auto number = static_cast<uint32_t>(steps_.size());
  steps_.push_back({flat_.size(), static_cast<uint32_t>(ring.size()), static_cast<uint32_t>(kept), ring.is_open});
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

SurfacePoint CoarseMap::carryBack(SurfacePoint at) const {
  for (auto before = static_cast<uint32_t>(steps_.size());;) {
    const auto& steps = history_[at.face];
    const auto later = std::lower_bound(steps.begin(), steps.end(), before);
    if (later == steps.begin()) return at;
    before = *std::prev(later);
    at = refill(steps_[before], at, kToCentre);
  }
}

SurfacePoint CoarseMap::carryForth(SurfacePoint at) const {
  for (uint32_t from = 0;;) {
    const auto& steps = history_[at.face];
    const auto next = std::lower_bound(steps.begin(), steps.end(), from);
    const uint32_t step = next == steps.end() ? ends_[at.face] : *next;
    if (step == kNoIndex) return at;
    from = step + 1;
    at = refill(steps_[step], at, kToKept);
  }
}

// The same polygon filled by the faces around its centre, or by those that reach from ring vertex `kept`.
SurfacePoint CoarseMap::refill(const Step& step, const SurfacePoint& at, Filling to) const {
  const glm::dvec2* flat = flat_.data() + step.begin;
  const uint32_t* faces = faces_.data() + step.begin;
  const uint8_t* corners = corners_.data() + step.begin;
  const auto next = [&](uint32_t i) { return i + 1 == step.size ? 0 : i + 1; };
  const glm::dvec2 centre(0), from_apex = to == kToCentre ? flat[step.kept] : centre;
  const glm::dvec2 to_apex = to == kToCentre ? centre : flat[step.kept];
  uint32_t own = 0;
  while (own < step.size && faces[own] != at.face) ++own;
  CHECK_LT(own, step.size);
  const auto weight = [&](uint32_t turn) { return at.weights[(corners[own] + turn) % 3]; };
  const glm::dvec2 p = weight(0) * from_apex + weight(1) * flat[own] + weight(2) * flat[next(own)];
  // The face that holds it, or nearly does.
  SurfacePoint best;
  glm::dvec3 best_weights;
  double best_least = -INFINITY;
  for (uint32_t i = 0; i < step.size; ++i) {
    if (faces[i] == kNoIndex || (to == kToKept && (i == step.kept || next(i) == step.kept))) continue;
    const glm::dvec3 weights = weightsIn(p, to_apex, flat[i], flat[next(i)]);
    const double least = std::min({weights.x, weights.y, weights.z});
    if (least > best_least) best_least = least, best_weights = cleanWeights(weights), own = i;
  }
  best.face = faces[own];
  for (int turn = 0; turn < 3; ++turn) best.weights[(corners[own] + turn) % 3] = best_weights[turn];
  return best;
}

}  // namespace foreland::terrain
