#include "server/session/session.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "proto/codec/section_codec.h"

namespace foreland::server {

namespace {

constexpr Duration kPrefetchEvery = Duration::milliseconds(500);

// Where a viewer limits its bytes: what an added node costs, beyond which tolerance bytes count no more, and how long
// the first section may take on the link.
constexpr double kBitsOfNode = 10, kCoarsest_px = 200;
constexpr Duration kFirstThrough = Duration::seconds(1);

// For how many intervals the first keyframe after a jump is expected to be shown.
constexpr int64_t kShownAfterJump = 5;

}  // namespace

Session::Session(std::shared_ptr<const World> world, const SessionOptions& options)
    : world_(std::move(world)), options_(options), sender_(world_->hierarchy) {}

Status Session::receive(ByteSpan bytes, Time now) {
  now_ = std::max(now_, now);
  auto message = proto::decodeClientMessage(bytes, poses_taken_);
  if (!message) return message.error();
  if (!request_ && !std::holds_alternative<proto::ViewRequest>(*message))
    return Error{ErrorCode::kMalformed, "the first message must be a view request"};
  const Status status = std::visit([&](const auto& m) { return take(m, now); }, *message);
  aim();
  return status;
}

void Session::onDrained(Time now) {
  now_ = std::max(now_, now);
  unsent_ = false;
  aim();
}

Status Session::take(const proto::ViewRequest& request, Time) {
  const bool first = !request_;
  request_ = request;
  if (request_->tau_px == 0) request_->tau_px = options_.tau_px;
  if (request_->keyframe_interval == Duration{}) {
    request_->keyframe_interval = options_.keyframe_interval;
    request_->longest_interval = request_->order == 1 ? options_.longest_interval : Duration{};
  }
  if (first) {
    if (world_->occlusion && request.occlusion) {
      occlusion_ = std::make_unique<ViewerOcclusion>(world_->hierarchy, *world_->occlusion);
      sender_.tellBlocks();
    }
    proto::Welcome welcome = welcomeTo(world_->hierarchy);
    welcome.tau_px = request_->tau_px;
    welcome.keyframe_interval = request_->keyframe_interval;
    welcome.longest_interval = request_->longest_interval;
    welcome.occlusion = occlusion_ != nullptr;
    welcome.memory_bytes = std::min(request_->memory_bytes, options_.max_memory_bytes);
    welcome.tile_bytes = std::min(request_->tile_bytes, options_.max_tile_bytes);
    if (!welcome.tile_layers.empty())
      tiles_ = std::make_unique<TileSender>(world_->hierarchy, world_->ground, welcome.tile_bytes);
    sender_.setMemory(welcome.memory_bytes);
    replies_.push_back(proto::encode(welcome));
  }
  interval_ = std::clamp(interval_, bounds().shortest, bounds().most());
  target_.reset();
  return {};
}

Status Session::take(const proto::Path& path, Time) {
  motion_.announce(path);
  return {};
}

// A scene without epochs does not mind.
Status Session::take(const proto::HeldTiles& held, Time) {
  if (!isFirst() || !tiles_ || tiles_->statistics().tiles > 0)
    return Error{ErrorCode::kMalformed, "a client tells the tiles that it holds before its first pose, or not at all"};
  return tiles_->hold(held);
}

Status Session::take(const proto::SceneClock& clock, Time) {
  scene_time_.take(clock);
  return {};
}

Status Session::take(const proto::TourRequest& request, Time) { return requests_.add(request); }

Status Session::take(const proto::GroundRequest& request, Time) { return requests_.add(request); }

size_t Session::keptBytes() const {
  size_t bytes = motion_.pathBytes() + requests_.bytes() + (resume_ ? resume_->section.size() : 0);
  for (const Bytes& reply : replies_) bytes += reply.size();
  return bytes;
}

void Session::answer(std::vector<Bytes>& out) {
  out.push_back(requests_.answer(world_->hierarchy.scene()));
  ++statistics_.replies;
  did_ = Did::kRequest;
  unsent_ = true;
}

Status Session::take(const proto::PoseUpdate& update, Time now) {
  if (update.received_keyframe > keyframe().index)
    return Error{ErrorCode::kMalformed, "a pose update acknowledges a keyframe that was never sent"};
  // After a clock was set anew, times before it and after it cannot be compared.
  if (!clocks_.poseArrived(update.pose.time, now) || motion_.isJump(update.pose, world_->hierarchy.scene()) ||
      isTooFarAhead())
    jumpTo(update.pose);
  else
    motion_.add(update.pose);
  if (update.received_keyframe > acknowledged_) {
    acknowledged_ = update.received_keyframe;
    while (!in_flight_.empty() && in_flight_.front().index <= acknowledged_) {
      if (in_flight_.front().index == acknowledged_) {
        clocks_.keyframeArrived(update.received_at, in_flight_.front().at);
        if (tiles_) tiles_->pace().keyframeArrived(acknowledged_, update.received_at, clocks_.roundTrip());
      }
      in_flight_.pop_front();
    }
  }
  return {};
}

void Session::jumpTo(const proto::TimedPose& pose) {
  ++statistics_.jumps;
  motion_.jumpTo(pose);
  adaptive_interval_.restart();
  if (isFirst() && !isTooFarAhead()) return;  // it starts from nothing, or from what the viewer holds
  target_.reset();
  jumped_ = true;
}

// Whether the last keyframe is for a time that is not foreseen by now: it was computed, here or before the viewer
// resumed, for a time stamp that was wrong. No keyframe could follow it for long. Poses that a stalled link holds back
// say nothing of the kind.
bool Session::isTooFarAhead() const {
  constexpr Duration kMostAhead = Duration::seconds(2);
  return keyframe().index > 0 &&
         keyframe().time > clocks_.clientTime(now_) + clocks_.roundTrip() + bounds().most() * 2 + kMostAhead;
}

Status Session::take(const proto::Resume& resume, Time) {
  if (!isFirst() || !motion_.empty() || resumed_)
    return Error{ErrorCode::kMalformed, "a client resumes once, before its first pose, or not at all"};
  resume_ = resume;
  resumed_ = true;
  return {};
}

// A section that cannot be resumed from is no mistake of the viewer's: it is sent a whole section then.
void Session::tryToResume() {
  const proto::Resume resume = *std::exchange(resume_, std::nullopt);
  did_ = Did::kRequest;
  const Hierarchy& hierarchy = world_->hierarchy;
  if (resume.scene_id != hierarchy.scene().id()) return;
  const auto sections =
      proto::decodeSections(hierarchy.grid(), hierarchy.objects().set, resume.section, options_.max_section_nodes);
  if (!sections.ok() || proto::fingerprint(*sections) != resume.fingerprint) return;
  if (!sender_.resume(*sections, resume.keyframe, resume.time, resume.fingerprint)) return;
  acknowledged_ = resume.keyframe;
  statistics_.resumed = true;
  if (!motion_.empty() && isTooFarAhead()) jumped_ = true;
  aim();
}

Time Session::gridAtOrAfter(Time t) const {
  const int64_t T = request_->keyframe_interval.us;
  const int64_t steps = t.us >= 0 ? (t.us + T - 1) / T : -(-t.us / T);
  return {steps * T};
}

// Nearest after the last one that is not to be skipped.
Time Session::nextKeyframe() const {
  if (isFirst()) return gridAtOrAfter(motion_.newest().time);
  return gridAtOrAfter(keyframe().time + interval_ - request_->keyframe_interval + Duration{1});
}

void Session::aim() {
  if (!request_ || motion_.empty() || request_->strategy != proto::Strategy::kPredict || jumped_ || resume_) return;
  const Duration T = interval_;
  // The client needs a keyframe when it reaches the time of the one before it, or of those that it shows before it.
  const auto deadline = [&](Time t) { return clocks_.sendBy(t - leadOf(T)) - options_.safety; };
  if (target_ && deadline(*target_) + Duration{T.us / 2} >= now_) return;
  const Time next = nextKeyframe();
  const Duration behind = now_ + compute_time_ - deadline(next);
  target_ = behind > Duration{} ? gridAtOrAfter(next + behind) : next;
}

// Keyframes are an interval apart on the client's clock. Whatever that clock says, hardly more than two of them are
// computed in an interval of the server's, and one if the camera jumps every time.
Time Session::earliestKeyframe() const {
  if (isFirst()) return {};
  const Duration T = request_->keyframe_interval;
  if (jumped_ && was_after_jump_) return last_keyframe_at_ + T;
  return keyframe_before_last_at_ + Duration{T.us - T.us / 8};
}

Session::Plan Session::notTooSoon(Plan plan) const {
  const Time earliest = earliestKeyframe();
  plan.due.release = std::max(plan.due.release, earliest);
  plan.due.deadline = std::max(plan.due.deadline, earliest);
  if (plan.due.earliest) plan.due.earliest = std::max(*plan.due.earliest, earliest);
  return plan;
}

std::optional<Session::Plan> Session::plan() const {
  if (!request_ || motion_.empty() || unsent_ || resume_ || in_flight_.size() >= options_.max_unacknowledged)
    return std::nullopt;
  // After a jump the newest pose counts at once: what is shown was computed for elsewhere.
  if (jumped_) return notTooSoon({motion_.newest().time, {now_, now_}, 0, {}});
  const Duration T = request_->keyframe_interval;
  const bool first = isFirst();
  const Time next = nextKeyframe();
  // No more than real time has gone by, whatever the client's clock says.
  const int64_t most_skipped = (now_ - last_keyframe_at_).us / T.us + 1;
  const auto skippedTo = [&](Time t) {
    return first || t < next ? 0 : static_cast<uint64_t>(std::min((t - next).us / T.us, most_skipped));
  };

  if (request_->strategy == proto::Strategy::kPredict) {
    if (!target_) return std::nullopt;
    const Time deadline = clocks_.sendBy(*target_ - leadOf(interval_)) - options_.safety;
    Due due{deadline - compute_time_, deadline, false, compute_time_};
    if (options_.most_early > Duration{} && !first) {
      due.earliest = due.release - std::min(options_.most_early, Duration{T.us / 2});
      due.release = std::max(*due.earliest, due.release - options_.slack);
    }
    return notTooSoon({*target_, due, skippedTo(*target_), {}});
  }
  // The pose of the grid point must have arrived; if those of several have, the newest one counts.
  const Time newest = motion_.newest().time;
  if (first) return Plan{newest, {now_, now_}, 0, {}};
  if (newest < next) return std::nullopt;
  const Time latest{next.us + (newest - next).us / T.us * T.us};
  return notTooSoon({latest, {now_, now_ + Duration{T.us / 2}, false, compute_time_}, skippedTo(latest), {}});
}

std::optional<Session::Due> Session::due() const {
  if (!replies_.empty()) return Due{now_, now_};
  std::optional<Due> first;
  const auto consider = [&](const std::optional<Due>& due) {
    if (due && (!first || due->release < first->release)) first = due;
  };
  if (const auto p = plan()) consider(p->due);
  consider(requestDue());
  consider(prefetchDue());
  return first;
}

// After keyframes, which viewers wait for.
std::optional<Session::Due> Session::requestDue() const {
  constexpr Duration kPatience = Duration::milliseconds(200);
  if (resume_) return Due{now_, now_ + kPatience, true};
  if (requests_.empty() || unsent_) return std::nullopt;
  const Time release = std::max(now_, next_request_);
  return Due{release, release + kPatience, true};
}

// Its deadline is half a second later, so that keyframes are preferred. Where processors are short it is shed first.
std::optional<Session::Due> Session::prefetchDue() const {
  if (options_.prefetch_ahead == Duration{} || isFirst() || processors_ != Processors::kFree) return std::nullopt;
  return Due{next_prefetch_, next_prefetch_ + kPrefetchEvery, true};
}

// Refining for where the viewer will be reads the pages of the scene that its keyframes will need, while nobody waits.
void Session::prefetch(SessionScratch& scratch) {
  proto::View view = viewFor(motion_.newest().time + options_.prefetch_ahead, interval_);
  view.tau_px = keyframe().tau_px;
  view.region_radius_m = view.region_angle_rad = 0;
  // If the section is too large, more than enough has been read.
  (void)refine(world_->hierarchy, view, mostNodes(), scratch.send.refine, scratch.send.section);
  next_prefetch_ = now_ + kPrefetchEvery;
  ++statistics_.prefetches;
}

void Session::step(Time now, SessionScratch& scratch, std::vector<Bytes>& out, Start start) {
  now_ = std::max(now_, now);
  const bool is_greeting = !replies_.empty();
  for (Bytes& reply : std::exchange(replies_, {})) out.push_back(std::move(reply));
  did_ = Did::kNothing;
  const auto next = plan();
  if (next && (start == Start::kEarly ? next->due.earliest.value_or(next->due.release) : next->due.release) <= now_)
    return computeKeyframe(*next, now_, scratch, out);
  if (is_greeting) return;  // which is due at once, unlike what follows
  if (resume_) return tryToResume();
  if (const auto due = requestDue(); due && due->release <= now_) return answer(out);
  if (const auto due = prefetchDue(); due && due->release <= now_) prefetch(scratch);
}

// When a keyframe for `t` begins to be shown. The first section, and one after a jump, is shown as soon as it arrives.
Time Session::shownFrom(Time t) const {
  if (jumped_) return motion_.newest().time;
  if (isFirst()) return std::min(motion_.newest().time, t - leadOf(request_->keyframe_interval));
  return std::min(keyframe().time, t - request_->keyframe_interval) - (leadOf(last_step_) - last_step_);
}

// The keyframe's pose, and the region around it that the camera stays in while the section is shown.
proto::View Session::viewFor(Time t, Duration until_next) const {
  const ExpectedMotion motion = motion_.expected(*request_);
  proto::View view{motion.at(t), request_->lens, sectionTolerance()};
  const Time end = t + leadOf(until_next);
  const Duration unknown = jumped_ ? request_->keyframe_interval * kShownAfterJump : end - motion_.newest().time;
  const Region region =
      motion_.regionAround(view.pose, motion, shownFrom(t), end, leadOf(std::max(interval_, until_next)), unknown);
  // Floats, as in the keyframe's header.
  view.region_radius_m = static_cast<float>(region.radius_m);
  view.region_angle_rad = static_cast<float>(region.angle_rad);
  return view;
}

// A mesh has four triangles a root and two a node; the union of two sections is a little larger.
size_t Session::mostNodes() const {
  if (request_->max_triangles == 0) return options_.max_section_nodes;
  const proto::GridShape& shape = world_->hierarchy.grid().shape();
  const double nodes = 0.5 * (0.97 * request_->max_triangles - 4.0 * shape.roots_x * shape.roots_y);
  return std::min(options_.max_section_nodes, static_cast<size_t>(std::max(1.0, nodes)));
}

// How many nodes may be added before the delta takes the link longer than an interval, which would make this keyframe
// late, and the next ones.
double Session::mostAddedForLink() const {
  const Duration allowed = sender_.startsFromNothing() ? kFirstThrough : interval_;
  return 8.0 * request_->max_bytes_per_second * allowed.toSeconds() / kBitsOfNode;
}

// The share that the section of `view` takes of what viewer, link and server allow; infinite if it is not even
// measured whole.
double Session::loadOf(const proto::View& view, SessionScratch& scratch) {
  const size_t most_added = jumped_ ? options_.max_added_after_jump : options_.max_added_nodes;
  // What starts from nothing is added whole, though what is remembered is not sent.
  const size_t most = sender_.startsFromNothing() ? std::min(mostNodes(), options_.max_added_nodes) : mostNodes();
  const SectionSize size = sender_.measure(view, most, scratch.send);
  statistics_.nodes_measured += size.nodes;
  if (!size.fits) return std::numeric_limits<double>::infinity();
  double load = std::max(double(size.nodes) / double(most), double(size.added) / double(most_added));
  if (request_->max_bytes_per_second > 0 && view.tau_px < kCoarsest_px)
    load = std::max(load, double(size.added) / mostAddedForLink());
  return load;
}

// Sets the tolerance that the viewer's budget allows, and a coarser one if the section, or what it adds, would still be
// too large for the viewer, the link, or one step of the server. One refinement tells, and is all that is done in most
// keyframes.
void Session::fitBudget(proto::View& view, SessionScratch& scratch) {
  const Budget budget{request_->max_triangles, request_->max_bytes_per_second, processors_};
  const double before_px = tolerance_.tolerance();
  const double wanted_px = static_cast<float>(tolerance_.next(sectionTolerance(), budget));
  view.tau_px = wanted_px;
  if (budget.bytes_per_second == 0 && sender_.isLikelyToFit(view, mostNodes())) return tolerance_.force(wanted_px);
  const auto load = [&](double tau_px) {
    view.tau_px = tau_px;
    return loadOf(view, scratch);
  };
  view.tau_px = toleranceThatFits(wanted_px, before_px, load);
  if (view.tau_px == kMostTolerance_px) {
    // No section guarantees anything for a region that holds much of the scene, so this one does for its pose alone.
    view.region_radius_m = view.region_angle_rad = 0;
    view.tau_px = toleranceThatFits(wanted_px, before_px, load);
  }
  // A keyframe that starts from nothing may be coarse because it is to be there at once; the next one need not be.
  if (!sender_.startsFromNothing() || budget.triangles > 0 || budget.bytes_per_second > 0)
    tolerance_.force(view.tau_px);
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
  const proto::View view = viewFor(plan.time_client, plan.until_next);
  moveGround(plan.time_client, view);
  Bytes message;
  // The second one starts from nothing, and so is as large as it was measured.
  if (!sendKeyframe(view, plan, mostNodes(), scratch, message))
    CHECK_TRUE(sendKeyframe(view, plan, std::numeric_limits<size_t>::max(), scratch, message));
  tolerance_.observe(sender_.triangles(), static_cast<double>(message.size()), interval_s);
  out.push_back(std::move(message));
  sendTiles(plan, view, out);
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
  statistics_.memory_bytes = sender_.adapter().memory().pages.bytes();
}

// Tiles follow the keyframe that shows them, and those for where the camera will be in the next seconds, one of them
// each time. What is predicted for later is worth less, so it is looked at only while the link keeps tiles waiting.
void Session::sendTiles(const Plan& plan, const proto::View& view, std::vector<Bytes>& out) {
  constexpr int64_t kMostSecondsAhead = 3;
  constexpr double kRoom = 1.25, kRoom_m = 0.1;
  if (!tiles_ || !(request_->relief || request_->imagery)) return;
  const bool looks_far = tiles_->isShort() || motion_.isOnPath(*request_);
  const Time later = plan.time_client + Duration::seconds(looks_far ? 1 + keyframe().index % kMostSecondsAhead : 1);
  const ExpectedMotion motion = motion_.expected(*request_);
  const double unknown_m = motion_.eyeError(leadOf(std::max(interval_, plan.until_next)));
  const auto eyesOf = [&](Time begin, Time end) {
    EyeSweep eyes = sweepOf(motion, begin, end);
    eyes.radius_m += unknown_m;
    return eyes;
  };
  // With some room, so that what is found for later serves again when it is there.
  EyeSweep later_eyes = eyesOf(later, later + plan.until_next * kMostSecondsAhead);
  later_eyes.radius_m = kRoom * later_eyes.radius_m + kRoom_m;
  const std::array targets{
      TileSender::Target{view, eyesOf(shownFrom(plan.time_client), plan.time_client + leadOf(plan.until_next))},
      TileSender::Target{{motion.at(later), view.lens, view.tau_px}, later_eyes}};
  tiles_->choose(keyframe().index, targets, *request_);
  tiles_->pace().keyframeSent(keyframe().index, out.back().size(), now_, plan.until_next.toSeconds(),
                              request_->max_bytes_per_second);
  tiles_->take(out);
  statistics_.tiles = tiles_->statistics().tiles;
  statistics_.tile_bytes = tiles_->statistics().bytes;
}

// How much the region makes of the section. Along an announced path the region is not reduced: there it is no guess.
void Session::observeRegion(SessionScratch& scratch) {
  const bool is_guess = request_->strategy == proto::Strategy::kPredict && !motion_.isOnPath(*request_);
  if (!is_guess || !motion_.regionShare().isDue(sender_.nodeCount())) return;
  proto::View pose_alone = proto::viewOf(keyframe());
  pose_alone.region_radius_m = pose_alone.region_angle_rad = 0;
  const SectionSize size = sender_.measure(pose_alone, sender_.nodeCount() + 1, scratch.send);
  statistics_.nodes_measured += size.nodes;
  motion_.regionShare().observe(sender_.nodeCount(), size.nodes);
}

// The estimate rises at once and falls slowly, so that a plan holds for the slower of the recent keyframes.
void Session::noteComputeTime(Duration spent) {
  constexpr int64_t kRest = 4;  // times what a request took
  if (did_ == Did::kKeyframe) compute_time_ = std::max(spent, Duration{(compute_time_.us * 15 + spent.us) / 16});
  if (did_ == Did::kRequest) next_request_ = now_ + spent + spent * kRest;
}

}  // namespace foreland::server
