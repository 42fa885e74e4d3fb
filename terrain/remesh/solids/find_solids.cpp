#include "terrain/remesh/solids/find_solids.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "terrain/remesh/solids/directions.h"
#include "terrain/remesh/solids/inner_cells.h"
#include "terrain/remesh/solids/obstacles.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr int kMaxPoints = 10;           // from which solids are grown
constexpr double kLeastGain = 1.0 / 50;  // of the inner cells, for one more solid

// A solid that is looked for, and the cells that it holds.
struct Candidate {
  ConvexSolid solid;
  std::vector<uint32_t> cells;
};

// The solid from a point with planes of some of the obstacles' directions, or none: the largest of all sets of them.
std::optional<ConvexSolid> largestFrom(const dvec3& point, const Obstacles& obstacles, const DirectionSets& sets,
                                       double min_thickness) {
  std::optional<ConvexSolid> best;
  double largest = 0;
  for (const std::vector<uint32_t>& set : sets) {
    const std::vector<SolidPlane> planes = obstacles.grow(point, set);
    if (planes.empty()) continue;
    const SolidShape shape = shapeOf(planes, obstacles.reach());
    if (shape.volume <= largest || shape.thickness < min_thickness) continue;
    largest = shape.volume;
    best = makeSolid(planes, obstacles.reach());
  }
  return best;
}

std::vector<Candidate> findCandidates(const Obstacles& obstacles, const DirectionSets& sets, InnerCells& cells,
                                      double min_thickness) {
  std::vector<Candidate> found;
  for (int i = 0; i < kMaxPoints; ++i) {
    const std::optional<uint32_t> deepest = cells.deepestLeft();
    if (!deepest) break;
    cells.take(*deepest);
    const auto solid = largestFrom(cells.middle(*deepest), obstacles, sets, min_thickness);
    if (!solid) continue;
    found.push_back({*solid, cells.inside(*solid)});
    for (const uint32_t cell : found.back().cells) cells.take(cell);
  }
  return found;
}

// At most kMaxSolids, each time the one that adds most.
std::vector<ConvexSolid> choose(std::vector<Candidate> candidates, const InnerCells& cells) {
  std::vector<ConvexSolid> chosen;
  std::vector<bool> held(cells.count(), false);
  while (chosen.size() < InnerSolids::kMaxSolids) {
    const auto gainOf = [&](const Candidate& c) {
      return std::ranges::count_if(c.cells, [&](uint32_t cell) { return !held[cell]; });
    };
    const auto best = std::ranges::max_element(candidates, {}, gainOf);
    if (best == candidates.end()) break;
    const auto gain = static_cast<double>(gainOf(*best));
    if (!chosen.empty() && gain < kLeastGain * static_cast<double>(cells.innerCount())) break;
    for (const uint32_t cell : best->cells) held[cell] = true;
    chosen.push_back(best->solid);
    candidates.erase(best);
  }
  return chosen;
}

// What both of two solids hold, one plane for each direction.
void intersect(std::vector<SolidPlane>& planes, const ConvexSolid& solid) {
  for (const SolidPlane& plane : solid.planes()) {
    const auto same = std::ranges::find(planes, plane.normal, &SolidPlane::normal);
    if (same == planes.end())
      planes.push_back(plane);
    else
      same->offset = std::max(same->offset, plane.offset);
  }
}

// Of the union, by inclusion and exclusion.
double volumeOf(std::span<const ConvexSolid> solids, double reach) {
  double volume = 0;
  for (uint32_t subset = 1; subset < 1u << solids.size(); ++subset) {
    std::vector<SolidPlane> planes;
    for (size_t i = 0; i < solids.size(); ++i)
      if (subset >> i & 1) intersect(planes, solids[i]);
    volume += (std::popcount(subset) % 2 == 1 ? 1 : -1) * shapeOf(planes, reach).volume;
  }
  return volume;
}

double volumeOf(const FullMesh& mesh) {
  double volume = 0;
  const dvec3 origin = mesh.position(0);
  for (const auto& t : mesh.triangles())
    volume +=
        glm::dot(mesh.position(t[0]) - origin, glm::cross(mesh.position(t[1]) - origin, mesh.position(t[2]) - origin)) /
        6;
  return volume;
}

// Why there can be none, if so.
std::string obstacleTo(const TrueSurface& surface) {
  const proto::MeshTopology& topology = surface.topology;
  const uint64_t triangles =
      (uint64_t{topology.base().faceCount()} * (topology.rule() == proto::MeshRule::kQuadrisection ? 1 : 3))
      << (2 * topology.halvings());
  if (!topology.base().isClosed()) return "the surface has a border";
  if (!surface.poses.empty()) return "the surface moves from pose to pose";
  if (triangles > kMaxSolidTriangles)
    return std::to_string(triangles) + " triangles are too many to look for them; fewer levels would do";
  return {};
}

}  // namespace

SolidsFound findSolids(const TrueSurface& surface) {
  SolidsFound found{{}, obstacleTo(surface)};
  if (!found.why_none.empty()) return found;
  const FullMesh mesh(surface);
  const double volume = volumeOf(mesh);
  InnerCells cells(mesh);
  if (!(volume > 0) || cells.innerCount() == 0) return {{}, "the surface has no inside"};
  const Directions directions = chooseDirections(mesh);
  const Obstacles obstacles(surface, mesh, directions.all);
  auto solids = choose(findCandidates(obstacles, directions.sets, cells, kMinSolidThickness * cells.diagonal()), cells);
  std::erase_if(solids, [&](const ConvexSolid& solid) { return !isInside(solid, surface); });
  if (solids.empty())
    return {{}, "what is inside of everything that may be drawn is thinner than 1/32 of the surface's size"};
  found.inner.volume_share = volumeOf(solids, obstacles.reach()) / volume;
  found.inner.solids = std::move(solids);
  return found;
}

}  // namespace foreland::terrain
