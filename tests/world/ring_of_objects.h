// Objects of either rule, from formulas: spheres (even numbers) and tori (odd ones) in a ring above a scene.
#pragma once

#include <cmath>
#include <vector>

#include "server/section/hierarchy.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface/shapes.h"

namespace foreland::test {

struct Models {
  std::vector<terrain::TrueSurface> surfaces;
  std::vector<std::vector<proto::SurfaceRecord>> records;

  Models() {
    surfaces.push_back(*terrain::makeSphere(1, {proto::MeshRule::kQuadrisection, 4, 1e-4}));
    surfaces.push_back(*terrain::makeTorus({2, 0.8, 4, 3}, {proto::MeshRule::kBisection, 3, 1e-4}));
    for (const terrain::TrueSurface& s : surfaces) records.push_back(terrain::computeBounds(s, {.threads = 1}));
  }
};

inline const Models& models() {
  static const Models all;
  return all;
}

// In a ring above the middle of the scene, carried by the ground below where it moves.
inline server::SceneObjects objectsIn(const terrain::Scene& scene, uint32_t count) {
  std::vector<proto::ObjectModel> shapes;
  for (const terrain::TrueSurface& s : models().surfaces) shapes.push_back({s.topology.shape(), s.quantum_m, s.base});
  const proto::FrameGrid frame(scene.frame(), scene.grid().maxX(), scene.grid().maxY());
  const proto::GridShape& shape = scene.grid().shape();
  std::vector<proto::ObjectPlacement> placements;
  for (uint32_t i = 0; i < count; ++i) {
    const double around = 6.28 * i / count, r = 0.3;
    const proto::LatticePosition place{shape.samples_x * (0.5 + r * std::cos(around)),
                                       shape.samples_y * (0.5 + r * std::sin(around)), 900};
    const glm::dvec3 position = frame.transform().toScene(place);
    placements.push_back({i % 2, position, glm::angleAxis(around, glm::dvec3(0.6, 0, 0.8)), 40.0 + 10.0 * (i % 3),
                          terrain::riseAt(scene, position)});
  }
  server::SceneObjects objects;
  objects.set = proto::ObjectSet::create(std::move(shapes), std::move(placements)).value();
  for (const auto& records : models().records) objects.records.emplace_back(records);
  return objects;
}

}  // namespace foreland::test
