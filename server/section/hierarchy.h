// What the refiner reads: one scene's terrain, without the file it comes from. Immutable; shared by all threads.
#pragma once

#include <memory>
#include <span>

#include "proto/delta_codec.h"
#include "proto/refine/refine.h"
#include "proto/refine/terrain_domain.h"
#include "terrain/store/scene.h"

namespace foreland::server {

class Hierarchy {
 public:
  explicit Hierarchy(std::shared_ptr<const terrain::Scene> scene,
                     proto::ErrorBound bound = proto::ErrorBound::kSpheroid)
      : scene_(std::move(scene)), domain_(scene_->grid(), scene_->frame(), bound) {}

  const terrain::Scene& scene() const { return *scene_; }
  const proto::TerrainDomain& domain() const { return domain_; }
  const proto::GridTopology& grid() const { return domain_.grid; }
  const proto::FrameGrid& frame() const { return domain_.frame; }
  std::span<const proto::NodeRecord> nodes() const { return scene_->nodes(); }
  proto::DenseNodes table() const {
    return {grid(), {scene_->cornerHeights(), scene_->centreHeights()}, scene_->nodes()};
  }
  // As an adapter takes them.
  proto::PlainNodes source() const { return proto::PlainNodes(nodes()); }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  proto::TerrainDomain domain_;
};

// The section of a view, from scratch (proto/refine/refine.h).
[[nodiscard]] inline bool refine(const Hierarchy& hierarchy, const proto::View& view, size_t max_nodes,
                                 proto::RefineScratch& scratch, proto::Section& section) {
  return proto::refine(hierarchy.domain(), hierarchy.nodes(), view, max_nodes, scratch, section);
}

}  // namespace foreland::server
