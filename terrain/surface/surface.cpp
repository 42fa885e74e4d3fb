#include "terrain/surface/surface.h"

#include <cmath>
#include <string>
#include <utility>

namespace foreland::terrain {

namespace {

// Quantises the positions of a surface under construction; remembers the first vertex that does not fit.
class Quantiser {
 public:
  explicit Quantiser(double quantum_m) : quantum_m_(quantum_m) {}

  glm::ivec3 quanta(const glm::dvec3& position, const char* kind, uint64_t number) {
    glm::ivec3 result(0);
    for (int i = 0; i < 3; ++i) {
      const double steps = std::round(position[i] / quantum_m_);
      if (std::fabs(steps) <= kMaxQuanta)  // false for what is not finite
        result[i] = static_cast<int32_t>(steps);
      else if (refused_.empty())
        refused_ = std::string(kind) + " " + std::to_string(number) + " lies at " + std::to_string(position[i]) +
                   " m, which is not within 2^30 steps of " + std::to_string(quantum_m_) + " m";
    }
    return result;
  }
  const std::string& refused() const { return refused_; }

 private:
  double quantum_m_;
  std::string refused_;
};

}  // namespace

namespace {

std::vector<glm::ivec3> movesOf(const TrueSurface& surface, const std::vector<glm::ivec3>& first,
                                std::vector<glm::ivec3> SurfacePose::*of) {
  std::vector<glm::ivec3> moves;
  moves.reserve(first.size() * surface.poses.size());
  for (size_t i = 0; i < first.size(); ++i)
    for (const SurfacePose& pose : surface.poses) moves.push_back((pose.*of)[i] - first[i]);
  return moves;
}

}  // namespace

std::vector<glm::ivec3> baseMoves(const TrueSurface& surface) {
  return movesOf(surface, surface.base, &SurfacePose::base);
}
std::vector<glm::ivec3> nodeMoves(const TrueSurface& surface) {
  return movesOf(surface, surface.nodes, &SurfacePose::nodes);
}

Result<TrueSurface> makeSurface(proto::MeshTopology topology, double quantum_m, const std::vector<glm::dvec3>& corners,
                                const TruePosition& truePosition) {
  if (!(quantum_m > 0) || !std::isfinite(quantum_m))
    return Error{ErrorCode::kInvalidArgument,
                 "surface: a step of " + std::to_string(quantum_m) + " m; it must be positive"};
  CHECK_EQ(corners.size(), topology.base().vertexCount());
  TrueSurface surface{std::move(topology), quantum_m, {}, {}};
  const proto::MeshTopology& mesh = surface.topology;
  Quantiser quantiser(quantum_m);
  for (uint32_t v = 0; v < corners.size(); ++v) surface.base.push_back(quantiser.quanta(corners[v], "base vertex", v));
  for (uint32_t v = mesh.base().vertexCount(); v < mesh.baseVertexCount(); ++v) {
    const auto& [a, b, c] = mesh.base().faces()[v - mesh.base().vertexCount()];
    const glm::dvec3 middle = glm::dvec3(surface.base[a]) + glm::dvec3(surface.base[b]) + glm::dvec3(surface.base[c]);
    surface.base.push_back(quantiser.quanta(truePosition(proto::baseVertexId(v), middle * (quantum_m / 3)),
                                            "the centre of face", v - mesh.base().vertexCount()));
  }
  surface.nodes.assign(mesh.slotCount(), glm::ivec3(0));
  forEachNode(mesh, [&](proto::NodeId n, proto::Slot slot) {
    const auto [a, b] = mesh.endpoints(n);
    const glm::dvec3 middle = 0.5 * (surface.position(a) + surface.position(b));
    surface.nodes[slot] = quantiser.quanta(truePosition(n, middle), "node", slot);
  });
  if (!quantiser.refused().empty()) return Error{ErrorCode::kLimit, "surface: " + quantiser.refused()};
  return surface;
}

}  // namespace foreland::terrain
