// Objects of either rule, from formulas: spheres (even numbers) and tori (odd ones) in a ring above a scene.
#pragma once

#include <cmath>
#include <vector>

#include "server/section/hierarchy.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/surface/bounds.h"
#include "terrain/surface/shapes.h"
#include "tests/support/surfaces.h"

namespace foreland::test {

struct Models {
  std::vector<terrain::TrueSurface> surfaces;
  std::vector<std::vector<proto::SurfaceRecord>> records;
  std::vector<std::vector<glm::ivec3>> moves;

  // With so many poses besides the first.
  explicit Models(size_t poses) {
    surfaces.push_back(*terrain::makeSphere(1, {proto::MeshRule::kQuadrisection, 4, 1e-4}));
    surfaces.push_back(*terrain::makeTorus({2, 0.8, 4, 3}, {proto::MeshRule::kBisection, 3, 1e-4}));
    for (terrain::TrueSurface& s : surfaces) {
      addPoses(s, poses, 0.5, 0.1, surfaces.size());
      records.push_back(terrain::computeBounds(s, {.threads = 1}));
      moves.push_back(terrain::nodeMoves(s));
    }
  }
};

inline const Models& models() {
  static const Models all(0);
  return all;
}

// Of scenes that change in time.
inline const Models& posedModels() {
  static const Models all(2);
  return all;
}

// At the first epoch, the one after it and the last.
inline proto::ObjectModel modelOf(const terrain::TrueSurface& s, const proto::Epochs& epochs) {
  proto::ObjectModel model{s.topology.shape(), s.quantum_m, s.base};
  if (!s.poses.empty()) model.pose_epochs = {0, 1, static_cast<uint32_t>(epochs.size() - 1)};
  model.base_moves = terrain::baseMoves(s);
  return model;
}

// In a ring above the middle of the scene. Where the ground moves it carries them, and they have poses unless these
// could overshoot. Over a globe the ring leads over four faces of its cube. Their sizes are times `scale`.
inline server::SceneObjects objectsIn(const terrain::Scene& scene, uint32_t count, double scale = 1) {
  const proto::Epochs& epochs = scene.epochs().epochs();
  const bool have_poses = epochs.size() >= 3 && epochs.blend() != proto::EpochBlend::kCatmullRom;
  const Models& of = have_poses ? posedModels() : models();
  std::vector<proto::ObjectModel> shapes;
  for (const terrain::TrueSurface& s : of.surfaces) shapes.push_back(modelOf(s, epochs));
  const proto::FrameGrid frame(scene.frame(), scene.grid().maxX(), scene.grid().maxY());
  const proto::GridShape& shape = scene.grid().shape();
  std::vector<proto::ObjectPlacement> placements;
  for (uint32_t i = 0; i < count; ++i) {
    const double around = 6.28 * i / count, r = 0.3;
    const proto::LatticePosition place{shape.samples_x * (0.5 + r * std::cos(around)),
                                       shape.samples_y * (0.5 + r * std::sin(around)), 900};
    const glm::dvec3 position = frame.transform().toScene(place);
    placements.push_back({i % 2, position, glm::angleAxis(around, glm::dvec3(0.6, 0, 0.8)),
                          scale * (40.0 + 10.0 * (i % 3)), terrain::riseAt(scene, position)});
  }
  server::SceneObjects objects;
  objects.set = proto::ObjectSet::create(std::move(shapes), std::move(placements), epochs).value();
  for (size_t i = 0; i < of.surfaces.size(); ++i)
    objects.nodes.push_back({of.records[i], of.moves[i], of.surfaces[i].poses.size()});
  return objects;
}

}  // namespace foreland::test
