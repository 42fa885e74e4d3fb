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

// Some face at each vertex of the original.
std::vector<SurfacePoint> placesOfVertices(const Original& original) {
  std::vector<SurfacePoint> places(original.positions.size());
  for (uint32_t f = 0; f < original.faces.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      SurfacePoint& place = places[original.faces[f][static_cast<size_t>(k)]];
      place = {f, dvec3(0)};
      place.weights[k] = 1;
    }
  return places;
}

// A lattice vertex in one of the base faces that hold it.
struct LatticePoint {
  uint32_t face = kNoIndex, i = 0, j = 0;
};

std::vector<LatticePoint> findPoints(const Lattice& lattice, size_t faces) {
  std::vector<LatticePoint> points(lattice.vertexCount());
  for (uint32_t f = 0; f < faces; ++f)
    for (uint32_t j = 0; j <= lattice.side(); ++j)
      for (uint32_t i = 0; i + j <= lattice.side(); ++i)
        if (LatticePoint& p = points[lattice.vertex(f, i, j)]; p.face == kNoIndex) p = {f, i, j};
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
    // At most one edge and a half for each face, and as many again at borders.
    if (Lattice::countVertices(base_vertices, 3 * base_.faces.size(), base_.faces.size(), options_.levels) >
        kMaxLatticeVertices)
      return Error{ErrorCode::kLimit, std::to_string(base_.faces.size()) + " base triangles and " +
                                          std::to_string(options_.levels) +
                                          " levels make more than 134217728 vertices; ask for fewer levels"};
    Lattice lattice(base_.faces, base_vertices, options_.levels);
    Placement placement(carry(lattice));
    for (uint32_t v = 0; v < base_vertices; ++v) placement.fix(v, at_vertices[base_.vertices[v]]);
    layRails(original_, base_, lattice, placement);
    snapToCreases(original_, creases_, base_, lattice, placement);
    relax(original_, creases_, lattice, {options_.relax_rounds, options_.threads}, placement);
    return finish(std::move(lattice), std::move(placement.places));
  }

 private:
  std::vector<SurfacePoint> carry(const Lattice& lattice) const {
    constexpr uint64_t kChunk = 4096;
    const std::vector<LatticePoint> points = findPoints(lattice, base_.faces.size());
    std::vector<SurfacePoint> places(points.size());
    const uint32_t n = lattice.side();
    parallelFor((points.size() + kChunk - 1) / kChunk, options_.threads,
                [&](uint64_t chunk, unsigned) {
                  for (uint64_t v = chunk * kChunk; v < std::min<uint64_t>(points.size(), (chunk + 1) * kChunk); ++v) {
                    const auto [face, i, j] = points[v];
                    places[v] = base_.map.carryBack({base_.numbers[face], dvec3(n - i - j, i, j) / double(n)});
                  }
                },
                [](uint64_t) { return true; });
    return places;
  }
  Remeshed finish(Lattice lattice, std::vector<SurfacePoint> places) const {
    Remeshed made{{}, base_.faces, std::move(lattice), std::move(places), {}};
    for (uint32_t v : base_.vertices) made.base_vertices.push_back(original_.positions[v]);
    made.positions.reserve(made.places.size());
    for (const SurfacePoint& place : made.places)
      made.positions.push_back(placeOf(place, original_.positions, original_.faces));
    return made;
  }

  const Original& original_;
  const EdgeFlags& creases_;
  const RemeshOptions& options_;
  Base base_;
};

}  // namespace

Result<Remeshed> remesh(const Original& original, const RemeshOptions& options) {
  const EdgeFlags creases = findCreases(original, kCreaseCosine);
  const std::vector<SurfacePoint> at_vertices = placesOfVertices(original);
  Importance importance(original, options.threads);
  std::optional<Remeshed> best;
  Importance::Badness least{true, INFINITY};
  for (int attempt = 0; attempt < options.attempts && (!best || options.keep_going(attempt)); ++attempt) {
    Result<Remeshed> made = Attempt(original, creases, options, importance.weights()).run(at_vertices);
    if (!made.ok()) {
      if (best) break;
      return made.error();
    }
    const auto badness = importance.learn(made->lattice.triangles(), made->positions, made->places);
    if (!best || badness < least) least = badness, best = std::move(made).value();
  }
  return std::move(*best);
}

}  // namespace foreland::terrain
