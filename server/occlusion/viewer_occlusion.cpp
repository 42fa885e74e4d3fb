#include "server/occlusion/viewer_occlusion.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::server {

namespace {

constexpr uint32_t kReviewPeriod = 32;  // keyframes between two tries of a visible block
constexpr double kLeastSpare_m = 2;

uint64_t keyOf(const proto::BlockId& b) { return uint64_t{b.scale} << 56 | uint64_t{b.y} << 28 | b.x; }
uint32_t phaseOf(const proto::BlockId& b) { return (b.x * 5 + b.y * 3 + b.scale) % kReviewPeriod; }

}  // namespace

Result<std::shared_ptr<const SceneOcclusion>> SceneOcclusion::create(const Hierarchy& hierarchy) {
  auto occluder = Occluder::create(hierarchy);
  if (!occluder) return occluder.error();
  return std::make_shared<const SceneOcclusion>(SceneOcclusion{std::move(*occluder), BlockTops(hierarchy)});
}

void ViewerOcclusion::begin(const proto::View& view) {
  const bool is_jump =
      !view_ || glm::distance(view_->pose.eye, view.pose.eye) > 4 * (view.region_radius_m + view_->region_radius_m) ||
      view_->lens != view.lens;
  spare_m_ = std::max(kLeastSpare_m, view.region_radius_m);
  last_ray_ = test_.rayCount() + (is_jump ? options_.first_rays : options_.rays);
  view_ = view;
  frustum_.emplace(view, 0);
  ++keyframe_;
  if (keyframe_ % 64 == 0) std::erase_if(proofs_, [&](const auto& p) { return p.second.keyframe + 32 < keyframe_; });
}

uint64_t ViewerOcclusion::raysLeft() const { return last_ray_ - std::min(last_ray_, test_.rayCount()); }

bool ViewerOcclusion::meetsFrustum(const proto::BlockId& block) const {
  const proto::GridTopology& grid = hierarchy_.grid();
  const uint32_t side = proto::BlockId::kSide << block.scale;
  const auto corner = [&](uint32_t x, uint32_t y, int32_t height) {
    return hierarchy_.frame().position(proto::NodeId::at(std::min(x, grid.maxX()), std::min(y, grid.maxY())), height);
  };
  const auto range = hierarchy_.scene().heightRange();
  const glm::dvec3 low = corner(block.x * side, block.y * side, range.lowest),
                   high = corner((block.x + 1) * side, (block.y + 1) * side, range.highest),
                   left = corner(block.x * side, (block.y + 1) * side, range.lowest);
  const glm::dvec3 middle = 0.5 * (low + high);
  const double radius =
      std::max(glm::distance(middle, low), glm::distance(middle, left)) * 1.1 + view_->region_radius_m;
  const glm::dvec3 p = middle - view_->pose.eye;
  return frustum_->sideDistance(frustum_->toView(p.x, p.y, p.z)) + radius >= 0;
}

// The ball holds the region's, and no more of the surface in front may be missing than was allowed for.
bool ViewerOcclusion::holds(const Proof& proof) const {
  return glm::distance(proof.eye, view_->pose.eye) + view_->region_radius_m <= proof.radius_m &&
         view_->tau_px <= proof.tau_px;
}

// Tries balls that are larger than the region by each of the lengths.
bool ViewerOcclusion::prove(const proto::BlockId& block, std::initializer_list<double> spare_m) {
  for (double spare : spare_m) {
    ++statistics_.tests;
    const double radius = view_->region_radius_m + spare;
    const bool is_hidden = test_.isHidden(block, *view_, radius, raysLeft());
    statistics_.rays = test_.rayCount();
    if (!is_hidden) continue;
    proofs_[keyOf(block)] = {view_->pose.eye, radius, view_->tau_px, keyframe_};
    return true;
  }
  return false;
}

bool ViewerOcclusion::isHidden(const proto::BlockId& block) { return prove(block, {16 * spare_m_, 8 * spare_m_}); }

bool ViewerOcclusion::isStillHidden(const proto::BlockId& block, bool was_hidden) {
  ++statistics_.reviews;
  if (!was_hidden)
    return keyframe_ % kReviewPeriod == phaseOf(block) && meetsFrustum(block) && prove(block, {8 * spare_m_});
  const auto proof = proofs_.find(keyOf(block));
  if (proof != proofs_.end()) {
    proof->second.keyframe = keyframe_;
    if (holds(proof->second)) return true;
  }
  // Out of view it makes no difference, and need not be tried before it comes into view.
  if (!meetsFrustum(block)) return true;
  return prove(block, {16 * spare_m_, 8 * spare_m_, 4 * spare_m_, 2 * spare_m_, spare_m_, 0});
}

size_t ViewerOcclusion::bytes() const { return proofs_.size() * (sizeof(Proof) + 5 * sizeof(void*)); }

}  // namespace foreland::server
