#include "client/newest_mesh.h"

#include <glm/geometric.hpp>

namespace foreland::client {

const Interval* NewestMesh::take() {
  const Interval* newest = viewer_->timeline().newest();
  if (newest == nullptr || newest->version == taken_) return nullptr;
  taken_ = newest->version;
  if (draped_scene_ != viewer_->tiles().scene()) enterScene();
  drape_->advance(viewer_->frameGrid().transform(), newest->from, newest->to);
  return newest;
}

void NewestMesh::enterScene() {
  draped_scene_ = viewer_->tiles().scene();
  drape_.emplace(viewer_->tiles(), layers_);
  const proto::Welcome& welcome = *viewer_->welcome();
  const double quantum_m = welcome.frame.height_quantum_m;
  drape_->setHeights(viewer_->frameGrid().transform(), welcome.lowest * quantum_m, welcome.highest * quantum_m);
  drape_->setSun(sun_);
}

void NewestMesh::setSun(const std::optional<glm::dvec3>& sun) {
  sun_ = sun ? std::optional(glm::normalize(*sun)) : std::nullopt;
  if (drape_) drape_->setSun(sun_);
}

}  // namespace foreland::client
