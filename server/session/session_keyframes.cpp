// How a session computes a keyframe: for which view, and what goes with it.

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "server/session/session.h"

namespace foreland::server {

namespace {

// Where the camera is from a time on, for what tiles are worth. What is guessed goes straight on from there.
std::array<TileSender::Dwell, 4> dwellsFrom(const ExpectedMotion& motion, Time t, bool is_on_path) {
  constexpr std::array<double, 4> kAfter_s{0, 2, 5, 10}, kDwell_s{1, 2.5, 4, 5};
  const proto::Pose pose = motion.at(t);
  const glm::dvec3 metres_per_s = motion.at(t + Duration::seconds(1)).eye - pose.eye;
  std::array<TileSender::Dwell, 4> dwells;
  for (size_t i = 0; i < dwells.size(); ++i)
    dwells[i] = {is_on_path ? motion.at(t + Duration::seconds(kAfter_s[i]))
                            : proto::Pose{pose.eye + kAfter_s[i] * metres_per_s, pose.orientation},
                 kDwell_s[i]};
  return dwells;
}

}  // namespace

// When the next keyframe follows, and the view of this one.
Session::Keyframe Session::viewOf(Time t, SessionScratch& scratch) {
  const ViewerMotion& motion = input_.motion();
  const proto::ViewRequest& request = input_.request();
  const double tau_px = sectionTolerance();
  RegionParts parts;
  const auto fit = [&](Duration until_next) {
    parts = regionFor(state_, motion, request, t, until_next);
    fitRegion(viewFor(motion, request, tau_px, t, parts), parts, scratch);
  };
  Duration until_next = adaptive_interval_.next(input_.bounds(), state_.interval);
  fit(until_next);
  // Rather than guarantee less for long, the next keyframe follows sooner.
  const double share = motion.regionShare().shareOf(parts) / motion.regionShare().coarser();
  const Duration sooner = AdaptiveInterval::shortened(input_.bounds(), until_next, share);
  if (sooner < until_next) fit(until_next = sooner);
  return {t, until_next, viewFor(motion, request, tau_px, t, parts), parts};
}

// Computes a keyframe whose section is within all limits. False if it turned out to be larger than `max_nodes`.
bool Session::sendKeyframe(Keyframe keyframe, size_t max_nodes, SessionScratch& scratch, Bytes& message) {
  fitBudget(keyframe.view, scratch);
  const auto tau_px = static_cast<float>(keyframe.view.tau_px);  // as in the header
  keyframe.view.tau_px = sender_.toleranceThere(asDecoded(keyframe.view, tau_px), scratch.send);
  ViewerOcclusion* const visibility = visibilityFor(keyframe);
  return sender_.send(keyframe.view, keyframe.time_client, max_nodes, scratch.send, message, visibility, visibility);
}

// How far eyes may be from where the camera's is expected.
double Session::eyeError(Duration until_next) const {
  return input_.motion().eyeError(foreseenFor(state_, until_next)) + input_.request().eye_radius_m;
}

// What finds out what is hidden in a keyframe; null if nothing is to be left out.
ViewerOcclusion* Session::visibilityFor(const Keyframe& keyframe) {
  if (!occlusion_ || !input_.request().occlusion) return nullptr;
  using Effort = OcclusionControl::Effort;
  constexpr Duration kMaxFirstTests = Duration::milliseconds(2);
  if (options_.occlusion == Occlusion::kAuto) {
    const Effort before = occlusion_control_.effort();
    const Effort effort =
        occlusion_control_.next(state_.now, occlusion_share_, options_.occlusion_rank, sender_.startsFromNothing());
    if (effort == Effort::kNone && before != Effort::kNone) occlusion_->forget();
    if (effort == Effort::kNone) return nullptr;
    occlusion_->setEffort(effort == Effort::kAll ? ViewerOcclusion::Effort::kAll : ViewerOcclusion::Effort::kFading);
    // What starts from nothing has no other work that would be late, and becomes the smaller for it.
    occlusion_->limitFirstTests(sender_.startsFromNothing() ? ViewerOcclusion::kUnlimited : kMaxFirstTests);
  }
  const Time t = keyframe.time_client;
  occlusion_->expect(eyePathOf(input_.motion().expected(input_.request()), shownFrom(state_, t),
                               shownUntil(state_, t, keyframe.until_next), state_.grid, eyeError(keyframe.until_next)));
  return occlusion_.get();
}

// It matters only whether the section that nothing is left out of is several times as large as the one that is held.
size_t Session::nodesToCompare() const {
  constexpr size_t kTimes = 4, kFewest = 1000;
  return kTimes * sender_.adapter().nodeCount() + kFewest;
}

// While nobody waits, after keyframes and requests; where processors are short, not at all.
std::optional<Due> Session::comparisonDue() const {
  constexpr Duration kPatience = Duration::milliseconds(500);
  constexpr double kRefine_s = 90e-9;  // for each node (`foreland bench calibrate`)
  if (options_.occlusion != Occlusion::kAuto || !occlusion_ || state_.isFirst() || processors_ != Processors::kFree)
    return std::nullopt;
  const Duration cost = Duration::seconds(kRefine_s * static_cast<double>(nodesToCompare()));
  if (!occlusion_control_.isComparisonDue(state_.now, cost)) return std::nullopt;
  return Due{state_.now, state_.now + kPatience, true};
}

void Session::compareOcclusion(SessionScratch& scratch) {
  const size_t most = nodesToCompare();
  const bool is_whole =
      refine(world_->hierarchy, proto::viewOf(keyframe()), most, scratch.send.refine, scratch.send.section);
  const size_t with_hidden = is_whole ? scratch.send.section.slots.size() : most;
  statistics_.nodes_measured += with_hidden;
  occlusion_control_.compared(state_.now, sender_.adapter().nodeCount(), with_hidden);
  did_ = Did::kComparison;
}

// Chooses the scene time of the keyframe: with the finest tolerance that frames may keep.
void Session::moveGround(const Keyframe& keyframe) {
  const proto::Epochs& epochs = world_->hierarchy.epochs().epochs();
  if (epochs.empty()) return;
  const proto::View seen = asDecoded(keyframe.view, input_.request().tau_px);
  const auto next = input_.sceneTime().next(epochs, keyframe.time_client, [&](Time from, Time wanted) {
    return world_->motion ? world_->motion->towards(from, wanted, seen) : epochs.towards(from, wanted);
  });
  sender_.showAt(next.scene_time, next.is_step);
}

void Session::computeKeyframe(const KeyframePlan& plan, SessionScratch& scratch, std::vector<Bytes>& out) {
  const bool is_first = state_.isFirst(), is_after_jump = state_.has_jumped;
  const Duration step = is_first || state_.has_jumped ? state_.grid : plan.time_client - this->keyframe().time;
  if (state_.has_jumped) {
    sender_.restart();
    tolerance_.restart();
  }
  const Keyframe keyframe = viewOf(plan.time_client, scratch);
  moveGround(keyframe);
  Bytes message;
  // The second one starts from nothing, and so is as large as it was measured.
  if (!sendKeyframe(keyframe, maxNodes(), scratch, message))
    CHECK_TRUE(sendKeyframe(keyframe, std::numeric_limits<size_t>::max(), scratch, message));
  tolerance_.observe(sender_.triangles(), static_cast<double>(message.size()), step.toSeconds());
  if (!is_first) state_.last_client = this->keyframe().time;
  sendWithTiles(std::move(message), keyframe, out);
  observeRegion(keyframe.parts, scratch);

  unsent_ = true;
  did_ = Did::kKeyframe;
  state_.last_step = step;
  state_.before_last_computed = is_first ? state_.now - state_.grid : state_.last_computed;
  state_.last_computed = state_.now;
  state_.was_after_jump = std::exchange(state_.has_jumped, false);
  state_.is_coarse = is_after_jump && isCoarserThanWanted();
  notePredictions(keyframe);
  if (this->keyframe().base_index > 0)
    adaptive_interval_.observe(scratch.send.delta.added.size() + scratch.send.delta.removed.size(),
                               sender_.adapter().nodeCount(), step);
  state_.interval = keyframe.until_next;
  target_.reset();
  aim();
  state_.last_client = this->keyframe().time;
  in_flight_.push_back({this->keyframe().index, state_.now});
  count(plan, scratch);
}

// Notes what was expected of the camera, to be compared with what it does.
void Session::notePredictions(const Keyframe& keyframe) {
  const Duration foreseen = state_.leadTime(state_.interval);
  input_.motion().notePrediction({keyframe.time_client, keyframe.view.pose}, foreseen);
  // What is foreseen with `delay` and `current` is the time after the keyframe, which a higher order makes longer.
  if (state_.order == 1 || state_.predicts) return;
  const Time end = shownUntil(state_, keyframe.time_client, keyframe.until_next);
  input_.motion().notePrediction({end, input_.motion().expected(input_.request()).at(end)}, foreseen);
}

// The header's tolerance is a float.
bool Session::isCoarserThanWanted() const { return keyframe().tau_px > 1.001 * sectionTolerance(); }

void Session::count(const KeyframePlan& plan, const SessionScratch& scratch) {
  statistics_.keyframes += 1;
  statistics_.skipped_keyframes += plan.skipped;
  statistics_.nodes_added += scratch.send.delta.added.size();
  statistics_.nodes_removed += scratch.send.delta.removed.size();
  statistics_.tau_px = keyframe().tau_px;
  statistics_.is_coarse = isCoarserThanWanted();
  statistics_.is_lacking = sender_.pages() && sender_.pages()->isLacking();
  statistics_.nodes_tested = sender_.adapter().testCount();
  statistics_.nodes_swept = sender_.adapter().sweptCount();
  if (occlusion_) countOcclusion();
  statistics_.section_nodes = sender_.nodeCount();
  statistics_.remembered_nodes = sender_.adapter().memory().pages.knownCount();
  statistics_.memory_bytes = sender_.adapter().memory().pages.bytes() + (occlusion_ ? occlusion_->bytes() : 0);
}

void Session::countOcclusion() {
  const OcclusionStatistics before = std::exchange(statistics_.occlusion, occlusion_->statistics());
  statistics_.occlusion_time = statistics_.occlusion_time + (statistics_.occlusion.usualCost() - before.usualCost());
  const bool is_auto = options_.occlusion == Occlusion::kAuto;
  statistics_.hidden_objects = sender_.hiddenObjects();
  statistics_.is_occluding = sender_.hiddenBlocks() != nullptr;
  statistics_.left_out_nodes =
      statistics_.is_occluding && is_auto
          ? static_cast<size_t>(occlusion_control_.leftOut() * static_cast<double>(sender_.adapter().nodeCount()))
          : 0;
  statistics_.occlusion_shed = occlusion_control_.timesShed();
  statistics_.occlusion_worthless = occlusion_control_.timesWorthless();
}

// A keyframe's message, and what goes with it. Tiles follow the keyframe that shows them, and those for where the
// camera will be in the next seconds, one of them each time. What is predicted for later is worth less, so it is looked
// at only while the link keeps tiles waiting.
void Session::sendWithTiles(Bytes message, const Keyframe& keyframe, std::vector<Bytes>& out) {
  constexpr int64_t kMaxSecondsAhead = 3;
  constexpr double kRoom = 1.25, kRoom_m = 0.1;
  const proto::ViewRequest& request = input_.request();
  if (!tiles_ || !(request.relief || request.imagery)) {
    out.push_back(std::move(message));
    return;
  }
  const uint32_t index = this->keyframe().index;
  const Time t = keyframe.time_client;
  const bool is_on_path = input_.motion().isOnPath(request), looks_far = tiles_->isShort() || is_on_path;
  const Time later = t + Duration::seconds(looks_far ? 1 + index % kMaxSecondsAhead : 1);
  const ExpectedMotion motion = input_.motion().expected(request);
  const double unknown_m = eyeError(keyframe.until_next);
  const auto eyesOf = [&](Time begin, Time end) {
    EyeCapsule eyes = capsuleOf(motion, begin, end);
    eyes.radius_m += unknown_m;
    return eyes;
  };
  // With some room, so that what is found for later serves again when it is there.
  EyeCapsule later_eyes = eyesOf(later, later + keyframe.until_next * kMaxSecondsAhead);
  later_eyes.radius_m = kRoom * later_eyes.radius_m + kRoom_m;
  const std::array targets{
      TileSender::Target{keyframe.view, eyesOf(shownFrom(state_, t), shownUntil(state_, t, keyframe.until_next))},
      TileSender::Target{{motion.at(later), keyframe.view.lens, keyframe.view.tau_px}, later_eyes}};
  tiles_->choose(index, targets, dwellsFrom(motion, later, is_on_path), request);
  tiles_->pace().keyframeSent(index, message.size(), state_.now, keyframe.until_next.toSeconds(),
                              request.max_bytes_per_second);
  tiles_->takeStatement(out);
  out.push_back(std::move(message));
  tiles_->takeTiles(out);
  if (HeldPages* pages = sender_.pages()) pages->expectTiles(tiles_->takeLacking());
  statistics_.tiles = tiles_->statistics().tiles;
  statistics_.tile_bytes = tiles_->statistics().bytes;
}

}  // namespace foreland::server
