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
constexpr int64_t kRayRest = 48;           // intervals more until rays try a visible block again
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
  constexpr double kTest_us = 0.475, kSegment_us = 57, kRay_us = 1, kQuery_us = 0.5;
  return Duration{static_cast<int64_t>(kTest_us * static_cast<double>(tests) +
                                       kSegment_us * static_cast<double>(segments) +
                                       kRay_us * static_cast<double>(rays) + kQuery_us * static_cast<double>(queries))};
}

ViewerOcclusion::ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene, const Options& options)
    : hierarchy_(hierarchy),
      scene_(scene),
      test_(hierarchy, scene),
      options_(options),
      grid_(scene.grid),
      spans_(intervals_, scene.grid.get(), PathSpans::kLasting),
      object_spans_(intervals_, nullptr, PathSpans::kTight) {
  if (scene.objects) objects_.emplace(hierarchy.objects(), *scene.objects);
}

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
  if (has_new_lens) clearSpans();
  if (scene_.globe) chooseGrid();
  spans_.revise(keyframe_);
  if (objects_) object_spans_.revise(keyframe_);
  if (spans_.bytes() > options_.horizon_bytes / 2) spans_.dropHorizons();
  horizon_bytes_ = spans_.bytes();
  if (has_new_lens || view.tau_px > tau_px_) {
    tau_px_ = (tau_px_ > 0 ? kSpareTau : 1) * view.tau_px;
    invalidateSpans();
    if (scene_.globe) spans_.dropHorizons();  // whose bins are by the tolerance
  }
  if (keyframe_ % kUnusedKeyframes == 0) proofs_.forgetUnused(keyframe_ - kUnusedKeyframes);
  if (objects_) beginObjects();
}

void ViewerOcclusion::chooseGrid() {
  auto grid = scene_.globe->grids.about(view_->pose.eye, grid_);
  if (grid == grid_) return;
  spans_.lookOver(grid.get());
  grid_ = std::move(grid);
}

// Over globes bins must be so wide that the grid's heights have room for ground that is drawn elsewhere.
double ViewerOcclusion::binTangent() const {
  const double bin_px = grid_->isOverGlobe() ? std::max(kBin_px, Horizon::kBinOfTolerance * tau_px_) : kBin_px;
  return bin_px / view_->lens.focalPx();
}

// Proofs keep numbers of intervals in 32 bits, but a client's clock may count from anywhere: Unix time in microseconds
// gives 10^10. So numbers count from an origin, a multiple of every span's length.
void ViewerOcclusion::expectNumbered(PredictedEyePath eye_path) {
  constexpr int64_t kSpan = int64_t{1} << 30, kUnit = int64_t{1} << 16;
  if (eye_path.first < origin_ || eye_path.first - origin_ >= kSpan) {
    origin_ = eye_path.first & -kUnit;
    proofs_ = BlockProofs();
    if (objects_) objects_->forget();
    clearSpans();
    invalidateSpans();
  }
  eye_path.first -= origin_;
  eye_path.last -= origin_;
  intervals_.expect(std::move(eye_path));
}

void ViewerOcclusion::clearSpans() {
  spans_.clear();
  object_spans_.clear();
}

void ViewerOcclusion::invalidateSpans() {
  spans_.invalidate(keyframe_);
  object_spans_.invalidate(keyframe_);
}

Tolerance ViewerOcclusion::toleranceFor(Towards towards) const {
  return {view_->lens, tau_px_ + (towards == Towards::kHidden ? kMargin_px : 0)};
}

// Null if there is no grid, or no memory for one.
Horizon* ViewerOcclusion::horizonOf(PathSpan& span) {
  if (!grid_ || horizon_bytes_ >= options_.horizon_bytes) return nullptr;
  return &spans_.horizonOf(span, binTangent());
}

// Counts what a test builds.
template <class Test>
bool ViewerOcclusion::testBehind(Horizon& horizon, const Test& test) {
  const uint64_t built = horizon.segmentsBuilt();
  const size_t bytes = horizon.bytes();
  const bool is_hidden = test();
  statistics_.segments += horizon.segmentsBuilt() - built;
  horizon_bytes_ += horizon.bytes() - bytes;
  return is_hidden;
}

bool ViewerOcclusion::hides(PathSpan& span, const BlockId& block, Towards towards) {
  ++statistics_.tests;
  const Tolerance tolerance = toleranceFor(towards);
  bool is_hidden = false;
  if (isByRays()) {
    is_hidden = test_.isHidden(block, tolerance, span.eyes, last_ray_ - std::min(last_ray_, test_.rayCount()));
    statistics_.rays = test_.rayCount();
  } else if (Horizon* const horizon = horizonOf(span)) {
    is_hidden = testBehind(*horizon, [&] { return test_.isBehind(block, tolerance, *horizon); });
  }
  return is_hidden || isBehindObject(block, span.eyes);
}

// As one square, a scale coarser, or else as the squares of its own.
bool ViewerOcclusion::isBehindObject(const BlockId& block, const EyeCapsule& eyes) {
  if (!scene_.objects || scene_.objects->solidCount() == 0) return false;
  const uint32_t i = 2 * block.x, j = 2 * block.y;
  if (scene_.tops.has(block.scale + 1u, block.x, block.y) && isBehindObject(block.scale + 1u, block.x, block.y, eyes))
    return true;
  if (!scene_.tops.has(block.scale, i, j)) return false;
  for (const auto& [x, y] : {std::pair{i, j}, {i + 1, j}, {i, j + 1}, {i + 1, j + 1}})
    if (scene_.tops.has(block.scale, x, y) && !isBehindObject(block.scale, x, y, eyes)) return false;
  return true;
}

// What is larger than buildings is not hidden by one, and in geographic frames is no prism.
bool ViewerOcclusion::isBehindObject(uint32_t scale, uint32_t i, uint32_t j, const EyeCapsule& eyes) {
  constexpr double kMaxDiagonal_m = 150, kBulge_m = 1e-3;
  const auto corners = test_.cornersOf(scale, i, j);
  if (glm::distance(corners[0], corners[3]) > kMaxDiagonal_m) return false;
  return hideFrom(*scene_.objects, eyes, corners, kBulge_m, solid_hint_, statistics_.queries);
}

// By a horizon of the blocks' spans that is for all of the eyes, and more.
bool ViewerOcclusion::isBehindRidge(const PathSpan& span, std::span<const glm::dvec3> points, Towards towards) {
  ++statistics_.tests;
  PathSpan* wider = spans_.at(PathSpans::kLengths - 1, std::max(span.begin, intervals_.first()));
  if (!wider || !wider->eyes.contains(span.eyes)) wider = &spans_.now();
  if (!wider->eyes.contains(span.eyes)) return false;
  Horizon* const horizon = horizonOf(*wider);
  return horizon && testBehind(*horizon, [&] { return test_.isBehind(points, toleranceFor(towards), *horizon); });
}

// Ridges first, for that costs less.
void ViewerOcclusion::beginObjects() {
  constexpr int64_t kWorthOfObject = 1;
  const SpanProver::Law law{.worth = kWorthOfObject};
  ViewerObjects::Keyframe keyframe{*view_,     *frustum_, SpanProver(intervals_, object_spans_, law, keyframe_),
                                   intervals_, {},        {}};
  if (!isByRays())
    keyframe.behind_ridge = [this](const PathSpan& span, std::span<const glm::dvec3> points, Towards towards) {
      return isBehindRidge(span, points, towards);
    };
  if (effort_ == Effort::kFading)
    keyframe.has_faded = [this](size_t object) { return hasFaded({0, static_cast<uint32_t>(object), 0}); };
  objects_->begin(std::move(keyframe));
}

bool ViewerOcclusion::isObjectHidden(size_t object, size_t nodes) {
  if (!objects_) return false;
  const uint64_t before = objects_->queries();
  const bool is_hidden = objects_->isHidden(object, nodes);
  statistics_.queries += objects_->queries() - before;
  return is_hidden;
}

SpanProver ViewerOcclusion::prover() {
  const SpanProver::Law law{.worth = kWorth, .rest = isByRays() ? kRayRest : 0, .tries_last = !isByRays()};
  return SpanProver(intervals_, spans_, law, keyframe_);
}

bool ViewerOcclusion::turnsHidden(const BlockId& block, TileProofs& tile) {
  const uint32_t bit = bitOf(block);
  return prover().turnsHidden(tile.blocks[bit], tile.next[bit], phaseOf(block),
                              [&](PathSpan& span, Towards towards) { return hides(span, block, towards); });
}

bool ViewerOcclusion::staysHidden(const BlockId& block, TileProofs& tile) {
  const uint32_t bit = bitOf(block);
  return prover().staysHidden(tile.blocks[bit], tile.next[bit], phaseOf(block),
                              [&](PathSpan& span, Towards towards) { return hides(span, block, towards); });
}

void ViewerOcclusion::setEffort(Effort effort) {
  if (effort == effort_) return;
  effort_ = effort;
  fading_since_ = keyframe_ + 1;
}

void ViewerOcclusion::forget() {
  proofs_ = BlockProofs();
  if (objects_) objects_->forget();
  clearSpans();
  spans_.dropHorizons();
  if (scene_.globe) {
    spans_.lookOver(nullptr);
    grid_.reset();
  }
  invalidateSpans();
  hidden_in_view_ = 0;
}

bool ViewerOcclusion::isHidden(const BlockId& block) {
  if (effort_ == Effort::kFading) return false;
  const BlockProofs::Tile tile = proofs_.of(block, keyframe_);
  if (statistics_.usualCost() - cost_before_ > first_tests_limit_) {
    tile.proofs.next[bitOf(block)] = static_cast<int32_t>(intervals_.last() + 1 + phaseOf(block) % SpanProver::kSpread);
    tile.due.first = std::min(tile.due.first, tile.proofs.next[bitOf(block)]);
    return false;
  }
  const bool is_hidden = turnsHidden(block, tile.proofs);
  tile.due.first = std::min(tile.due.first, tile.proofs.next[bitOf(block)]);
  hidden_in_view_ += is_hidden ? 1 : 0;
  return is_hidden;
}

// Whether a block is hidden from now on. What has faded may be tried again at once when the fading has ended.
bool ViewerOcclusion::review(const BlockId& block, TileProofs& tile, bool was_hidden) {
  if (!was_hidden) return turnsHidden(block, tile);
  const bool is_fading = effort_ == Effort::kFading;
  if (!(is_fading && hasFaded(block)) && staysHidden(block, tile)) return true;
  tile.next[bitOf(block)] = static_cast<int32_t>(intervals_.last() + (is_fading ? 0 : kWorth));
  return false;
}

bool ViewerOcclusion::hasFaded(const BlockId& block) const {
  return keyframe_ - fading_since_ >= turnOf(block, kFadeKeyframes);
}

// Out of view it makes no difference whether a block is hidden, and need not be tried before it comes into view. While
// they fade all hidden blocks are reviewed, and no other ones; and all of the tile when the fading has ended.
uint32_t ViewerOcclusion::changes(const BlockId& lowest, uint32_t known, uint32_t hidden) {
  const bool is_fading = effort_ == Effort::kFading;
  if (is_fading && hidden == 0) return 0;
  hidden_in_view_ += is_fading ? 0 : static_cast<uint64_t>(std::popcount(hidden));
  const auto [due, proofs] = proofs_.of(lowest, keyframe_);
  const auto last = static_cast<int32_t>(intervals_.last());
  const bool is_revised = due.revision != spans_.revision();
  if (due.first > last && !is_revised && !is_fading) return 0;
  // A tile is a square of a scale whose blocks are eight times as large.
  const InView tile_in_view =
      inView(lowest.scale + 3u, lowest.x >> HiddenBlocks::kTileLog2, lowest.y >> HiddenBlocks::kTileLog2);
  if (tile_in_view == InView::kNot) return 0;
  uint32_t changed = 0;
  int32_t first = is_fading ? std::numeric_limits<int32_t>::min() : std::numeric_limits<int32_t>::max();
  for (uint32_t left = is_fading ? hidden : known; left != 0; left &= left - 1) {
    const auto bit = static_cast<uint32_t>(std::countr_zero(left));
    const bool was_hidden = (hidden >> bit & 1) != 0;
    const BlockId block{lowest.scale, lowest.x + (bit & kTileMask), lowest.y + (bit >> HiddenBlocks::kTileLog2)};
    int32_t& next = proofs.next[bit];
    if (next <= last || (was_hidden && (is_revised || is_fading))) {
      if (tile_in_view == InView::kPartly && inView(block.scale + 1u, block.x, block.y) == InView::kNot) {
        next = std::min(next, last);
      } else {
        const bool is_hidden = review(block, proofs, was_hidden);
        changed |= is_hidden != was_hidden ? 1u << bit : 0;
        hidden_in_view_ += is_fading && is_hidden ? 1 : 0;
      }
    }
    first = std::min(first, next);
  }
  due = {first, spans_.revision()};
  return changed;
}

// Of a square of a scale (block_tops.h).
ViewerOcclusion::InView ViewerOcclusion::inView(uint32_t scale, uint32_t i, uint32_t j) const {
  if (scene_.globe) {
    const Ball& ball = globeBall(scale, i, j);
    return inView(ball.middle, ball.radius_m + view_->region_radius_m);
  }
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
  return inView(middle, radius);
}

// About all of a square of a globe; so large that it is in view where it is no part of one face. What is read from
// pages for it is read once, as long as no other square takes its place.
const ViewerOcclusion::Ball& ViewerOcclusion::globeBall(uint32_t scale, uint32_t i, uint32_t j) const {
  constexpr uint32_t kBallsLog2 = 12;
  if (balls_.empty()) balls_.resize(size_t{1} << kBallsLog2);
  const uint64_t key = (uint64_t{scale + 1} << 28 | j) << 28 | i;
  Ball& ball = balls_[key * 0x9E3779B97F4A7C15u >> (64 - kBallsLog2)];
  if (ball.key == key) return ball;
  ball = {key, glm::dvec3(0), std::numeric_limits<double>::infinity()};
  const auto hull = scene_.globe->squares.hullOf(scale, i, j);
  if (!hull) return ball;
  ball.radius_m = 0;
  for (const glm::dvec3& corner : hull->corners) ball.middle += 0.25 * corner;
  for (const glm::dvec3& corner : hull->corners)
    ball.radius_m = std::max(ball.radius_m, glm::distance(ball.middle, corner));
  ball.radius_m += hull->error_m;
  return ball;
}

// Of a ball.
ViewerOcclusion::InView ViewerOcclusion::inView(const glm::dvec3& middle, double radius) const {
  const glm::dvec3 p = middle - view_->pose.eye;
  const double inside = frustum_->sideDistance(frustum_->toView(p.x, p.y, p.z));
  return inside + radius < 0 ? InView::kNot : inside < radius ? InView::kPartly : InView::kWholly;
}

size_t ViewerOcclusion::bytes() const {
  return sizeof(*this) + balls_.capacity() * sizeof(Ball) + proofs_.bytes() + spans_.bytes() +
         (objects_ ? objects_->bytes() : 0);
}

}  // namespace foreland::server
