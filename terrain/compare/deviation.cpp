#include "terrain/compare/deviation.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>
#include <vector>

#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;
using Corners = std::array<dvec3, 3>;

constexpr uint64_t kChunk = 256;  // triangles of a piece of work
constexpr auto kAlways = [](uint64_t) { return true; };

Corners cornersOf(const MeshView& mesh, uint64_t face) {
  const auto& t = mesh.faces[face];
  return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

// The largest distance from a triangle, or anything below `least` if it is not above that by more than the tolerance.
double largestFrom(const Corners& whole, const ClosestPoint& to, double least, double tolerance) {
  double largest = 0;
  std::vector<Corners> waiting{whole};
  while (!waiting.empty()) {
    const Corners t = waiting.back();
    waiting.pop_back();
    const dvec3 centre = (t[0] + t[1] + t[2]) / 3.0;
    const PointOnMesh at = to.find(centre);
    largest = std::max(largest, at.distance);
    double radius = 0, to_face = 0;
    for (const dvec3& corner : t) {
      radius = std::max(radius, glm::distance(centre, corner));
      to_face = std::max(to_face, to.distanceToFace(corner, at.face));
    }
    if (std::min(at.distance + radius, to_face) <= std::max(least, largest) + tolerance) continue;
    const dvec3 ab = (t[0] + t[1]) / 2.0, bc = (t[1] + t[2]) / 2.0, ca = (t[2] + t[0]) / 2.0;
    waiting.insert(waiting.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
  }
  return largest;
}

template <class Work>
void forChunks(uint64_t count, unsigned threads, const Work& work) {
  parallelFor((count + kChunk - 1) / kChunk, threads,
              [&](uint64_t chunk, unsigned) {
                for (uint64_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) work(i);
              },
              kAlways);
}

// Sums of angle-weighted normals at the surface's corners, and of normals at its edges.
class Facing {
 public:
  explicit Facing(const MeshView& surface) : surface_(surface), at_corner_(surface.positions.size(), dvec3(0)) {
    for (uint64_t f = 0; f < surface.faces.size(); ++f) {
      const Corners p = cornersOf(surface, f);
      const dvec3 normal = normalOf(p);
      for (uint32_t k = 0; k < 3; ++k) {
        const dvec3 a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
        at_corner_[surface.faces[f][k]] += std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * normal;
        const auto [edge, is_new] = at_edge_.try_emplace(edgeOf(f, k), dvec3(0));
        edge->second += normal;
      }
    }
  }
  dvec3 at(const PointOnMesh& place) const {
    int zeros = 0, other = 0;
    for (int k = 0; k < 3; ++k) zeros += place.weights[k] == 0, other += place.weights[k] == 0 ? k : 0;
    if (zeros == 0) return normalOf(cornersOf(surface_, place.face));
    if (zeros == 1) return at_edge_.at(edgeOf(place.face, static_cast<uint32_t>(other + 1) % 3));
    return at_corner_[surface_.faces[place.face][static_cast<size_t>(3 - other)]];
  }
  static dvec3 normalOf(const Corners& p) {
    const dvec3 area = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double length = glm::length(area);
    return length > 0 ? area / length : dvec3(0);
  }

 private:
  std::pair<uint32_t, uint32_t> edgeOf(uint64_t face, uint32_t k) const {
    const auto& t = surface_.faces[face];
    return {std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
  }

  const MeshView& surface_;
  std::vector<dvec3> at_corner_;
  std::map<std::pair<uint32_t, uint32_t>, dvec3> at_edge_;
};

}  // namespace

double largestDistance(MeshView from, const ClosestPoint& to, double tolerance, unsigned threads) {
  // First the corners: most triangles need no more than to be compared with the worst of them.
  std::vector<double> found(from.positions.size());
  forChunks(from.positions.size(), threads, [&](uint64_t i) { found[i] = to.find(from.positions[i]).distance; });
  double least = 0;
  for (const auto& t : from.faces)
    for (uint32_t v : t) least = std::max(least, found[v]);
  found.assign(from.faces.size(), 0);
  forChunks(from.faces.size(), threads,
            [&](uint64_t i) { found[i] = largestFrom(cornersOf(from, i), to, least, tolerance); });
  return std::max(least, *std::max_element(found.begin(), found.end()));
}

std::vector<uint32_t> findFlipped(MeshView mesh, const ClosestPoint& surface, unsigned threads) {
  const Facing facing(surface.mesh());
  std::vector<uint8_t> is_flipped(mesh.faces.size());
  forChunks(mesh.faces.size(), threads, [&](uint64_t i) {
    const Corners p = cornersOf(mesh, i);
    const dvec3 centre = (p[0] + p[1] + p[2]) / 3.0;
    is_flipped[i] = !(glm::dot(Facing::normalOf(p), facing.at(surface.find(centre))) > 0);
  });
  std::vector<uint32_t> flipped;
  for (uint32_t i = 0; i < is_flipped.size(); ++i)
    if (is_flipped[i]) flipped.push_back(i);
  return flipped;
}

}  // namespace foreland::terrain
