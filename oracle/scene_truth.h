// The truth of a scene file, as the oracles take it.
#pragma once

#include <memory>

#include "oracle/globe/globe_oracle.h"
#include "oracle/scene_oracle.h"
#include "oracle/sparse_oracle.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/store/scene.h"

namespace foreland::oracle {

inline Truth truthOf(std::shared_ptr<const terrain::Scene> scene) {
  const proto::Epochs& epochs = scene->epochs().epochs();
  std::vector<Time> times;
  for (const proto::Epoch& epoch : epochs.all()) times.push_back(epoch.time);
  return {.frame = scene->frame(),
          .shape = scene->grid().shape(),
          .heights =
              [scene](uint32_t x, uint32_t y, std::span<int32_t> out) {
                for (size_t i = 0; i < out.size(); ++i)
                  out[i] = scene->height(proto::NodeId::at(x + static_cast<uint32_t>(i), y));
              },
          .epochs = std::move(times),
          .blend = epochs.blend(),
          .moved = epochs.empty() ? proto::LatticeWindow{} : epochs[epochs.size() - 1].moved,
          .offsets =
              [scene](size_t epoch, uint32_t x, uint32_t y, std::span<double> out) {
                for (size_t i = 0; i < out.size(); ++i)
                  out[i] = scene->epochs().offset(static_cast<uint32_t>(epoch), scene->grid(),
                                                  proto::NodeId::at(x + static_cast<uint32_t>(i), y));
              }};
}

// Terrain and objects. An Error if the section of objects is damaged.
inline Result<SceneOracle> sceneOracle(const std::shared_ptr<const terrain::Scene>& scene) {
  const auto objects = terrain::readObjects(scene);
  if (!objects) return objects.error();
  std::vector<proto::ModelNodes> nodes;
  for (const auto& model : objects->models) nodes.push_back({model->nodes(), model->nodeMoves(), model->movesEach()});
  ObjectsTruth truth = objectsTruth(objects->set, nodes);
  if (scene->frame().kind == proto::FrameKind::kGlobe)
    return SceneOracle(globeOracle(scene), scene->frame(), std::move(truth));
  if (scene->isSparse()) return SceneOracle(sparseOracle(scene), scene->frame(), std::move(truth));
  return SceneOracle(truthOf(scene), std::move(truth));
}

}  // namespace foreland::oracle
