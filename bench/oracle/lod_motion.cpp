#include "bench/oracle/lod_motion.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "bench/oracle/drawn_surface.h"
#include "bench/oracle/oracle.h"
#include "bench/oracle/surface/oracle_eye.h"

namespace foreland::bench {

namespace {

struct Step {
  const OracleEye& eye;
  glm::dvec3 origin;
  WeightStep weights;

  // Whether the point between two positions is seen, and where.
  bool project(const glm::dvec3& from, const glm::dvec3& to, double weight, glm::dvec2& at) const {
    const glm::dvec3 p = glm::mix(from, to, weight) + origin;
    if (eye.depth(p) < Oracle::kDefaultNear_m) return false;
    at = eye.project(p);
    return eye.sees(at);
  }
};

size_t collect(const client::BlendMesh& mesh, std::span<const uint32_t> indices, const Step& step,
               std::vector<double>& out_px) {
  const std::vector<bool> is_drawn = drawnVertices(mesh.parameters.size(), indices);
  size_t seen = 0;
  for (size_t i = 0; i < mesh.parameters.size(); ++i) {
    const glm::dvec3 from(mesh.from_positions[i]), to(mesh.to_positions[i]);
    glm::dvec2 before, after;
    if (!is_drawn[i] || !step.project(from, to, step.weights.before, before) ||
        !step.project(from, to, step.weights.after, after))
      continue;
    ++seen;
    if (from != to) out_px.push_back(glm::distance(before, after));
  }
  return seen;
}

}  // namespace

size_t collectLodMotion(const client::KeyframeMesh& mesh, WeightStep step, const proto::Pose& pose,
                        const proto::Lens& lens, std::vector<double>& out_px) {
  const OracleEye eye(pose, lens);
  const Step seen{eye, mesh.origin, step};
  return collect(mesh, mesh.indices, seen, out_px) + collect(mesh.objects, objectIndices(mesh), seen, out_px);
}

}  // namespace foreland::bench
