#include "terrain/remesh/lattice/crossings.h"

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr int kAlways = 3;  // an edge is halved this often even if both ends lie in one cell: it may leave and return
constexpr double kNear = 1e-5;     // of the edge: cells this near each other have the crossed lattice edge in common,
constexpr double kNearest = 1e-8;  // unless the way leads through a lattice vertex

SurfacePoint onEdge(uint32_t edge, double t) {
  SurfacePoint place{edge / 3, dvec3(0)};
  place.weights[static_cast<int>(edge % 3)] = 1 - t;
  place.weights[static_cast<int>(edge % 3 + 1) % 3] = t;
  return place;
}

}  // namespace

CrossingFinder::CrossingFinder(const Original& surface, const Base& base, const Lattice& lattice)
    : surface_(surface), base_(base), lattice_(lattice), names_(surface.faces.size(), kNoIndex) {
  for (uint32_t f = 0; f < base.numbers.size(); ++f) names_[base.numbers[f]] = f;
}

LatticeCell CrossingFinder::cellOf(const SurfacePoint& on_original) const {
  const SurfacePoint at = base_.map.carryForth(on_original);
  return lattice_.cellAt(names_[at.face], at.weights);
}

// One crease edge, from `t` to `t` along it.
struct CrossingFinder::Tracer {
  const CrossingFinder& finder;
  uint32_t edge;
  std::vector<Crossing>& found;

  void trace(double from, const LatticeCell& first, double to, const LatticeCell& last, int depth) {
    const bool is_same = first.vertices == last.vertices;
    if (depth >= kAlways && (is_same || (std::fabs(to - from) < kNear && isCrossed(from, to, first, last)))) return;
    const double middle = (from + to) / 2;
    const LatticeCell cell = finder.cellOf(onEdge(edge, middle));
    trace(from, first, middle, cell, depth + 1);
    trace(middle, cell, to, last, depth + 1);
  }
  // Takes note of the edge that the two cells share. False if they share none and one may come between them.
  bool isCrossed(double from, double to, const LatticeCell& first, const LatticeCell& last) {
    std::array<uint32_t, 2> ends{};
    std::array<double, 2> weights{};
    size_t count = 0;
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = first.vertices[static_cast<size_t>(k)];
      if (count < 2 && std::find(last.vertices.begin(), last.vertices.end(), v) != last.vertices.end())
        weights[count] = first.weights[k], ends[count++] = v;
    }
    if (count < 2) return std::fabs(to - from) < kNearest;
    found.push_back({ends, weights[1] / (weights[0] + weights[1]), onEdge(edge, from)});
    return true;
  }
};

std::vector<Crossing> CrossingFinder::along(const Chain& chain) const {
  std::vector<Crossing> found;
  for (size_t i = 0; i < chain.edges.size(); ++i) {
    const uint32_t edge = chain.edges[i];
    const bool is_forward = surface_.faces[edge / 3][edge % 3] == chain.vertices[i];
    const double from = is_forward ? 0 : 1, to = 1 - from;
    Tracer{*this, edge, found}.trace(from, cellOf(onEdge(edge, from)), to, cellOf(onEdge(edge, to)), 0);
  }
  return found;
}

}  // namespace foreland::terrain
