#include "oracle/scene_oracle.h"

#include <algorithm>
#include <cmath>

namespace foreland::oracle {

std::vector<glm::dvec3> SceneOracle::carried() const {
  std::vector<glm::dvec3> carried;
  for (const ObjectTruth& object : objects_->truth().objects) {
    const proto::LatticePosition stands = frame_.toLattice(object.placement.position);
    proto::LatticePosition goes = stands;
    goes.height_m += terrain_.carriedAt(stands.x, stands.y) * frame_.frame().height_quantum_m;
    carried.push_back(frame_.toScene(goes) - frame_.toScene(stands));
  }
  return carried;
}

// A pose's share of an epoch is a hat over the dates: 1 at its own, 0 at those of its neighbours and beyond.
std::vector<std::vector<double>> SceneOracle::poseShares() const {
  std::vector<std::vector<double>> by_model;
  const std::span<const double> epochs = terrain_.sharesShown();
  const std::span<const Time> dates = terrain_.epochs();
  for (const ModelTruth& model : objects_->truth().models) {
    std::vector<double>& shares = by_model.emplace_back(model.pose_epochs.size());
    for (size_t pose = 0; pose < shares.size(); ++pose) {
      const Time own = dates[model.pose_epochs[pose]];
      for (size_t epoch = 0; epoch < epochs.size(); ++epoch) {
        const bool is_before = dates[epoch] < own;
        const bool is_last = is_before ? pose == 0 : pose + 1 == shares.size();
        const Time other = is_last ? own : dates[model.pose_epochs[is_before ? pose - 1 : pose + 1]];
        const double away =
            is_last || dates[epoch] == own ? 0 : (dates[epoch] - own).toSeconds() / (other - own).toSeconds();
        shares[pose] += epochs[epoch] * std::max(0.0, 1 - away);
      }
    }
  }
  return by_model;
}

SceneDeviation SceneOracle::error(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose,
                                  const proto::Lens& lens, double tolerance_px) {
  const DrawnShare drawn{.mesh = &mesh, .weight = weight};
  terrain_.showAt({mesh.from.scene_time, mesh.to.scene_time, weight, mesh.to.is_scene_step});
  const Sight sight{is_seen_, tolerance_px};
  if (patchwork_) patchwork_->setSight(sight);
  terrain_.setSight(sight);
  SceneDeviation all{patchwork_ ? patchwork_->error(mesh, weight, pose, lens)
                                : terrain_.error({&drawn, 1}, pose, lens)};
  const SurfaceJudgement objects = objects_->judge(mesh, weight, pose, lens, carried(), poseShares(), sight, stretch_);
  all.silhouette_px = objects.silhouette.max_px;
  all.interior_px = objects.interior.max_px;
  all.object_vertices = objects.silhouette.vertices + objects.interior.vertices;
  SurfaceErrors pixels{all.max_px, all.rms_px, all.samples}, interior = objects.interior;
  interior.max_px /= objects_->interiorPerTau();
  interior.rms_px /= objects_->interiorPerTau();
  pixels.merge(objects.silhouette);
  pixels.merge(interior);
  all.max_px = pixels.max_px;
  all.rms_px = pixels.rms_px;
  all.samples = pixels.vertices;
  all.max_m = std::max(all.max_m, objects.max_m);
  all.uncovered += objects.uncovered;
  if (!sources_) return all;
  all.sources = sources_->error(mesh, weight, pose, lens, sight);
  all.max_px = std::max(all.max_px, all.sources.excess_px);
  all.uncovered += all.sources.uncovered;
  return all;
}

CrackReport SceneOracle::findCracks(const client::KeyframeMesh& mesh, const proto::GridShape& shape) const {
  CrackReport all = oracle::findCracks(mesh, shape);
  const CrackReport objects = objects_->findCracks(mesh);
  if (all.cracks == 0) all.first = objects.first;
  all.cracks += objects.cracks;
  return all;
}

}  // namespace foreland::oracle
