// Where the vertices of a lattice lie on the original, and how each may move. Plain data; one owner.
#pragma once

#include <cstdint>
#include <vector>

#include "terrain/remesh/lattice/lattice.h"
#include "terrain/remesh/original/feature_curve.h"
#include "terrain/remesh/original/surface_point.h"
#include "terrain/remesh/simplify/simplify.h"

namespace foreland::terrain {

enum class Constraint : uint8_t { kFree, kOnCurve, kFixed };

struct Embedding {
  explicit Embedding(std::vector<SurfacePoint> at)
      : points(std::move(at)),
        constraints(points.size(), Constraint::kFree),
        curve_of(points.size(), kNoIndex),
        along(points.size(), 0.0) {}

  std::vector<SurfacePoint> points;
  std::vector<Constraint> constraints;
  std::vector<FeatureCurve> curves;  // first those of base edges, then creases that no base edge follows
  size_t base_curves = 0;
  std::vector<uint32_t> curve_of;  // of kOnCurve vertices: index into `curves`
  std::vector<double> along;       // and the arc length on it

  void fix(uint32_t v, const SurfacePoint& point) {
    points[v] = point;
    constraints[v] = Constraint::kFixed;
  }
  void putOnCurve(uint32_t v, uint32_t curve, double at) {
    points[v] = curves[curve].at(at);
    constraints[v] = Constraint::kOnCurve, curve_of[v] = curve, along[v] = at;
  }
};

// Constrains the lattice vertices of base edges that follow a border or crease to it, each at the nearest point.
void constrainToCurves(const Original& surface, const Base& base, const Lattice& lattice, Embedding& embedding);

// Constrains lattice vertices to the creases that run between them, so that no triangle cuts off an edge of the
// surface: where a crease crosses a lattice edge, one end of the edge, the nearer one if it is free, moves to the
// crossing. Few vertices move, since each resolves the neighbouring crossings of the same crease.
void snapToCreases(const Original& surface, EdgeFlags creases, const Base& base, const Lattice& lattice,
                   Embedding& embedding);

}  // namespace foreland::terrain
