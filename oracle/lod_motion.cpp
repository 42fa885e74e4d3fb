#include "oracle/lod_motion.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "oracle/drawn_surface.h"
#include "oracle/oracle.h"
#include "oracle/surface/oracle_eye.h"

namespace foreland::oracle {

namespace {

struct Step {
  const OracleEye& eye;
  glm::dvec3 origin;
  WeightStep weights;

  // Whether the point is seen, and where.
  bool project(const glm::dvec3& position, glm::dvec2& at) const {
    const glm::dvec3 p = position + origin;
    if (eye.depth(p) < Oracle::kDefaultNear_m) return false;
    at = eye.project(p);
    return eye.sees(at);
  }
};

bool isMoving(const client::BlendMesh& mesh, size_t v) {
  return glm::vec3(mesh.from_positions[v]) != glm::vec3(mesh.to_positions[v]) ||
         (!mesh.from_bends.empty() && (mesh.from_bends[v] != glm::vec3(0) || mesh.to_bends[v] != glm::vec3(0)));
}

size_t collect(const client::BlendMesh& mesh, std::span<const uint32_t> indices, const Step& step,
               std::vector<double>& out_px) {
  const std::vector<bool> is_drawn = drawnVertices(mesh.parameters.size(), indices);
  size_t seen = 0;
  for (size_t i = 0; i < mesh.parameters.size(); ++i) {
    const glm::dvec3 from(mesh.at(i, step.weights.before)), to(mesh.at(i, step.weights.after));
    glm::dvec2 before, after;
    if (!is_drawn[i] || !step.project(from, before) || !step.project(to, after)) continue;
    ++seen;
    if (isMoving(mesh, i)) out_px.push_back(glm::distance(before, after));
  }
  return seen;
}

}  // namespace

size_t collectLodMotion(const client::KeyframeMesh& mesh, WeightStep step, const proto::Pose& pose,
                        const proto::Lens& lens, std::vector<double>& out_px, const Stretch& stretch) {
  const OracleEye eye(pose, lens, stretch);
  const Step seen{eye, mesh.origin, step};
  return collect(mesh, mesh.indices, seen, out_px) + collect(mesh.objects, objectIndices(mesh), seen, out_px);
}

}  // namespace foreland::oracle
