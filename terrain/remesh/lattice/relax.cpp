#include "terrain/remesh/lattice/relax.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <utility>

#include "terrain/parallel.h"
#include "terrain/remesh/original/trace_geodesic.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr uint64_t kVerticesAtOnce = 256;  // vertices of a piece of work
constexpr double kSoftness = 0.05;         // area, relative to the wanted one, at which the penalty for folding sets in
constexpr double kSizeWeight = 1;          // of a triangle's size relative to its shape
constexpr double kCrushed = 0.02;          // relative area below which a triangle counts as folded
constexpr int kRepairs = 3;                // times that vertices are released from the creases where triangles fold
constexpr int kTries = 4;                  // step lengths of the line search, each 0.4 times the one before

// A triangle at a vertex: its other two corners, counter-clockwise.
struct Wedge {
  uint32_t b = 0, c = 0, base_face = 0;
};

// The wedges of all vertices, in one array.
struct Wedges {
  std::vector<Wedge> all;
  std::vector<uint64_t> ends;

  std::span<const Wedge> of(uint32_t v) const {
    const uint64_t begin = v == 0 ? 0 : ends[v - 1];
    return {all.data() + begin, ends[v] - begin};
  }
};

Wedges findWedges(const Lattice& lattice, const std::vector<Triangle>& triangles) {
  Wedges found;
  found.ends.resize(lattice.vertexCount());
  for (const Triangle& t : triangles)
    for (uint32_t v : t) ++found.ends[v];
  for (size_t v = 1; v < found.ends.size(); ++v) found.ends[v] += found.ends[v - 1];
  found.all.resize(found.ends.back());
  std::vector<uint64_t> at = found.ends;
  const uint64_t per_face = static_cast<uint64_t>(lattice.side()) * lattice.side();
  for (size_t i = triangles.size(); i-- > 0;)
    for (uint32_t k = 0; k < 3; ++k) {
      const Triangle& t = triangles[i];
      found.all[--at[t[k]]] = {t[(k + 1) % 3], t[(k + 2) % 3], static_cast<uint32_t>(i / per_face)};
    }
  return found;
}

// A greedy graph colouring of the movable vertices: no two of a colour are neighbours, so they may move at the same
// time.
std::vector<std::vector<uint32_t>> findColours(const Wedges& wedges, const std::vector<Constraint>& constraints) {
  std::vector<std::vector<uint32_t>> colours;
  std::vector<uint8_t> colour_of(wedges.ends.size(), 255);
  for (uint32_t v = 0; v < colour_of.size(); ++v) {
    uint64_t used = 0;
    for (const Wedge& w : wedges.of(v))
      for (uint32_t n : {w.b, w.c})
        if (colour_of[n] < 64) used |= 1ull << colour_of[n];
    colour_of[v] = static_cast<uint8_t>(std::countr_one(used));
    if (colours.size() <= colour_of[v]) colours.resize(colour_of[v] + 1u);
    if (constraints[v] != Constraint::kFixed) colours[colour_of[v]].push_back(v);
  }
  return colours;
}

class Relaxer {
 public:
  Relaxer(const Original& surface, const EdgeFlags& creases, const Lattice& lattice, Embedding& embedding)
      : surface_(surface),
        twins_(surface.twins),
        base_vertices_(lattice.baseVertexCount()),
        embedding_(embedding),
        points_(embedding.points),
        positions_(points_.size()),
        normals_(points_.size()),
        is_released_(points_.size()) {
    for (size_t f = 0; f < creases.size(); ++f)
      for (size_t k = 0; k < 3; ++k)
        if (creases[f][k]) twins_[f][k] = kNoIndex;
    for (const Triangle& t : surface.faces) face_normals_.push_back(normalOf(t, surface.positions));
    for (uint32_t v = 0; v < points_.size(); ++v) moveTo(v, points_[v]);
    const std::vector<Triangle> triangles = lattice.triangles();
    wedges_ = findWedges(lattice, triangles);
    measureSizes(triangles, static_cast<uint64_t>(lattice.side()) * lattice.side());
  }

  void run(const RelaxOptions& options) {
    runRounds(options);
    for (int repair = 0; repair < kRepairs && releaseFolded(); ++repair) runRounds(options);
  }

 private:
  void runRounds(const RelaxOptions& options) {
    const auto colours = findColours(wedges_, embedding_.constraints);
    for (int round = 0; round < options.rounds; ++round)
      for (const auto& vertices : colours)
        parallelFor((vertices.size() + kVerticesAtOnce - 1) / kVerticesAtOnce, options.threads,
                    [&](uint64_t chunk, unsigned) {
                      for (uint64_t i = chunk * kVerticesAtOnce;
                           i < std::min<uint64_t>(vertices.size(), (chunk + 1) * kVerticesAtOnce); ++i)
                        improve(vertices[i]);
                    },
                    [](uint64_t) { return true; });
  }

  // Frees vertices that were snapped to a crease where that folds or crushes a triangle; they may cross creases from
  // then on. Returns whether there were any.
  bool releaseFolded() {
    std::vector<uint32_t> found;
    for (uint32_t v = 0; v < points_.size(); ++v) {
      const bool is_snapped = embedding_.constraints[v] == Constraint::kOnCurve
                                  ? embedding_.curve_of[v] >= embedding_.base_curves
                                  : !isFree(v) && v >= base_vertices_;
      if (!is_snapped) continue;
      for (const Wedge& w : wedges_.of(v))
        if (shapeOf(w, v, positions_[v], normals_[v]).area < kCrushed) {
          found.push_back(v);
          break;
        }
    }
    for (uint32_t v : found) embedding_.constraints[v] = Constraint::kFree, is_released_[v] = true;
    return !found.empty();
  }
  void moveTo(uint32_t v, const SurfacePoint& point) {
    points_[v] = point;
    positions_[v] = positionOf(point, surface_.positions, surface_.faces);
    normals_[v] = face_normals_[point.face];
  }

  // The wanted size is the mean area of the triangles of each base face, so relaxing keeps the density that the base
  // mesh has chosen.
  void measureSizes(const std::vector<Triangle>& triangles, uint64_t per_face) {
    wanted_area_.resize(triangles.size() / per_face);
    for (size_t i = 0; i < triangles.size(); ++i) {
      const dvec3 &a = positions_[triangles[i][0]], &b = positions_[triangles[i][1]], &c = positions_[triangles[i][2]];
      wanted_area_[i / per_face] += glm::length(glm::cross(b - a, c - a)) / 2 / static_cast<double>(per_face);
    }
  }

  // One triangle with vertex v at p: its area and squared sides, in units of an equilateral triangle of the wanted
  // size.
  struct Shape {
    double area, sides, soft_area,
        soft_slope;  // soft_area: a positive stand-in for the area, which may be negative; and its slope
    dvec3 facing;
    double energy() const { return (sides + kSizeWeight * (area * area + 1) / 2) / soft_area; }
  };
  Shape shapeOf(const Wedge& w, uint32_t v, const dvec3& p, const dvec3& normal) const {
    const dvec3 &b = positions_[w.b], &c = positions_[w.c];
    Shape shape{};
    // Vertices on creases have no normal of their own, so free neighbours decide which way is outward.
    dvec3 facing = isFree(v) ? normal : dvec3(0);
    for (uint32_t n : {w.b, w.c})
      if (isFree(n)) facing += normals_[n];
    if (facing == dvec3(0)) facing = normal + normals_[w.b] + normals_[w.c];
    const double length = glm::length(facing);
    shape.facing = length > 0 ? facing / length : normal;
    const double size = wanted_area_[w.base_face];
    shape.area = 0.5 * glm::dot(shape.facing, glm::cross(b - p, c - p)) / size;
    shape.sides =
        (glm::dot(b - p, b - p) + glm::dot(c - p, c - p) + glm::dot(c - b, c - b)) / (4 * std::numbers::sqrt3 * size);
    const double root = std::sqrt(shape.area * shape.area + kSoftness * kSoftness);
    shape.soft_area = (shape.area + root) / 2;
    shape.soft_slope = shape.soft_area / root;
    return shape;
  }
  double energyAt(uint32_t v, const SurfacePoint& point) const {
    const dvec3 p = positionOf(point, surface_.positions, surface_.faces);
    double sum = 0;
    for (const Wedge& w : wedges_.of(v))
      sum += wanted_area_[w.base_face] * shapeOf(w, v, p, face_normals_[point.face]).energy();
    return sum;
  }

  bool isFree(uint32_t v) const { return embedding_.constraints[v] == Constraint::kFree; }

  void improve(uint32_t v) {
    const dvec3 step = newtonStep(v);
    const double before = energyAt(v, points_[v]);
    double share = 1;
    for (int i = 0; i < kTries; ++i, share *= 0.4)
      if (isFree(v) ? tryTrace(v, share * step, before) : trySlide(v, share * step, before)) return;
  }
  bool tryTrace(uint32_t v, const dvec3& step, double before) {
    const SurfacePoint there = traceGeodesic(surface_, is_released_[v] ? surface_.twins : twins_, points_[v], step);
    if (!(energyAt(v, there) < before)) return false;
    moveTo(v, there);
    return true;
  }
  bool trySlide(uint32_t v, const dvec3& step, double before) {
    const FeatureCurve& curve = embedding_.curves[embedding_.curve_of[v]];
    double& along = embedding_.along[v];
    const double wanted = std::clamp(along + glm::dot(step, curve.direction(along)), 0.0, curve.length());
    const SurfacePoint there = curve.at(wanted);
    if (!(energyAt(v, there) < before)) return false;
    along = wanted;
    moveTo(v, there);
    return true;
  }
  // A Newton step in the tangent plane with the positive definite part of the Hessian, so it always descends.
  dvec3 newtonStep(uint32_t v) const {
    const dvec3 &p = positions_[v], &n = normals_[v];
    const dvec3 x = glm::normalize(glm::cross(n, std::fabs(n.x) < 0.6 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
    const dvec3 y = glm::cross(n, x);
    dvec3 slope(0);
    double xx = 0, xy = 0, yy = 0;
    for (const Wedge& w : wedges_.of(v)) {
      const dvec3 &b = positions_[w.b], &c = positions_[w.c];
      const Shape s = shapeOf(w, v, p, n);
      const double size = wanted_area_[w.base_face], soft = s.soft_area, bend = s.soft_slope / soft;
      const double to_sides = 2 / (4 * std::numbers::sqrt3 * size);
      const dvec3 area_slope = 0.5 * glm::cross(s.facing, c - b) / size;
      const double top = s.sides + kSizeWeight * (s.area * s.area + 1) / 2;
      slope += size * (to_sides * ((p - b) + (p - c)) + (kSizeWeight * s.area - top * bend) * area_slope) / soft;
      const double same = size * 2 * to_sides / soft, across = size * (2 * top * bend * bend + kSizeWeight) / soft;
      const double ax = glm::dot(area_slope, x), ay = glm::dot(area_slope, y);
      xx += same + across * ax * ax, xy += across * ax * ay, yy += same + across * ay * ay;
    }
    const double sx = glm::dot(slope, x), sy = glm::dot(slope, y), all = xx * yy - xy * xy;
    return -((yy * sx - xy * sy) / all) * x - ((xx * sy - xy * sx) / all) * y;
  }

  const Original& surface_;
  std::vector<Triangle> twins_;  // of the surface, with creases blocked like borders
  uint32_t base_vertices_;
  Embedding& embedding_;
  std::vector<SurfacePoint>& points_;
  std::vector<dvec3> positions_, normals_, face_normals_;
  Wedges wedges_;
  std::vector<bool> is_released_;
  std::vector<double> wanted_area_;  // of a triangle, by base face
};

}  // namespace

void relax(const Original& surface, const EdgeFlags& creases, const Lattice& lattice, const RelaxOptions& options,
           Embedding& embedding) {
  Relaxer(surface, creases, lattice, embedding).run(options);
}

}  // namespace foreland::terrain
