#include "terrain/remesh/lattice/crossings.h"

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

namespace {

using glm::dvec3;

// Fractions of a crease edge's length. Cells closer together than kNear share the lattice edge that is crossed, unless
// the crease passes through a lattice vertex: then the search ends at kNearest.
constexpr double kNear = 1e-5, kNearest = 1e-8;
constexpr int kMinBisections = 3;  // even if both ends lie in one cell, for the crease may leave it and return

SurfacePoint onEdge(uint32_t edge, double t) {
  SurfacePoint point{edge / 3, dvec3(0)};
  point.weights[static_cast<int>(edge % 3)] = 1 - t;
  point.weights[static_cast<int>(edge % 3 + 1) % 3] = t;
  return point;
}

}  // namespace

CrossingFinder::CrossingFinder(const Original& surface, const Base& base, const Lattice& lattice)
    : surface_(surface), base_(base), lattice_(lattice), base_face_(surface.faces.size(), kNoIndex) {
  for (uint32_t f = 0; f < base.map_faces.size(); ++f) base_face_[base.map_faces[f]] = f;
}

LatticeCell CrossingFinder::cellOf(const SurfacePoint& on_original) const {
  const SurfacePoint at = base_.map.toCoarse(on_original);
  return lattice_.cellAt(base_face_[at.face], at.weights);
}

// Finds the crossings of one crease edge by bisection of its parameter.
struct CrossingFinder::Tracer {
  const CrossingFinder& finder;
  uint32_t edge;
  std::vector<Crossing>& found;

  void trace(double from, const LatticeCell& first, double to, const LatticeCell& last, int depth) {
    const bool is_same = first.vertices == last.vertices;
    if (depth >= kMinBisections && (is_same || (std::fabs(to - from) < kNear && isCrossed(from, to, first, last))))
      return;
    const double middle = (from + to) / 2;
    const LatticeCell cell = finder.cellOf(onEdge(edge, middle));
    trace(from, first, middle, cell, depth + 1);
    trace(middle, cell, to, last, depth + 1);
  }
  // Records the lattice edge that the two cells share. False if they share none and a cell may lie between them.
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
