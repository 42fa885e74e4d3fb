#include "server/session/session.h"

#include <algorithm>
#include <utility>

#include "proto/codec/section_codec.h"

namespace foreland::server {

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
  if (tiles_) tiles_->pace().drained(now_);
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

Status Session::take(const proto::HeldTiles& held, Time) {
  if (!isFirst() || !tiles_ || tiles_->statistics().tiles > 0)
    return Error{ErrorCode::kMalformed, "a client tells the tiles that it holds before its first pose, or not at all"};
  return tiles_->hold(held);
}

// Where the scene has no epochs, its clock changes nothing.
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
      isTooFarAhead() || isAnnouncedJump(update, now))
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

bool Session::isAnnouncedJump(const proto::PoseUpdate& update, Time now) {
  const bool is_next = !motion_.empty() && update.pose.time > motion_.newest().time;
  return update.has_jumped && is_next && announced_jumps_.take(now);
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
  constexpr Duration kMaxAhead = Duration::seconds(2);
  return keyframe().index > 0 &&
         keyframe().time > clocks_.clientTime(now_) + clocks_.roundTrip() + bounds().most() * 2 + kMaxAhead;
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
  const int64_t max_skipped = (now_ - last_keyframe_at_).us / T.us + 1;
  const auto skippedTo = [&](Time t) {
    return first || t < next ? 0 : static_cast<uint64_t>(std::min((t - next).us / T.us, max_skipped));
  };

  if (request_->strategy == proto::Strategy::kPredict) {
    if (!target_) return std::nullopt;
    const Time deadline = clocks_.sendBy(*target_ - leadOf(interval_)) - options_.safety;
    Due due{deadline - compute_time_, deadline, false, compute_time_};
    if (options_.max_early > Duration{} && !first) {
      due.earliest = due.release - std::min(options_.max_early, Duration{T.us / 2});
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
  return Due{prefetch_pace_.next(), prefetch_pace_.next() + PrefetchPace::kMin, true};
}

// Refining for where the viewer will be reads the pages of the scene that its keyframes will need, while nobody waits.
void Session::prefetch(SessionScratch& scratch) {
  proto::View view = viewFor(motion_.newest().time + options_.prefetch_ahead, {});
  view.tau_px = keyframe().tau_px;
  // If the section is too large, more than enough has been read.
  (void)refine(world_->hierarchy, view, maxNodes(), scratch.send.refine, scratch.send.section);
  prefetch_pace_.begun(now_);
  did_ = Did::kPrefetch;
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

// The estimate rises at once and falls slowly, so that a plan holds for the slower of the recent keyframes.
void Session::noteComputeTime(Duration spent, uint64_t pages_read) {
  constexpr int64_t kRest = 4;  // times what a request took
  if (did_ == Did::kKeyframe && tiles_) tiles_->pace().given(now_ + spent);
  if (did_ == Did::kKeyframe) compute_time_ = std::max(spent, Duration{(compute_time_.us * 15 + spent.us) / 16});
  if (did_ == Did::kRequest) next_request_ = now_ + spent + spent * kRest;
  if (did_ == Did::kPrefetch) prefetch_pace_.ended(now_, pages_read);
  if (did_ == Did::kKeyframe) prefetch_pace_.keyframeRead(now_, pages_read);
}

}  // namespace foreland::server
