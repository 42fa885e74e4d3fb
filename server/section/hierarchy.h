// What the refiner reads: one scene's terrain and objects, whatever file they come from. Immutable; shared by all
// threads.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "proto/codec/delta_codec.h"
#include "proto/refine/metric/frustum.h"
#include "proto/refine/metric/terrain_domain.h"
#include "proto/refine/refine.h"
#include "proto/refine/surface/objects.h"
#include "terrain/store/scene.h"
#include "terrain/surface/inner_solids.h"

namespace foreland::server {

// What bounds whatever is drawn of a model, in its own frame: a box that holds it, and solids inside of it.
struct ModelHull {
  terrain::DrawnBox box;
  std::vector<terrain::ConvexSolid> solids;
};

// A ball that holds whatever is drawn of an object, at all scene times. Scene frame, metres.
struct ObjectBall {
  glm::dvec3 middle{0};
  double radius_m = 0;

  // Whether any of it may be seen from a view, of which `frustum` is.
  bool mayBeSeen(const proto::View& view, const proto::Frustum& frustum) const;
};

// The objects of a scene, with their models' nodes.
struct SceneObjects {
  proto::ObjectSet set;
  std::vector<proto::ModelNodes> nodes;           // of each model
  std::vector<std::span<const uint32_t>> texels;  // of each model's image (proto::AtlasLayout); empty without an image
  std::vector<ModelHull> hulls;                   // of each model; empty: unknown
  std::vector<ObjectBall> balls;                  // of each object; empty: unknown
  std::shared_ptr<const void> owner;              // of the memory that the spans point into

  const proto::ModelNodes& nodesOf(size_t object) const { return nodes[set.placement(object).model]; }
  std::span<const proto::SurfaceRecord> recordsOf(size_t object) const { return nodesOf(object).records; }
  bool mayBeSeen(size_t object, const proto::View& view, const proto::Frustum& frustum) const {
    return balls.empty() || balls[object].mayBeSeen(view, frustum);
  }
};

// The objects in the scene's file; an Error if they are damaged.
[[nodiscard]] Result<SceneObjects> objectsOf(const std::shared_ptr<const terrain::Scene>& scene);

class Hierarchy {
 public:
  explicit Hierarchy(std::shared_ptr<const terrain::Scene> scene,
                     proto::ErrorBound bound = proto::ErrorBound::kSpheroid, SceneObjects objects = {})
      : scene_(std::move(scene)),
        domain_(scene_->grid(), scene_->frame(), bound,
                scene_->heightRange().highest * scene_->frame().height_quantum_m),
        objects_(std::move(objects)),
        max_offset_(scene_->epochs().maxOffset()) {}

  const terrain::Scene& scene() const { return *scene_; }
  const proto::TerrainDomain& domain() const { return domain_; }
  const SceneObjects& objects() const { return objects_; }
  // How the ground moves in time.
  const terrain::EpochTable& epochs() const { return scene_->epochs(); }
  // The largest offset of any vertex at any epoch, either way; quanta.
  uint32_t maxOffset() const { return max_offset_; }
  const proto::GridTopology& grid() const { return domain_.grid; }
  const proto::FrameGrid& frame() const { return domain_.frame; }
  proto::StoredNodes nodes() const { return scene_->nodes(); }
  proto::DenseNodes table() const {
    return {grid(), {scene_->cornerHeights(), scene_->centreHeights()}, scene_->nodes()};
  }
  // The nodes as an adapter reads them.
  proto::InMemoryNodes source() const { return proto::InMemoryNodes(nodes()); }

 private:
  std::shared_ptr<const terrain::Scene> scene_;
  proto::TerrainDomain domain_;
  SceneObjects objects_;
  uint32_t max_offset_;
};

// The section of a view, from scratch (proto/refine/refine.h).
[[nodiscard]] inline bool refine(const Hierarchy& hierarchy, const proto::View& view, size_t max_nodes,
                                 proto::RefineScratch& scratch, proto::Section& section,
                                 const proto::HiddenBlocks* hidden = nullptr,
                                 proto::ReadableNodes* readable = nullptr) {
  return proto::refine(hierarchy.domain(), hierarchy.nodes(), view, max_nodes, scratch, section, hidden, readable);
}

// About how many nodes it has, and one for `inner`, from a sample.
[[nodiscard]] inline proto::SampledSize estimateSize(const Hierarchy& hierarchy, const proto::View& view,
                                                     const proto::View& inner, proto::RefineScratch& scratch,
                                                     const proto::HiddenBlocks* hidden = nullptr,
                                                     proto::ReadableNodes* readable = nullptr) {
  return proto::estimateSize(hierarchy.domain(), hierarchy.nodes(), view, inner, scratch, hidden, readable);
}

}  // namespace foreland::server
