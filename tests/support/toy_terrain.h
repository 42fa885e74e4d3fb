// A small random terrain without a file: heights, saturated errors, nested spheres. If its shape has sparse levels, few
// of their pages are there.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "base/rng.h"
#include "proto/codec/delta_codec.h"
#include "proto/refine/refine.h"

namespace foreland::test {

class ToyTerrain {
 public:
  ToyTerrain(const proto::GridShape& shape, uint64_t seed)
      : domain_(std::move(proto::GridTopology::create(shape)).value(), frame()),
        nodes_(domain_.grid.slotCount()),
        corners_((shape.roots_x + 1) * (shape.roots_y + 1)),
        centres_(shape.roots_x * shape.roots_y) {
    Rng rng(seed);
    for (auto* base : {&corners_, &centres_})
      for (int32_t& height : *base) height = static_cast<int32_t>(rng.below(2000));
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
      errors[slot] = 0.1 * std::abs(height - middle) * rng.uniform(1, 1.5);
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
  static proto::Frame frame() {
    proto::Frame f;
    f.axis_x_m = {10, 0};
    f.axis_y_m = {0, 10};
    return f;
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
