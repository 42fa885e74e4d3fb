// What the refiner reads: topology, positions and the per-node bounds of one scene, without the file they come from.
// Immutable; shared by all threads.
#pragma once

#include <memory>
#include <span>

#include "proto/frame_grid.h"
#include "proto/grid.h"
#include "terrain/store/scene.h"

namespace foreland::server {

class Hierarchy {
 public:
  explicit Hierarchy(std::shared_ptr<const terrain::Scene> scene)
      : scene_(std::move(scene)), frame_(scene_->frame(), scene_->grid().maxX(), scene_->grid().maxY()) {}

  const terrain::Scene& scene() const { return *scene_; }
  const proto::GridTopology& grid() const { return scene_->grid(); }
  const proto::FrameGrid& frame() const { return frame_; }
  std::span<const terrain::NodeRecord> nodes() const { return scene_->nodes(); }
  // On a planar frame every error is purely vertical, which seen from above projects to almost nothing.
  bool hasVerticalErrors() const { return scene_->frame().kind == proto::FrameKind::kPlanar; }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  proto::FrameGrid frame_;
};

}  // namespace foreland::server
