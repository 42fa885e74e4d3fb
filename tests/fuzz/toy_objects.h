// The objects of the fuzzers: sections of resume messages and changes of objects refer to these. Changes are laid out
// like deltas of the terrain (toy_flight.h).
#pragma once

#include "proto/refine/surface/objects.h"
#include "tests/fuzz/toy_flight.h"

namespace foreland::test {

inline proto::Epochs toyEpochs() {
  std::vector<proto::Epoch> epochs;
  for (const int64_t time : {0, 3, 10, 11}) epochs.push_back({Time{time}, {}});
  return proto::Epochs::create({1, 1, 1, 3, 3}, std::move(epochs)).value();
}

// Tetrahedra by either rule; two objects share a model, the other one has three poses.
inline const proto::ObjectSet& toyObjects() {
  static const proto::ObjectSet set = [] {
    std::vector<proto::ObjectModel> models;
    for (const proto::MeshRule rule : {proto::MeshRule::kQuadrisection, proto::MeshRule::kBisection}) {
      proto::ObjectModel model;
      model.shape = {rule, 3, 4, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}};
      model.quantum_m = 0.01;
      model.base = {{0, 0, 0}, {900, 0, 0}, {0, 900, 0}, {0, 0, 900}};
      if (rule == proto::MeshRule::kBisection)  // the centres of its faces
        for (const glm::ivec3 centre : {glm::ivec3(300, 300, 0), {0, 300, 300}, {300, 0, 300}, {300, 300, 300}})
          model.base.push_back(centre);
      if (rule == proto::MeshRule::kBisection) {
        model.pose_epochs = {0, 1, 3};
        for (size_t move = 0; move < 2 * model.base.size(); ++move)
          model.base_moves.emplace_back(7 * static_cast<int>(move), -90, 0);
      }
      models.push_back(model);
    }
    return proto::ObjectSet::create(std::move(models),
                                    {{.model = 0, .position = {150, 110, 240}},
                                     {.model = 1, .position = {170, 120, 250}},
                                     {.model = 0, .position = {190, 140, 220}}},
                                    toyEpochs())
        .value();
  }();
  return set;
}

}  // namespace foreland::test
