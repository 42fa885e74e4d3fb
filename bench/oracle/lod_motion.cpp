#include "bench/oracle/lod_motion.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "bench/oracle/oracle.h"

namespace foreland::bench {

void collectLodMotion(const client::KeyframeMesh& mesh, WeightStep step, const proto::Pose& pose,
                      const proto::Lens& lens, std::vector<double>& out_px) {
  const double focal = lens.focalPx();
  const auto project = [&](size_t vertex, double weight, glm::dvec2& at) {
    const glm::dvec3 from(mesh.from_positions[vertex]), to(mesh.to_positions[vertex]);
    const glm::dvec3 p = glm::mix(from, to, weight) + mesh.origin;
    const glm::dvec3 v = glm::conjugate(pose.orientation) * (p - pose.eye);
    if (v.z > -Oracle::kDefaultNear_m) return false;
    at = glm::dvec2(v.x, v.y) * (focal / -v.z);
    return std::fabs(at.x) <= 0.5 * lens.width_px && std::fabs(at.y) <= 0.5 * lens.height_px;
  };
  std::vector<bool> drawn(mesh.parameters.size());  // others lie beyond the data
  for (uint32_t vertex : mesh.indices) drawn[vertex] = true;
  for (size_t i = 0; i < mesh.parameters.size(); ++i) {
    glm::dvec2 before, after;
    if (drawn[i] && project(i, step.before, before) && project(i, step.after, after))
      out_px.push_back(glm::distance(before, after));
  }
}

}  // namespace foreland::bench
