// A small random terrain without a file: heights, saturated errors, nested spheres. If its shape has sparse levels, few
// of their pages are there. If it is a cube, the terrain is a small planet.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <vector>

#include "base/rng.h"
#include "proto/codec/delta_codec.h"
#include "proto/refine/refine.h"
#include "proto/section/epochs.h"

namespace foreland::test {

class ToyTerrain {
 public:
  ToyTerrain(const proto::GridShape& shape, uint64_t seed)
      : domain_(std::move(proto::GridTopology::create(shape)).value(), frame(shape)),
        nodes_(domain_.grid.slotCount()),
        corners_((shape.roots_x + 1) * (shape.roots_y + 1)),
        centres_(shape.roots_x * shape.roots_y) {
    Rng rng(seed);
    for (auto* base : {&corners_, &centres_})
      for (int32_t& height : *base) height = static_cast<int32_t>(rng.below(2000));
    if (shape.is_cube)  // whose other corners have the names of these
      for (uint32_t i = 1; i <= shape.roots_x; ++i)
        corners_[shape.roots_x + 1 + i] = corners_[proto::baseVertexNumber(
            domain_.grid,
            domain_.grid.nameIn(i < 6 ? i : 5, proto::NodeId::at(i << shape.root_log2, 1u << shape.root_log2)))];
    const proto::GridTopology& grid = domain_.grid;
    keepPages(rng);
    std::vector<double> errors(nodes_.size());
    for (proto::Slot slot = 0; slot < nodes_.size(); ++slot) {
      const proto::NodeId n = grid.node(slot);
      if (grid.isBase(n) || !directory_.hasPage(slot)) continue;
      const auto [a, b] = grid.endpoints(n);
      const uint64_t rough = 1 + (600u << grid.scaleLog2(n) >> grid.shape().root_log2);
      const int32_t middle = proto::middleOf(heightOf(a), heightOf(b)),
                    height = middle + static_cast<int32_t>(rng.below(2 * rough + 1) - rough);
      nodes_[slot] = proto::NodeRecord::of(height, height - middle, {}, {kRadius});
      errors[slot] = std::max(0.1 * std::abs(height - middle), sagitta(n)) * rng.uniform(1, 1.5);
    }
    for (proto::Slot slot = static_cast<proto::Slot>(nodes_.size()); slot-- > 0;) {
      const proto::NodeId n = grid.node(slot);
      if (grid.isBase(n) || !directory_.hasPage(slot)) continue;
      for (proto::NodeId child : grid.children(n)) errors[slot] = std::max(errors[slot], errors[grid.slot(child)]);
      const proto::NodeRecord& r = nodes_[slot];
      nodes_[slot] =
          proto::NodeRecord::of(r.height(), r.displacement(), proto::QuantisedError::roundUp(errors[slot]), {kRadius});
    }
    for (proto::Slot slot = 0; slot < nodes_.size(); ++slot)
      if (directory_.hasPage(slot)) stored_[directory_.placeOf(slot)] = nodes_[slot];
  }
  ToyTerrain(const ToyTerrain&) = delete;  // for the views below
  ToyTerrain& operator=(const ToyTerrain&) = delete;

  const proto::TerrainDomain& domain() const { return domain_; }
  const proto::GridTopology& grid() const { return domain_.grid; }
  // By slot, zeros where no page is; and the same as it is stored.
  const std::vector<proto::NodeRecord>& nodes() const { return nodes_; }
  proto::StoredNodes stored() const { return {stored_, directory_}; }
  proto::BaseHeights base() const { return {corners_, centres_}; }
  proto::DenseNodes table() const { return {grid(), base(), stored()}; }

  proto::Section refine(const proto::View& view) const {
    proto::RefineScratch scratch;
    proto::Section section;
    CHECK_TRUE(proto::refine(domain_, nodes_, view, nodes_.size(), scratch, section));
    return section;
  }

  // A random view from above; mostly close to the one before.
  proto::View wander(Rng& rng, proto::View view) const {
    if (rng.below(8) == 0)
      view.pose.eye = {rng.uniform(-200, 1000), rng.uniform(-200, 1000), rng.uniform(50, 3000)};
    else
      view.pose.eye += glm::dvec3(rng.uniform(-15, 15), rng.uniform(-15, 15), rng.uniform(-15, 15));
    if (grid().isCube()) return wanderOverPlanet(rng, view);
    if (rng.below(4) == 0) {
      const double yaw = rng.uniform(0, 6.28), pitch = rng.uniform(-1.5, 0);
      const glm::dvec3 ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch));
      view.pose.orientation = proto::lookAlong(ahead, {0, 0, 1});
    }
    if (rng.below(8) == 0) view.tau_px = static_cast<float>(std::exp2(rng.uniform(-3, 3)));
    if (rng.below(8) == 0) view.region_radius_m = static_cast<float>(rng.uniform(0, 40));
    return view;
  }

 private:
  static constexpr uint8_t kRadius = 8;  // four times level ground's
  static constexpr double kPlanet_m = 20'000;
  static proto::Frame frame(const proto::GridShape& shape) {
    proto::Frame f;
    if (shape.is_cube) {
      f.kind = proto::FrameKind::kGlobe;
      f.semi_major_m = kPlanet_m;
      f.flattening = 0.01;
      f.face_steps = 1u << shape.root_log2;
      return f;
    }
    f.axis_x_m = {10, 0};
    f.axis_y_m = {0, 10};
    return f;
  }
  // How far a chord of the planet lies below the middle of its arc, metres.
  double sagitta(proto::NodeId n) const {
    if (!grid().isCube()) return 0;
    const auto [a, b] = grid().endpoints(n);
    const auto at = [&](proto::NodeId v) { return domain_.frame.position(v, 0); };
    return glm::length(at(n) - 0.5 * (at(a) + at(b)));
  }
  // From far above to near the ground, mostly close to the view before; often at a pole, a corner or an edge.
  proto::View wanderOverPlanet(Rng& rng, proto::View view) const {
    if (rng.below(6) == 0 || glm::length(view.pose.eye) < 1.05 * kPlanet_m) {
      const proto::CubePoint at{static_cast<uint32_t>(rng.below(6)), rng.below(3) == 0 ? 1.0 : rng.uniform(-1, 1),
                                rng.below(3) == 0 ? -1.0 : rng.uniform(-1, 1)};
      const glm::dvec3 towards = rng.below(6) == 0 ? glm::dvec3(0.01, 0, 1) : glm::normalize(cubeVector(at));
      view.pose.eye = towards * (kPlanet_m * (1.06 + std::exp(rng.uniform(-5, 2))));
    } else {
      view.pose.eye += glm::dvec3(rng.uniform(-300, 300), rng.uniform(-300, 300), rng.uniform(-300, 300));
    }
    if (rng.below(3) == 0) {
      const glm::dvec3 aside(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      view.pose.orientation = proto::lookAlong(glm::normalize(-view.pose.eye / kPlanet_m + aside), {0, 0, 1});
    }
    if (rng.below(8) == 0) view.tau_px = static_cast<float>(std::exp2(rng.uniform(0, 4)));
    if (rng.below(8) == 0) view.region_radius_m = static_cast<float>(rng.uniform(0, 400));
    return view;
  }
  // Those of the whole levels, and those that a few nodes need.
  void keepPages(Rng& rng) {
    std::vector<proto::Slot> kept;
    if (grid().wholeLevels() < grid().maxLevel())
      for (int i = 0; i < 3; ++i) kept.push_back(rng.below(grid().slotCount()));
    blocks_ = proto::blocksOf(grid(), kept);
    directory_ = std::move(proto::PageDirectory::create(grid(), blocks_)).value();
    stored_.resize(directory_.pageCount() * proto::kPageSlots);
  }
  int32_t heightOf(proto::NodeId v) const {
    return domain_.grid.isBase(v) ? base().at(domain_.grid, v) : nodes_[domain_.grid.slot(v)].height();
  }

  proto::TerrainDomain domain_;
  std::vector<proto::NodeRecord> nodes_, stored_;
  std::vector<proto::PageBlock> blocks_;
  proto::PageDirectory directory_{domain_.grid};
  std::vector<int32_t> corners_, centres_;
};

}  // namespace foreland::test
