// Sum of weighted squared distances to planes, as a quadratic form (Garland and Heckbert, "Surface simplification using
// quadric error metrics", 1997, section 4). Positions are relative to an origin that
// the caller chooses, so that models far from (0, 0, 0) lose no digits. Value type.
#pragma once

#include <array>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::terrain {

class Quadric {
 public:
  // `normal` is a unit vector.
  void addPlane(const glm::dvec3& normal, const glm::dvec3& point, double weight) {
    const double d = -glm::dot(normal, point);
    const glm::dvec3 n = normal;
    const std::array<double, 10> terms{n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z,
                                       n.z * n.z, n.x * d,   n.y * d,   n.z * d,   d * d};
    for (size_t i = 0; i < terms.size(); ++i) terms_[i] += weight * terms[i];
  }
  void add(const Quadric& other) {
    for (size_t i = 0; i < terms_.size(); ++i) terms_[i] += other.terms_[i];
  }
  double at(const glm::dvec3& p) const {
    const auto& t = terms_;
    return t[0] * p.x * p.x + t[3] * p.y * p.y + t[5] * p.z * p.z + t[9] +
           2 * (t[1] * p.x * p.y + t[2] * p.x * p.z + t[4] * p.y * p.z + t[6] * p.x + t[7] * p.y + t[8] * p.z);
  }

 private:
  std::array<double, 10> terms_{};
};

}  // namespace foreland::terrain
