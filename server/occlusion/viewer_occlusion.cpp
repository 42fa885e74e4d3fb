#include "server/occlusion/viewer_occlusion.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::server {

namespace {

// Of ViewerOcclusion::kAhead: the shortest look ahead that makes a visible block hidden. One that is hidden already
// stays so with any.
constexpr size_t kWorth = 3;
constexpr double kSpare_m = 1;              // of a sweep's radius, for what comes later
constexpr double kRestSpare_m = 25;         // the same for an eye at rest, which may fly off any time
constexpr double kStray = 0.06;             // the same for each keyframe ahead, of a prediction's error
constexpr uint32_t kSettlingKeyframes = 4;  // after a jump, until the motion is known
constexpr uint32_t kReviewPeriod = 32;      // keyframes between two tries of a visible block beside hidden ones
constexpr uint32_t kFarReviewPeriod = 256;  // of others
constexpr uint32_t kUpgradePeriod = 4;      // renewals of a proof, about, between two tries for a longer one
constexpr size_t kKeptKeyframes = 128;      // of sweeps; more than the longest look ahead
constexpr uint32_t kUnusedKeyframes = 32;   // until a tile's proofs are dropped

// Spreads what is done now and then over the keyframes.
uint32_t phaseOf(const proto::BlockId& b) { return b.x * 5 + b.y * 3 + b.scale; }

}  // namespace

Result<std::shared_ptr<const SceneOcclusion>> SceneOcclusion::create(const Hierarchy& hierarchy) {
  auto occluder = Occluder::create(hierarchy);
  if (!occluder) return occluder.error();
  return std::make_shared<const SceneOcclusion>(SceneOcclusion{std::move(*occluder), BlockTops(hierarchy)});
}

ViewerOcclusion::Sweeps ViewerOcclusion::sweepsAhead(const ExpectedMotion& motion, Time begin, Time end,
                                                     Duration interval, double error_m) {
  Sweeps sweeps;
  for (size_t i = kAhead.size(); i-- > 0;) {
    sweeps[i] = sweepOf(motion, begin, end + interval * kAhead[i]);
    sweeps[i].radius_m += error_m;
    // What comes later must find room in it: its own radius, and the stray of a prediction so far ahead.
    const double spare_m = glm::length(sweeps.back().way) < kSpare_m ? kRestSpare_m : kSpare_m;
    if (kAhead[i] > 0)
      sweeps[i].radius_m += sweeps.back().radius_m + spare_m + kStray * kAhead[i] * kAhead[i] * error_m;
  }
  return sweeps;
}

void ViewerOcclusion::begin(const proto::View& view) {
  const bool is_jump =
      !view_ || glm::distance(view_->pose.eye, view.pose.eye) > 4 * (view.region_radius_m + view_->region_radius_m) ||
      view_->lens != view.lens;
  if (is_jump) settled_at_ = keyframe_ + 1 + kSettlingKeyframes;
  last_ray_ = test_.rayCount() + (keyframe_ < settled_at_ ? options_.first_rays : options_.rays);
  view_ = view;
  frustum_.emplace(view, 0);
  ++keyframe_;
  if (!expected_) expected_.emplace().fill({view.pose.eye, {}, view.region_radius_m});
  if (sweeps_.size() >= kKeptKeyframes * kAhead.size()) {
    sweeps_.erase(sweeps_.begin(), sweeps_.begin() + kAhead.size());
    first_sweep_ += kAhead.size();
  }
  // It holds the eyes, and no more of the surface in front may be missing than was allowed for.
  for (Sweep& sweep : sweeps_) sweep.holds = view.tau_px <= sweep.tau_px && sweep.eyes.contains(expected_->back());
  for (const EyeSweep& eyes : *expected_) sweeps_.push_back({eyes, view.tau_px, true, keyframe_ <= settled_at_});
  expected_.reset();
  last_proofs_ = nullptr;
  if (keyframe_ % kUnusedKeyframes == 0)
    std::erase_if(proofs_, [&](const auto& p) { return p.second.keyframe + kUnusedKeyframes < keyframe_; });
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

uint32_t& ViewerOcclusion::proofOf(const proto::BlockId& block) {
  constexpr uint32_t kLog2 = proto::HiddenBlocks::kTileLog2, kMask = (1u << kLog2) - 1;
  const uint64_t tile = uint64_t{block.scale} << 56 | uint64_t{block.y >> kLog2} << 28 | block.x >> kLog2;
  if (!last_proofs_ || tile != last_tile_) {
    last_tile_ = tile;
    last_proofs_ = &proofs_[tile];
    last_proofs_->keyframe = keyframe_;
  }
  return last_proofs_->sweeps[(block.y & kMask) << kLog2 | (block.x & kMask)];
}

bool ViewerOcclusion::hasHiddenInTile(const proto::BlockId& block) {
  proofOf(block);
  return last_proofs_->any;
}

// Tries one of the keyframe's sweeps after the other, from the first to before the last.
bool ViewerOcclusion::prove(const proto::BlockId& block, size_t first, size_t last) {
  for (size_t i = first; i < last; ++i) {
    ++statistics_.tests;
    const size_t sweep = sweeps_.size() - kAhead.size() + i;
    const bool is_hidden = test_.isHidden(block, *view_, sweeps_[sweep].eyes, raysLeft());
    statistics_.rays = test_.rayCount();
    if (!is_hidden) continue;
    uint32_t& proof = proofOf(block);
    last_proofs_->any = true;
    proof = first_sweep_ + static_cast<uint32_t>(sweep);
    return true;
  }
  return false;
}

// Whether a proof that holds is to be renewed: if it was found together with most others, at some time in the second
// half of its life, lest they end together.
bool ViewerOcclusion::isAging(const proto::BlockId& block, uint32_t proof) const {
  if (!sweeps_[proof - first_sweep_].is_after_jump) return false;
  const auto half = static_cast<uint32_t>(kAhead[proof % kAhead.size()]) / 2;
  const auto age = static_cast<uint32_t>((first_sweep_ + sweeps_.size() - 1 - proof) / kAhead.size());
  return half > 1 && age >= half && (keyframe_ + phaseOf(block)) % half == 0;
}

bool ViewerOcclusion::isHidden(const proto::BlockId& block) { return prove(block, kWorth, kWorth + 1); }

bool ViewerOcclusion::isStillHidden(const proto::BlockId& block, bool was_hidden) {
  ++statistics_.reviews;
  if (!was_hidden) {
    const uint32_t period = hasHiddenInTile(block) ? kReviewPeriod : kFarReviewPeriod;
    return (keyframe_ + phaseOf(block)) % period == 0 && meetsFrustum(block) && prove(block, kWorth, kWorth + 1);
  }
  const uint32_t proof = proofOf(block);
  const bool holds = proof >= first_sweep_ && sweeps_[proof - first_sweep_].holds;
  if (holds && !isAging(block, proof)) return true;
  // Out of view it makes no difference, and need not be tried before it comes into view.
  if (!meetsFrustum(block)) return true;
  // The sweep that was long enough last time first, now and then the next longer one.
  size_t first = proof % kAhead.size();
  if (first > 0 && keyframe_ % kUpgradePeriod == phaseOf(block) % kUpgradePeriod) --first;
  return prove(block, first, holds ? kWorth + 1 : kAhead.size()) || holds;
}

size_t ViewerOcclusion::bytes() const {
  return proofs_.size() * (sizeof(Proofs) + 5 * sizeof(void*)) + sweeps_.size() * sizeof(Sweep);
}

}  // namespace foreland::server
