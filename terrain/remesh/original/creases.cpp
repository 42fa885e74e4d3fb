#include "terrain/remesh/original/creases.h"

#include <glm/geometric.hpp>

#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

namespace {

constexpr double kStraightCosine = 0.766;  // of 40 degrees

class ChainFinder {
 public:
  ChainFinder(const Original& surface, const EdgeFlags& creases)
      : surface_(surface), edges_at_(surface.positions.size()) {
    for (uint32_t f = 0; f < creases.size(); ++f)
      for (uint32_t k = 0; k < 3; ++k) {
        if (!creases[f][k] || f > surface.twins[f][k] / 3) continue;
        edges_at_[surface.faces[f][k]].push_back(3 * f + k);
        edges_at_[surface.faces[f][(k + 1) % 3]].push_back(3 * f + k);
      }
    is_taken_.resize(3 * surface.faces.size());
  }

  std::vector<Chain> run() {
    std::vector<Chain> chains;
    // First the chains between feature vertices; the edges left over form loops.
    for (const bool loops : {false, true})
      for (uint32_t v = 0; v < edges_at_.size(); ++v)
        for (uint32_t edge : edges_at_[v])
          if (!is_taken_[edge] && (loops || !continuesThrough(v))) chains.push_back(follow(v, edge));
    return chains;
  }

 private:
  uint32_t otherEnd(uint32_t edge, uint32_t v) const {
    const Triangle& t = surface_.faces[edge / 3];
    return t[edge % 3] == v ? t[(edge % 3 + 1) % 3] : t[edge % 3];
  }
  bool continuesThrough(uint32_t v) const {
    if (edges_at_[v].size() != 2) return false;
    const glm::dvec3& p = surface_.positions[v];
    const glm::dvec3 in = p - surface_.positions[otherEnd(edges_at_[v][0], v)];
    const glm::dvec3 out = surface_.positions[otherEnd(edges_at_[v][1], v)] - p;
    return glm::dot(in, out) > kStraightCosine * glm::length(in) * glm::length(out);
  }
  Chain follow(uint32_t v, uint32_t edge) {
    Chain chain{{v}, {}};
    for (;;) {
      is_taken_[edge] = true;
      v = otherEnd(edge, v);
      chain.edges.push_back(edge);
      chain.vertices.push_back(v);
      if (!continuesThrough(v)) return chain;
      edge = edges_at_[v][edges_at_[v][0] == edge ? 1 : 0];
      if (is_taken_[edge]) return chain;
    }
  }

  const Original& surface_;
  std::vector<std::vector<uint32_t>> edges_at_;
  std::vector<bool> is_taken_;
};

}  // namespace

EdgeFlags findCreases(const Original& surface, double cosine) {
  EdgeFlags creases(surface.faces.size(), {false, false, false});
  for (uint32_t f = 0; f < surface.faces.size(); ++f) {
    const glm::dvec3 normal = normalOf(surface.faces[f], surface.positions);
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t beyond = surface.twins[f][k];
      creases[f][k] =
          beyond != kNoIndex && glm::dot(normal, normalOf(surface.faces[beyond / 3], surface.positions)) < cosine;
    }
  }
  return creases;
}

std::vector<Chain> findChains(const Original& surface, const EdgeFlags& creases) {
  return ChainFinder(surface, creases).run();
}

}  // namespace foreland::terrain
