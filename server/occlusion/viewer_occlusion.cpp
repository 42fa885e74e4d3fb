#include "server/occlusion/viewer_occlusion.h"

#include <algorithm>
#include <bit>
#include <glm/geometric.hpp>
#include <limits>

namespace foreland::server {

namespace {

using proto::BlockId;
using proto::HiddenBlocks;

constexpr double kBin_px = 3;              // width of a horizon's bins
constexpr double kMargin_px = 1;           // by which a block must be hidden to turn so
constexpr int64_t kWorth = 11;             // intervals after a keyframe's for which it must be hidden to turn so
constexpr int64_t kSpread = 8;             // intervals over which proofs that end together are renewed
constexpr uint64_t kUpgradePeriod = 4;     // renewals, about, between two tries of a longer span
constexpr int64_t kRayRest = 48;           // intervals more until rays try a visible block again
constexpr uint8_t kMaxFailures = 2;        // in a row that prolong the rest of a visible block, to twice as much each
constexpr double kSpareTau = 1.25;         // a tolerance that rises is taken to be larger by this
constexpr uint32_t kUnusedKeyframes = 32;  // until proofs are dropped
constexpr uint32_t kTileMask = (1u << HiddenBlocks::kTileLog2) - 1;

// Spreads what is done now and then over the keyframes.
uint32_t phaseOf(const BlockId& b) {
  return (b.x >> HiddenBlocks::kTileLog2) * 5 + (b.y >> HiddenBlocks::kTileLog2) * 3 + b.scale;
}

// Spreads what is done once over as many keyframes as are asked for.
uint32_t turnOf(const BlockId& b, uint32_t keyframes) {
  uint64_t hash = (uint64_t{b.x} << 32 | b.y) * 0x9e3779b97f4a7c15 + b.scale;
  hash = (hash ^ hash >> 29) * 0xbf58476d1ce4e5b9;
  return static_cast<uint32_t>(hash >> 40) % keyframes;
}

uint32_t bitOf(const BlockId& b) { return (b.y & kTileMask) << HiddenBlocks::kTileLog2 | (b.x & kTileMask); }

PredictedEyePath restingIn(const proto::View& view, uint32_t keyframe) {
  constexpr int64_t kIntervals = EyeIntervals::kAhead;
  return {{1}, keyframe, keyframe, std::vector<EyeCapsule>(kIntervals, {view.pose.eye, {}, view.region_radius_m}), 0};
}

}  // namespace

Duration OcclusionStatistics::usualCost() const {
  constexpr double kTest_us = 0.475, kSegment_us = 57, kRay_us = 1;
  return Duration{static_cast<int64_t>(kTest_us * static_cast<double>(tests) +
                                       kSegment_us * static_cast<double>(segments) +
                                       kRay_us * static_cast<double>(rays))};
}

ViewerOcclusion::ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene, const Options& options)
    : hierarchy_(hierarchy),
      scene_(scene),
      test_(hierarchy, scene),
      options_(options),
      spans_(intervals_, scene.grid.get()),
      proofs_(hierarchy.grid()) {}

void ViewerOcclusion::begin(const proto::View& view) {
  const bool has_new_lens = !view_ || view_->lens != view.lens;
  ++keyframe_;
  hidden_in_view_ = 0;
  cost_before_ = statistics_.usualCost();
  view_ = view;
  frustum_.emplace(view, 0);
  last_ray_ = statistics_.rays + options_.rays;
  expectNumbered(eye_path_ ? std::move(*eye_path_) : restingIn(view, keyframe_));
  eye_path_.reset();
  if (has_new_lens) spans_.clear();
  spans_.revise(keyframe_);
  if (spans_.bytes() > options_.horizon_bytes / 2) spans_.dropHorizons();
  horizon_bytes_ = spans_.bytes();
  if (has_new_lens || view.tau_px > tau_px_) {
    tau_px_ = (tau_px_ > 0 ? kSpareTau : 1) * view.tau_px;
    spans_.invalidate(keyframe_);
  }
  if (keyframe_ % kUnusedKeyframes == 0) proofs_.forgetUnused(keyframe_ - kUnusedKeyframes);
}

// Proofs keep numbers of intervals in 32 bits, but a client's clock may count from anywhere: Unix time in microseconds
// gives 10^10. So numbers count from an origin, a multiple of every span's length.
void ViewerOcclusion::expectNumbered(PredictedEyePath eye_path) {
  constexpr int64_t kSpan = int64_t{1} << 30, kUnit = int64_t{1} << 16;
  if (eye_path.first < origin_ || eye_path.first - origin_ >= kSpan) {
    origin_ = eye_path.first & -kUnit;
    proofs_ = BlockProofs(hierarchy_.grid());
    spans_.clear();
    spans_.invalidate(keyframe_);
  }
  eye_path.first -= origin_;
  eye_path.last -= origin_;
  intervals_.expect(std::move(eye_path));
}

bool ViewerOcclusion::hides(PathSpan& span, const BlockId& block, Towards towards) {
  ++statistics_.tests;
  const Tolerance tolerance{view_->lens, tau_px_ + (towards == Towards::kHidden ? kMargin_px : 0)};
  if (!scene_.grid) {
    const bool is_hidden =
        test_.isHidden(block, tolerance, span.eyes, last_ray_ - std::min(last_ray_, test_.rayCount()));
    statistics_.rays = test_.rayCount();
    return is_hidden;
  }
  if (horizon_bytes_ >= options_.horizon_bytes) return false;
  Horizon& horizon = spans_.horizonOf(span, kBin_px / view_->lens.focalPx());
  const uint64_t built = horizon.segmentsBuilt();
  const size_t bytes = horizon.bytes();
  const bool is_hidden = test_.isBehind(block, tolerance, horizon);
  statistics_.segments += horizon.segmentsBuilt() - built;
  horizon_bytes_ += horizon.bytes() - bytes;
  return is_hidden;
}

// The last interval up to which the block is proved to be hidden from `first` on; before `first` if it is not. Goes on
// to `last` at most, and to the end of the span of that.
int64_t ViewerOcclusion::hiddenUntil(const BlockId& block, BlockProof& proof, int64_t first, int64_t last,
                                     Towards towards) {
  while (first <= last) {
    size_t length = proof.length;
    if (length > 0 && (phaseOf(block) + static_cast<uint64_t>(first)) % kUpgradePeriod == 0) --length;
    const PathSpan* found = nullptr;
    for (; length < PathSpans::kLengths && !found; ++length)
      if (PathSpan* const span = spans_.at(length, first); span && hides(*span, block, towards)) {
        found = span;
        proof.length = static_cast<uint8_t>(length);
        proof.lengths |= static_cast<uint8_t>(1u << length);
      }
    if (!found) break;
    first = found->end;
  }
  return first - 1;
}

// The last interval is tried first. Where a span shows the block, it need not be tried again before that is past;
// and less and less often as long as it stays visible.
bool ViewerOcclusion::turnsHidden(const BlockId& block, TileProofs& tile) {
  BlockProof& proof = tile.blocks[bitOf(block)];
  int32_t& next = tile.next[bitOf(block)];
  const int64_t last = std::max(spans_.lastCoveredUpTo(intervals_.last() + kWorth), intervals_.last()),
                shown = intervals_.last() - intervals_.first();
  proof.keyframe = keyframe_;
  proof.lengths = 0;
  PathSpan* const far = scene_.grid ? spans_.at(PathSpans::kLengths - 1, last) : nullptr;
  const bool may_be = !far || hides(*far, block, Towards::kHidden);
  if (may_be) proof.until = static_cast<int32_t>(hiddenUntil(block, proof, intervals_.first(), last, Towards::kHidden));
  if (may_be && proof.until >= last) {
    next = proof.until + 1;
    proof.failures = 0;
    return true;
  }
  const int64_t shortest_end = spans_.shortestEnd(int64_t{proof.until} + 1), length = spans_.shortest(),
                past = may_be ? shortest_end + shown : far->end - (last - intervals_.last()),
                rest = length * ((1 << proof.failures) - 1) + (scene_.grid ? 0 : kRayRest);
  next = static_cast<int32_t>(std::max(past, intervals_.last() + 1) + phaseOf(block) % kSpread + rest);
  proof.failures = std::min<uint8_t>(proof.failures + 1, kMaxFailures);
  return false;
}

bool ViewerOcclusion::staysHidden(const BlockId& block, TileProofs& tile) {
  BlockProof& proof = tile.blocks[bitOf(block)];
  int32_t& next = tile.next[bitOf(block)];
  const int64_t first = intervals_.first(), last = intervals_.last(),
                known = std::min<int64_t>(proof.until, spans_.firstChangedAfter(proof.keyframe, proof.lengths) - 1);
  if (known >= last && next > last) return true;
  if (known < first) proof.lengths = 0;
  // Where no span has hidden it none will, unless one is made anew.
  const bool is_known_open = proof.until < last && last <= proof.open_until && proof.revision == spans_.revision();
  const int64_t until = is_known_open ? known
                                      : hiddenUntil(block, proof, std::max(known + 1, first), std::max(last, known + 1),
                                                    Towards::kVisible);
  proof.keyframe = keyframe_;
  proof.until = static_cast<int32_t>(until);
  if (until < last) {
    // A prediction's error is less for the keyframe itself than for all of a span.
    proof.open_until = static_cast<int32_t>(spans_.shortestEnd(std::max(until + 1, first)) - 1);
    proof.revision = spans_.revision();
    next = static_cast<int32_t>(last);
    return intervals_.isPredicted() && hides(spans_.now(), block, Towards::kVisible);
  }
  const int64_t spare = until - last;
  next = static_cast<int32_t>(until + 1 - (until > known && spare > 0 ? phaseOf(block) % std::min(spare, kSpread) : 0));
  return true;
}

void ViewerOcclusion::setEffort(Effort effort) {
  if (effort == effort_) return;
  effort_ = effort;
  fading_since_ = keyframe_ + 1;
}

void ViewerOcclusion::forget() {
  proofs_ = BlockProofs(hierarchy_.grid());
  spans_.clear();
  spans_.dropHorizons();
  spans_.invalidate(keyframe_);
  hidden_in_view_ = 0;
}

bool ViewerOcclusion::isHidden(const BlockId& block) {
  if (effort_ == Effort::kFading) return false;
  const BlockProofs::Tile tile = proofs_.of(block, keyframe_);
  if (statistics_.usualCost() - cost_before_ > first_tests_limit_) {
    tile.proofs.next[bitOf(block)] = static_cast<int32_t>(intervals_.last() + 1 + phaseOf(block) % kSpread);
    tile.due.first = std::min(tile.due.first, tile.proofs.next[bitOf(block)]);
    return false;
  }
  const bool is_hidden = turnsHidden(block, tile.proofs);
  tile.due.first = std::min(tile.due.first, tile.proofs.next[bitOf(block)]);
  hidden_in_view_ += is_hidden ? 1 : 0;
  return is_hidden;
}

// Whether a block is hidden from now on.
bool ViewerOcclusion::review(const BlockId& block, TileProofs& tile, bool was_hidden) {
  if (!was_hidden) return turnsHidden(block, tile);
  if (staysHidden(block, tile)) return true;
  tile.next[bitOf(block)] = static_cast<int32_t>(intervals_.last() + kWorth);
  return false;
}

bool ViewerOcclusion::hasFaded(const BlockId& block) const {
  return keyframe_ - fading_since_ >= turnOf(block, kFadeKeyframes);
}

// The hidden blocks of a tile that turn visible.
uint32_t ViewerOcclusion::fade(const BlockId& lowest, uint32_t hidden) {
  const InView tile_in_view =
      inView(lowest.scale + 3u, lowest.x >> HiddenBlocks::kTileLog2, lowest.y >> HiddenBlocks::kTileLog2);
  if (hidden == 0 || tile_in_view == InView::kNot) return 0;
  const auto [due, proofs] = proofs_.of(lowest, keyframe_);
  uint32_t changed = 0;
  for (uint32_t left = hidden; left != 0; left &= left - 1) {
    const auto bit = static_cast<uint32_t>(std::countr_zero(left));
    const BlockId block{lowest.scale, lowest.x + (bit & kTileMask), lowest.y + (bit >> HiddenBlocks::kTileLog2)};
    if (tile_in_view == InView::kPartly && inView(block.scale + 1u, block.x, block.y) == InView::kNot) {
      proofs.next[bit] = std::min(proofs.next[bit], static_cast<int32_t>(intervals_.last()));
      continue;
    }
    const bool stays = !hasFaded(block) && staysHidden(block, proofs);
    if (!stays) proofs.next[bit] = static_cast<int32_t>(intervals_.last());
    changed |= stays ? 0 : 1u << bit;
    hidden_in_view_ += stays ? 1 : 0;
  }
  due = {std::numeric_limits<int32_t>::min(), spans_.revision()};  // all of it is looked at when the fading has ended
  return changed;
}

// Out of view it makes no difference whether a block is hidden, and need not be tried before it comes into view.
uint32_t ViewerOcclusion::changes(const BlockId& lowest, uint32_t known, uint32_t hidden) {
  if (effort_ == Effort::kFading) return fade(lowest, hidden);
  hidden_in_view_ += static_cast<uint64_t>(std::popcount(hidden));
  const auto [due, proofs] = proofs_.of(lowest, keyframe_);
  const auto last = static_cast<int32_t>(intervals_.last());
  const bool is_revised = due.revision != spans_.revision();
  if (due.first > last && !is_revised) return 0;
  // A tile is a square of a scale whose blocks are eight times as large.
  const InView tile_in_view =
      inView(lowest.scale + 3u, lowest.x >> HiddenBlocks::kTileLog2, lowest.y >> HiddenBlocks::kTileLog2);
  if (tile_in_view == InView::kNot) return 0;
  uint32_t changed = 0;
  int32_t first = std::numeric_limits<int32_t>::max();
  for (uint32_t left = known; left != 0; left &= left - 1) {
    const auto bit = static_cast<uint32_t>(std::countr_zero(left));
    const bool was_hidden = (hidden >> bit & 1) != 0;
    const BlockId block{lowest.scale, lowest.x + (bit & kTileMask), lowest.y + (bit >> HiddenBlocks::kTileLog2)};
    int32_t& next = proofs.next[bit];
    if (next <= last || (was_hidden && is_revised)) {
      if (tile_in_view == InView::kPartly && inView(block.scale + 1u, block.x, block.y) == InView::kNot)
        next = std::min(next, last);
      else if (review(block, proofs, was_hidden) != was_hidden)
        changed |= 1u << bit;
    }
    first = std::min(first, next);
  }
  due = {first, spans_.revision()};
  return changed;
}

// Of a square of a scale (block_tops.h).
ViewerOcclusion::InView ViewerOcclusion::inView(uint32_t scale, uint32_t i, uint32_t j) const {
  const proto::GridTopology& grid = hierarchy_.grid();
  const auto range = hierarchy_.scene().heightRange();
  int32_t bottom = range.lowest, top = range.highest;
  if (scene_.tops.has(scale, i, j)) {
    bottom = scene_.tops.square(scale, i, j).bottom;
    top = scene_.tops.square(scale, i, j).top;
  }
  const auto corner = [&](uint32_t x, uint32_t y, int32_t height) {
    const uint32_t side = 2u << scale;
    return hierarchy_.frame().position(
        proto::NodeId::at(std::min(x * side, grid.maxX()), std::min(y * side, grid.maxY())), height);
  };
  const glm::dvec3 low = corner(i, j, bottom), high = corner(i + 1, j + 1, top), left = corner(i, j + 1, bottom);
  const glm::dvec3 middle = 0.5 * (low + high);
  const double radius =
      std::max(glm::distance(middle, low), glm::distance(middle, left)) * 1.1 + view_->region_radius_m;
  const glm::dvec3 p = middle - view_->pose.eye;
  const double inside = frustum_->sideDistance(frustum_->toView(p.x, p.y, p.z));
  return inside + radius < 0 ? InView::kNot : inside < radius ? InView::kPartly : InView::kWholly;
}

size_t ViewerOcclusion::bytes() const { return sizeof(*this) + proofs_.bytes() + spans_.bytes(); }

}  // namespace foreland::server
