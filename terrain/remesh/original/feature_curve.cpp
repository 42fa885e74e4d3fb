#include "terrain/remesh/original/feature_curve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace foreland::terrain {

FeatureCurve::FeatureCurve(const Original& surface, Chain chain)
    : surface_(surface), chain_(std::move(chain)), lengths_{0} {
  for (size_t i = 1; i < chain_.vertices.size(); ++i)
    lengths_.push_back(lengths_.back() +
                       glm::distance(surface.positions[chain_.vertices[i - 1]], surface.positions[chain_.vertices[i]]));
}

size_t FeatureCurve::edgeAt(double along) const {
  const auto above = std::upper_bound(lengths_.begin(), lengths_.end(), along) - lengths_.begin();
  return std::clamp<size_t>(static_cast<size_t>(above), 1, lengths_.size() - 1) - 1;
}

SurfacePoint FeatureCurve::at(double along) const {
  const size_t i = edgeAt(along);
  const double t = std::clamp((along - lengths_[i]) / (lengths_[i + 1] - lengths_[i]), 0.0, 1.0);
  const uint32_t face = chain_.edges[i] / 3, k = chain_.edges[i] % 3;
  const bool is_forward = surface_.faces[face][k] == chain_.vertices[i];
  SurfacePoint point{face, glm::dvec3(0)};
  point.weights[static_cast<int>(k)] = is_forward ? 1 - t : t;
  point.weights[static_cast<int>(k + 1) % 3] = is_forward ? t : 1 - t;
  return point;
}

glm::dvec3 FeatureCurve::direction(double along) const {
  const size_t i = edgeAt(along);
  return glm::normalize(surface_.positions[chain_.vertices[i + 1]] - surface_.positions[chain_.vertices[i]]);
}

double FeatureCurve::nearest(const glm::dvec3& p) const {
  double best = 0, best_distance = INFINITY;
  for (size_t i = 1; i < lengths_.size(); ++i) {
    const glm::dvec3 &a = surface_.positions[chain_.vertices[i - 1]], &b = surface_.positions[chain_.vertices[i]];
    const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
    const double distance = glm::distance(p, a + t * (b - a));
    if (distance < best_distance)
      best_distance = distance, best = lengths_[i - 1] + t * (lengths_[i] - lengths_[i - 1]);
  }
  return best;
}

}  // namespace foreland::terrain
