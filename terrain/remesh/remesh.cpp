#include "terrain/remesh/remesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "terrain/parallel.h"
#include "terrain/remesh/importance.h"
#include "terrain/remesh/lattice/embedding.h"
#include "terrain/remesh/lattice/relax.h"
#include "terrain/remesh/original/creases.h"
#include "terrain/remesh/simplify/simplify.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr double kCreaseCosine = 0.766;  // of 40 degrees

// The vertices of the original as surface points.
std::vector<SurfacePoint> pointsOfVertices(const Original& original) {
  std::vector<SurfacePoint> points(original.positions.size());
  for (uint32_t f = 0; f < original.faces.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      SurfacePoint& point = points[original.faces[f][static_cast<size_t>(k)]];
      point = {f, dvec3(0)};
      point.weights[k] = 1;
    }
  return points;
}

// The lattice coordinates of a vertex in one of the base faces that contain it.
struct LatticeCoordinate {
  uint32_t face = kNoIndex, i = 0, j = 0;
};

std::vector<LatticeCoordinate> findCoordinates(const Lattice& lattice, size_t faces) {
  std::vector<LatticeCoordinate> points(lattice.vertexCount());
  for (uint32_t f = 0; f < faces; ++f)
    for (uint32_t j = 0; j <= lattice.side(); ++j)
      for (uint32_t i = 0; i + j <= lattice.side(); ++i)
        if (LatticeCoordinate& p = points[lattice.vertex(f, i, j)]; p.face == kNoIndex) p = {f, i, j};
  return points;
}

class Attempt {
 public:
  Attempt(const Original& original, const EdgeFlags& creases, const RemeshOptions& options,
          std::span<const double> importance)
      : original_(original),
        creases_(creases),
        options_(options),
        base_(simplify(
            original,
            {.target_faces = options.base_triangles, .crease_cosine = kCreaseCosine, .importance = importance})) {}

  Result<Remeshed> run(const std::vector<SurfacePoint>& at_vertices) {
    const auto base_vertices = static_cast<uint32_t>(base_.vertices.size());
    // An upper bound: 3/2 edges per face, and at most as many again at borders.
    if (Lattice::countVertices(base_vertices, 3 * base_.faces.size(), base_.faces.size(), options_.levels) >
        kMaxLatticeVertices)
      return Error{ErrorCode::kLimit, std::to_string(base_.faces.size()) + " base triangles and " +
                                          std::to_string(options_.levels) +
                                          " levels make more than 134217728 vertices; ask for fewer levels"};
    Lattice lattice(base_.faces, base_vertices, options_.levels);
    Embedding embedding(mapToOriginal(lattice));
    for (uint32_t v = 0; v < base_vertices; ++v) embedding.fix(v, at_vertices[base_.vertices[v]]);
    constrainToCurves(original_, base_, lattice, embedding);
    snapToCreases(original_, creases_, base_, lattice, embedding);
    relax(original_, creases_, lattice, {options_.relax_rounds, options_.threads}, embedding);
    return finish(std::move(lattice), std::move(embedding.points));
  }

 private:
  std::vector<SurfacePoint> mapToOriginal(const Lattice& lattice) const {
    constexpr uint64_t kCoordinatesAtOnce = 4096;
    const std::vector<LatticeCoordinate> coordinates = findCoordinates(lattice, base_.faces.size());
    std::vector<SurfacePoint> points(coordinates.size());
    const uint32_t n = lattice.side();
    parallelFor((coordinates.size() + kCoordinatesAtOnce - 1) / kCoordinatesAtOnce, options_.threads,
                [&](uint64_t chunk, unsigned) {
                  for (uint64_t v = chunk * kCoordinatesAtOnce;
                       v < std::min<uint64_t>(coordinates.size(), (chunk + 1) * kCoordinatesAtOnce); ++v) {
                    const auto [face, i, j] = coordinates[v];
                    points[v] = base_.map.toOriginal({base_.map_faces[face], dvec3(n - i - j, i, j) / double(n)});
                  }
                },
                [](uint64_t) { return true; });
    return points;
  }
  Remeshed finish(Lattice lattice, std::vector<SurfacePoint> points) const {
    Remeshed made{{}, base_.faces, std::move(lattice), std::move(points), {}};
    for (uint32_t v : base_.vertices) made.base_vertices.push_back(original_.positions[v]);
    made.positions.reserve(made.points.size());
    for (const SurfacePoint& point : made.points)
      made.positions.push_back(positionOf(point, original_.positions, original_.faces));
    return made;
  }

  const Original& original_;
  const EdgeFlags& creases_;
  const RemeshOptions& options_;
  Base base_;
};

}  // namespace

Remeshed posedAs(const Remeshed& remeshed, const Original& original, const std::vector<dvec3>& positions) {
  Remeshed posed = remeshed;
  for (size_t v = 0; v < posed.points.size(); ++v)
    posed.positions[v] = positionOf(posed.points[v], positions, original.faces);
  std::copy_n(posed.positions.begin(), posed.base_vertices.size(), posed.base_vertices.begin());
  return posed;
}

Result<Remeshed> remesh(const Original& original, const RemeshOptions& options) {
  const EdgeFlags creases = findCreases(original, kCreaseCosine);
  const std::vector<SurfacePoint> at_vertices = pointsOfVertices(original);
  Importance importance(original, options.threads);
  std::optional<Remeshed> best;
  Importance::AttemptCost least{true, INFINITY};
  for (int attempt = 0; attempt < options.attempts && (!best || options.keep_going(attempt)); ++attempt) {
    Result<Remeshed> made = Attempt(original, creases, options, importance.weights()).run(at_vertices);
    if (!made.ok()) {
      if (best) break;
      return made.error();
    }
    const auto cost = importance.update(made->lattice.triangles(), made->positions, made->points);
    if (!best || cost < least) least = cost, best = std::move(made).value();
  }
  return std::move(*best);
}

}  // namespace foreland::terrain
