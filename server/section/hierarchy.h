// What the refiner reads: topology, positions and the per-node bounds of one scene, without the file they come from.
// Immutable; shared by all threads.
#pragma once

#include <memory>
#include <span>

#include "proto/frame_grid.h"
#include "proto/grid.h"
#include "terrain/store/scene.h"

namespace foreland::server {

// What is taken to bound an error's direction. The spheroid of S, 3.3.3, is degenerate for terrain: its errors are
// purely vertical, which seen from above projects to almost nothing. On a curved frame they are not quite, so there a
// sphere is taken.
enum class ErrorBound : uint8_t { kSpheroid, kSphere };

class Hierarchy {
 public:
  explicit Hierarchy(std::shared_ptr<const terrain::Scene> scene, ErrorBound bound = ErrorBound::kSpheroid)
      : scene_(std::move(scene)),
        frame_(scene_->frame(), scene_->grid().maxX(), scene_->grid().maxY()),
        bound_(bound) {}

  const terrain::Scene& scene() const { return *scene_; }
  const proto::GridTopology& grid() const { return scene_->grid(); }
  const proto::FrameGrid& frame() const { return frame_; }
  std::span<const terrain::NodeRecord> nodes() const { return scene_->nodes(); }
  bool isPlanar() const { return scene_->frame().kind == proto::FrameKind::kPlanar; }
  bool hasVerticalErrors() const { return isPlanar() && bound_ == ErrorBound::kSpheroid; }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  proto::FrameGrid frame_;
  ErrorBound bound_;
};

}  // namespace foreland::server
