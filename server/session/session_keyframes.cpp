// How a session computes a keyframe: for which view, and what goes with it.

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "server/session/session.h"

namespace foreland::server {

namespace {

// For how many intervals the first keyframe after a jump is expected to be shown.
constexpr int64_t kShownAfterJump = 5;

// Where the camera is from a time on, for what tiles are worth. What is guessed goes straight on from there.
std::array<TileSender::Stay, 4> staysFrom(const ExpectedMotion& motion, Time t, bool is_on_path) {
  constexpr std::array<double, 4> kAfter_s{0, 2, 5, 10}, kStay_s{1, 2.5, 4, 5};
  const proto::Pose pose = motion.at(t);
  const glm::dvec3 metres_per_s = motion.at(t + Duration::seconds(1)).eye - pose.eye;
  std::array<TileSender::Stay, 4> stays;
  for (size_t i = 0; i < stays.size(); ++i)
    stays[i] = {is_on_path ? motion.at(t + Duration::seconds(kAfter_s[i]))
                           : proto::Pose{pose.eye + kAfter_s[i] * metres_per_s, pose.orientation},
                kStay_s[i]};
  return stays;
}

}  // namespace

// When a keyframe for `t` begins to be shown. The first section, and one after a jump, is shown as soon as it arrives.
Time Session::shownFrom(Time t) const {
  if (jumped_) return motion_.newest().time;
  if (isFirst()) return std::min(motion_.newest().time, t - leadOf(request_->keyframe_interval));
  return std::min(keyframe().time, t - request_->keyframe_interval) - (leadOf(last_step_) - last_step_);
}

// What the camera stays in while the section for `t` is shown, around where it is expected then.
RegionParts Session::regionFor(Time t, Duration until_next) const {
  const ExpectedMotion motion = motion_.expected(*request_);
  const Time end = t + leadOf(until_next);
  const Duration unknown = jumped_ ? request_->keyframe_interval * kShownAfterJump : end - motion_.newest().time;
  return motion_.regionAround(motion.at(t), motion, shownFrom(t), end, leadOf(std::max(interval_, until_next)),
                              unknown);
}

// The keyframe's pose, and what its viewer gets of the region around it.
proto::View Session::viewFor(Time t, const RegionParts& parts) const {
  proto::View view{motion_.expected(*request_).at(t), request_->lens, sectionTolerance()};
  const Region region = motion_.regionShare().of(parts);
  // Floats, as in the keyframe's header.
  view.region_radius_m = static_cast<float>(region.radius_m);
  view.region_angle_rad = static_cast<float>(region.angle_rad);
  return view;
}

// Computes a keyframe whose section is within all limits. False if it turned out to be larger than `max_nodes`.
bool Session::sendKeyframe(proto::View view, const Plan& plan, size_t max_nodes, SessionScratch& scratch,
                           Bytes& message) {
  fitBudget(view, scratch);
  ViewerOcclusion* const visibility = request_->occlusion ? occlusion_.get() : nullptr;
  if (visibility)
    visibility->expect(outlookOf(motion_.expected(*request_), shownFrom(plan.time_client),
                                 plan.time_client + leadOf(plan.until_next), request_->keyframe_interval,
                                 motion_.eyeError(leadOf(std::max(interval_, plan.until_next)))));
  return sender_.send(view, plan.time_client, max_nodes, scratch.send, message, visibility);
}

// Chooses the scene time of the keyframe for `view`.
void Session::moveGround(Time t, const proto::View& view) {
  const proto::Epochs& epochs = world_->hierarchy.epochs().epochs();
  if (epochs.empty()) return;
  // As the viewer decodes it, and with the finest tolerance that frames may keep.
  const proto::View seen{proto::asSentInHeader(view.pose), view.lens, request_->tau_px,
                         proto::shortAtLeast(view.region_radius_m), proto::shortAtLeast(view.region_angle_rad)};
  const auto next = scene_time_.next(epochs, t, [&](Time from, Time wanted) {
    return world_->motion ? world_->motion->towards(from, wanted, seen) : epochs.towards(from, wanted);
  });
  sender_.showAt(next.scene_time, next.is_step);
}

// That the viewer's frames are to keep, less what the ground's motion takes of it.
double Session::sectionTolerance() const {
  return proto::sectionTolerance(world_->hierarchy.epochs().epochs().blend(), request_->tau_px);
}

void Session::computeKeyframe(Plan plan, Time now, SessionScratch& scratch, std::vector<Bytes>& out) {
  const double interval_s =
      isFirst() || jumped_ ? request_->keyframe_interval.toSeconds() : (plan.time_client - keyframe().time).toSeconds();
  if (jumped_) {
    sender_.restart();
    tolerance_.restart();
  }
  plan.until_next = adaptive_interval_.next(bounds(), interval_);
  RegionParts parts = regionFor(plan.time_client, plan.until_next);
  fitRegion(viewFor(plan.time_client, parts), parts, scratch);
  // Rather than guarantee less for long, the next keyframe follows sooner.
  const double share = motion_.regionShare().shareOf(parts);
  if (const Duration sooner = AdaptiveInterval::shortened(bounds(), plan.until_next, share); sooner < plan.until_next) {
    plan.until_next = sooner;
    parts = regionFor(plan.time_client, plan.until_next);
    fitRegion(viewFor(plan.time_client, parts), parts, scratch);
  }
  const proto::View view = viewFor(plan.time_client, parts);
  moveGround(plan.time_client, view);
  Bytes message;
  // The second one starts from nothing, and so is as large as it was measured.
  if (!sendKeyframe(view, plan, maxNodes(), scratch, message))
    CHECK_TRUE(sendKeyframe(view, plan, std::numeric_limits<size_t>::max(), scratch, message));
  tolerance_.observe(sender_.triangles(), static_cast<double>(message.size()), interval_s);
  sendWithTiles(std::move(message), plan, view, out);
  observeRegion(scratch);
  last_step_ = Duration::seconds(interval_s);

  unsent_ = true;
  keyframe_before_last_at_ = isFirst() ? now - request_->keyframe_interval : last_keyframe_at_;
  last_keyframe_at_ = now;
  did_ = Did::kKeyframe;
  was_after_jump_ = std::exchange(jumped_, false);
  motion_.notePrediction({plan.time_client, view.pose}, leadOf(interval_));
  // What is foreseen with `delay` and `current` is the time after the keyframe, which a higher order makes longer.
  if (const Time end = plan.time_client + leadOf(plan.until_next);
      request_->order > 1 && request_->strategy != proto::Strategy::kPredict)
    motion_.notePrediction({end, motion_.expected(*request_).at(end)}, leadOf(interval_));
  if (keyframe().base_index > 0)
    adaptive_interval_.observe(scratch.send.delta.added.size() + scratch.send.delta.removed.size(),
                               sender_.adapter().nodeCount(), Duration::seconds(interval_s));
  interval_ = plan.until_next;
  target_.reset();
  aim();
  in_flight_.push_back({keyframe().index, now});
  statistics_.keyframes += 1;
  statistics_.skipped_keyframes += plan.skipped;
  statistics_.nodes_added += scratch.send.delta.added.size();
  statistics_.nodes_removed += scratch.send.delta.removed.size();
  statistics_.tau_px = keyframe().tau_px;
  statistics_.is_coarse = keyframe().tau_px > 1.001 * sectionTolerance();  // it is a float
  statistics_.nodes_tested = sender_.adapter().testCount();
  if (occlusion_) statistics_.occlusion = occlusion_->statistics();
  statistics_.section_nodes = sender_.nodeCount();
  statistics_.remembered_nodes = sender_.adapter().memory().pages.knownCount();
  statistics_.memory_bytes = sender_.adapter().memory().pages.bytes() + (occlusion_ ? occlusion_->bytes() : 0);
}

// A keyframe's message, and what goes with it. Tiles follow the keyframe that shows them, and those for where the
// camera will be in the next seconds, one of them each time. What is predicted for later is worth less, so it is looked
// at only while the link keeps tiles waiting.
void Session::sendWithTiles(Bytes message, const Plan& plan, const proto::View& view, std::vector<Bytes>& out) {
  constexpr int64_t kMaxSecondsAhead = 3;
  constexpr double kRoom = 1.25, kRoom_m = 0.1;
  if (!tiles_ || !(request_->relief || request_->imagery)) {
    out.push_back(std::move(message));
    return;
  }
  const bool looks_far = tiles_->isShort() || motion_.isOnPath(*request_);
  const Time later = plan.time_client + Duration::seconds(looks_far ? 1 + keyframe().index % kMaxSecondsAhead : 1);
  const ExpectedMotion motion = motion_.expected(*request_);
  const double unknown_m = motion_.eyeError(leadOf(std::max(interval_, plan.until_next)));
  const auto eyesOf = [&](Time begin, Time end) {
    EyeSweep eyes = sweepOf(motion, begin, end);
    eyes.radius_m += unknown_m;
    return eyes;
  };
  // With some room, so that what is found for later serves again when it is there.
  EyeSweep later_eyes = eyesOf(later, later + plan.until_next * kMaxSecondsAhead);
  later_eyes.radius_m = kRoom * later_eyes.radius_m + kRoom_m;
  const std::array targets{
      TileSender::Target{view, eyesOf(shownFrom(plan.time_client), plan.time_client + leadOf(plan.until_next))},
      TileSender::Target{{motion.at(later), view.lens, view.tau_px}, later_eyes}};
  tiles_->choose(keyframe().index, targets, staysFrom(motion, later, motion_.isOnPath(*request_)), *request_);
  tiles_->pace().keyframeSent(keyframe().index, message.size(), now_, plan.until_next.toSeconds(),
                              request_->max_bytes_per_second);
  tiles_->takeStatement(out);
  out.push_back(std::move(message));
  tiles_->takeTiles(out);
  statistics_.tiles = tiles_->statistics().tiles;
  statistics_.tile_bytes = tiles_->statistics().bytes;
}

}  // namespace foreland::server
