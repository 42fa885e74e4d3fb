#include "server/session/session.h"

#include <algorithm>
#include <utility>

#include "proto/codec/section_codec.h"

namespace foreland::server {

Session::Session(std::shared_ptr<const World> world, const SessionOptions& options)
    : world_(std::move(world)), options_(options), sender_(world_->hierarchy) {
  if (options_.foresee) input_.motion().foreseeBy(options_.foresee());
}

Status Session::receive(ByteSpan bytes, Time now) {
  advance(now);
  const auto message = input_.decode(bytes);
  if (!message.ok()) return message.error();
  const Status status = std::visit([&](const auto& m) { return take(m, now); }, *message);
  aim();
  return status;
}

void Session::onDrained(Time now) {
  advance(now);
  unsent_ = false;
  if (tiles_) tiles_->pace().drained(state_.now);
  aim();
}

Status Session::take(const proto::ViewRequest& asked, Time) {
  const bool is_first = !input_.hasGreeted();
  input_.take(asked, {options_.tau_px, options_.keyframe_interval, options_.longest_interval});
  const proto::ViewRequest& request = input_.request();
  state_.grid = request.keyframe_interval;
  state_.order = request.order;
  state_.predicts = request.strategy == proto::Strategy::kPredict;
  state_.interval = std::clamp(state_.interval, input_.bounds().shortest, input_.bounds().most());
  target_.reset();
  if (is_first) replies_.push_back(proto::encode(welcome()));
  return {};
}

// What the first view request is answered with. Makes what the viewer asks for and the scene has.
proto::Welcome Session::welcome() {
  const proto::ViewRequest& request = input_.request();
  if (world_->occlusion && options_.occlusion != Occlusion::kOff && request.occlusion) {
    occlusion_ = std::make_unique<ViewerOcclusion>(world_->hierarchy, *world_->occlusion);
    sender_.signalBlocks();
  }
  proto::Welcome welcome = welcomeTo(world_->hierarchy);
  welcome.tau_px = request.tau_px;
  welcome.keyframe_interval = request.keyframe_interval;
  welcome.longest_interval = request.longest_interval;
  welcome.occlusion = occlusion_ != nullptr;
  welcome.memory_bytes = std::min(request.memory_bytes, options_.max_memory_bytes);
  welcome.tile_bytes = std::min(request.tile_bytes, options_.max_tile_bytes);
  if (!welcome.tile_layers.empty())
    tiles_ = std::make_unique<TileSender>(world_->hierarchy, world_->ground, welcome.tile_bytes);
  sender_.setMemory(welcome.memory_bytes);
  return welcome;
}

Status Session::take(const proto::Path& path, Time) {
  input_.take(path);
  return {};
}

Status Session::take(const proto::HeldTiles& held, Time) {
  if (!state_.isFirst() || !tiles_ || tiles_->statistics().tiles > 0)
    return Error{ErrorCode::kMalformed, "a client tells the tiles that it holds before its first pose, or not at all"};
  return tiles_->hold(held);
}

Status Session::take(const proto::SceneClock& clock, Time) {
  input_.take(clock);
  return {};
}

Status Session::take(const proto::TourRequest& request, Time) {
  return input_.take(request, world_->hierarchy.scene());
}

Status Session::take(const proto::GroundRequest& request, Time) { return input_.take(request); }

Status Session::take(const proto::SightRequest& request, Time) { return input_.take(request); }

Status Session::take(const proto::ViewshedRequest& request, Time) { return input_.take(request); }

Status Session::take(const proto::RequestCancel& request, Time) {
  input_.take(request);
  return {};
}

Status Session::take(const proto::Resume& resume, Time) { return input_.take(resume, state_.isFirst()); }

size_t Session::keptBytes() const {
  size_t bytes = input_.keptBytes();
  for (const Bytes& reply : replies_) bytes += reply.size();
  return bytes;
}

void Session::answer(std::vector<Bytes>& out) {
  constexpr Duration kUntilPrepared = Duration::milliseconds(20);
  SightSlice reply = input_.requests().answer({world_->hierarchy.scene(), *world_->sight, *world_->tours, state_.now});
  did_ = Did::kRequest;
  if (reply.is_preparing) postponeReplies(state_.now + kUntilPrepared);
  if (!reply.message) return;
  out.push_back(std::move(*reply.message));
  ++statistics_.replies;
  unsent_ = true;
}

// The time of the last keyframe that the viewer holds, from this connection or from the one that it resumed.
std::optional<Time> Session::heldKeyframe() const {
  return keyframe().index > 0 ? std::optional(keyframe().time) : std::nullopt;
}

Status Session::take(const proto::PoseUpdate& update, Time now) {
  if (update.received_keyframe > keyframe().index)
    return Error{ErrorCode::kMalformed, "a pose update acknowledges a keyframe that was never sent"};
  const bool has_jumped = input_.take(update, now, state_.now, world_->hierarchy.scene(), heldKeyframe());
  state_.newest_client = input_.motion().newest().time;
  if (has_jumped) {
    ++statistics_.jumps;
    adaptive_interval_.restart();
    // Before the first keyframe a jump changes nothing: it starts from nothing, or from what the viewer holds.
    if (!state_.isFirst() || input_.isTooFarAhead(heldKeyframe(), state_.now)) {
      target_.reset();
      state_.has_jumped = true;
    }
  }
  if (update.received_keyframe > acknowledged_) acknowledge(update);
  return {};
}

void Session::acknowledge(const proto::PoseUpdate& update) {
  acknowledged_ = update.received_keyframe;
  while (!in_flight_.empty() && in_flight_.front().index <= acknowledged_) {
    if (in_flight_.front().index == acknowledged_) {
      input_.clocks().keyframeArrived(update.received_at, in_flight_.front().at);
      if (tiles_) tiles_->pace().keyframeArrived(acknowledged_, update.received_at, input_.clocks().roundTrip());
    }
    in_flight_.pop_front();
  }
}

// A section that cannot be resumed from is no mistake of the viewer's: it is sent a whole section then.
void Session::tryToResume() {
  const proto::Resume resume = input_.takeResume();
  did_ = Did::kRequest;
  const Hierarchy& hierarchy = world_->hierarchy;
  if (resume.scene_id != hierarchy.scene().id()) return;
  const auto sections =
      proto::decodeSections(hierarchy.grid(), hierarchy.objects().set, resume.section, options_.max_section_nodes);
  if (!sections.ok() || proto::fingerprint(*sections) != resume.fingerprint) return;
  if (!sender_.resume(*sections, resume.keyframe, resume.time, resume.fingerprint)) return;
  acknowledged_ = resume.keyframe;
  statistics_.resumed = true;
  if (hasPose() && input_.isTooFarAhead(heldKeyframe(), state_.now)) state_.has_jumped = true;
  aim();
}

// With `predict`: chooses the grid point that the next keyframe is for.
void Session::aim() {
  if (hasPose() && state_.predicts && !state_.has_jumped && !input_.isResuming())
    target_ = targetOf(state_, input_.clocks(), options_.safety, target_);
}

std::optional<KeyframePlan> Session::plan() const {
  if (!canSee() || unsent_ || input_.isResuming() || in_flight_.size() >= options_.max_unacknowledged)
    return std::nullopt;
  return planKeyframe(state_, input_.clocks(), {options_.safety, options_.max_early, options_.slack}, target_);
}

std::optional<Due> Session::due() const {
  if (!replies_.empty()) return Due{state_.now, state_.now};
  std::optional<Due> first;
  const auto consider = [&](const std::optional<Due>& due) {
    if (due && (!first || due->release < first->release)) first = due;
  };
  if (const auto p = plan()) consider(p->due);
  consider(requestDue());
  consider(prefetchDue());
  consider(comparisonDue());
  return first;
}

// After keyframes, which viewers wait for.
std::optional<Due> Session::requestDue() const {
  constexpr Duration kUntilResumed = Duration::milliseconds(200);
  if (input_.isResuming()) return Due{state_.now, state_.now + kUntilResumed, true};
  if (input_.requests().empty() || unsent_) return std::nullopt;
  const Time release = std::max(state_.now, next_request_);
  return Due{release, release + input_.requests().patience(), true};
}

// Its deadline is half a second later, so that keyframes are preferred. Where processors are short it is shed first.
std::optional<Due> Session::prefetchDue() const {
  if (options_.prefetch_ahead == Duration{} || state_.isFirst() || !canSee() || processors_ != Processors::kFree)
    return std::nullopt;
  return Due{prefetch_pace_.next(), prefetch_pace_.next() + PrefetchPace::kMin, true};
}

// Refining for where the viewer will be reads the pages of the scene that its keyframes will need, while nobody waits.
void Session::prefetch(SessionScratch& scratch) {
  const Time later = input_.motion().newest().time + options_.prefetch_ahead;
  proto::View view = viewFor(input_.motion(), input_.request(), keyframe().tau_px, later, {});
  view.tau_px = keyframe().tau_px;
  // If the section is too large, more than enough has been read.
  if (HeldPages* pages = sender_.pages())
    pages->expect(view, maxNodes(), scratch.send.refine, scratch.send.section);
  else
    (void)refine(world_->hierarchy, view, maxNodes(), scratch.send.refine, scratch.send.section);
  prefetch_pace_.begun(state_.now);
  did_ = Did::kPrefetch;
  ++statistics_.prefetches;
}

void Session::step(Time now, SessionScratch& scratch, std::vector<Bytes>& out, Start start) {
  advance(now);
  const bool is_greeting = !replies_.empty();
  for (Bytes& reply : std::exchange(replies_, {})) out.push_back(std::move(reply));
  did_ = Did::kNothing;
  const auto next = plan();
  if (next &&
      (start == Start::kEarly ? next->due.earliest.value_or(next->due.release) : next->due.release) <= state_.now)
    return computeKeyframe(*next, scratch, out);
  if (is_greeting) return;  // which is due at once, unlike what follows
  if (input_.isResuming()) return tryToResume();
  if (const auto due = requestDue(); due && due->release <= state_.now) return answer(out);
  if (const auto due = prefetchDue(); due && due->release <= state_.now) return prefetch(scratch);
  if (comparisonDue()) compareOcclusion(scratch);
}

// The estimate rises at once and falls slowly, so that a plan holds for the slower of the recent keyframes.
void Session::noteComputeTime(Duration spent, uint64_t pages_read) {
  constexpr int64_t kRest = 4;  // times what a request took
  if (did_ == Did::kKeyframe && tiles_) tiles_->pace().given(state_.now + spent);
  if (did_ == Did::kKeyframe && occlusion_)
    occlusion_control_.observe(
        spent, statistics_.occlusion_time - std::exchange(occlusion_observed_, statistics_.occlusion_time),
        occlusion_->hidesAnything());
  if (did_ == Did::kKeyframe)
    state_.compute_time = std::max(spent, Duration{(state_.compute_time.us * 15 + spent.us) / 16});
  if (did_ == Did::kRequest) postponeReplies(state_.now + spent + spent * kRest);
  const size_t lacking = sender_.pages() ? sender_.pages()->expected() : 0;  // is read from the store
  if (did_ == Did::kPrefetch) prefetch_pace_.ended(state_.now, pages_read + lacking);
  if (did_ == Did::kKeyframe) prefetch_pace_.keyframeRead(state_.now, pages_read);
}

}  // namespace foreland::server
