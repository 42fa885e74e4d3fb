#include "server/session/session.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "proto/codec/section_codec.h"
#include "proto/space/jump.h"
#include "server/view/ground.h"
#include "server/view/tour.h"

namespace foreland::server {

namespace {

// Poses are rounded on the wire, both ways.
constexpr Region kPoseRounding{0.01, 4e-4};
constexpr Duration kPrefetchEvery = Duration::milliseconds(500);

// A camera within this of its announced path follows it.
constexpr Region kMostOffPath{50, 0.2};
constexpr double kMostUnknownTurn_rad = 0.3;

// Where a viewer limits its bytes: what an added node costs, beyond which tolerance bytes count no more, and how long
// the first section may take on the link.
constexpr double kBitsOfNode = 10, kCoarsest_px = 200;
constexpr Duration kFirstThrough = Duration::seconds(1);

constexpr size_t kMostPredictions = 64;  // whose true poses have not arrived

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
  if (request_->keyframe_interval == Duration{}) request_->keyframe_interval = options_.keyframe_interval;
  if (first) {
    if (world_->occlusion && request.occlusion) {
      occlusion_ = std::make_unique<ViewerOcclusion>(world_->hierarchy, *world_->occlusion);
      sender_.tellBlocks();
    }
    proto::Welcome welcome = welcomeTo(world_->hierarchy);
    welcome.tau_px = request_->tau_px;
    welcome.keyframe_interval = request_->keyframe_interval;
    welcome.occlusion = occlusion_ != nullptr;
    welcome.memory_bytes = std::min(request_->memory_bytes, options_.max_memory_bytes);
    welcome.tile_bytes = std::min(request_->tile_bytes, options_.max_tile_bytes);
    if (!welcome.tile_layers.empty()) tiles_ = std::make_unique<TileSender>(world_->hierarchy, welcome.tile_bytes);
    sender_.setMemory(welcome.memory_bytes);
    replies_.push_back(proto::encode(welcome));
  }
  target_.reset();
  return {};
}

Status Session::take(const proto::Path& path, Time) {
  path_ = path;
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

// Requests are answered in steps, one at a time.
Status Session::checkRequests() const {
  if (requests_.size() < SessionOptions::kMostRequests) return {};
  return Error{ErrorCode::kLimit, "you ask for more than you read; wait for the replies to earlier requests"};
}

Status Session::take(const proto::TourRequest& request, Time) {
  if (Status known = checkTour(request.name); !known.ok()) return known;
  if (Status room = checkRequests(); !room.ok()) return room;
  requests_.emplace_back(request);
  return {};
}

Status Session::take(const proto::GroundRequest& request, Time) {
  if (Status room = checkRequests(); !room.ok()) return room;
  requests_.emplace_back(request);
  return {};
}

Bytes Session::replyTo(const proto::TourRequest& request) const {
  auto path = planTour(world_->hierarchy.scene(), request.name, request.seconds).value();
  return proto::encode(proto::TourReply{request.id, path.step, std::move(path.poses)});
}

Bytes Session::replyTo(const proto::GroundRequest& request) const {
  proto::GroundReply reply{request.id, {}};
  reply.heights_m.reserve(request.positions.size());
  for (const glm::dvec2& p : request.positions)
    reply.heights_m.push_back(static_cast<float>(
        groundHeight(world_->hierarchy.scene(), p.x, p.y).value_or(std::numeric_limits<double>::quiet_NaN())));
  return proto::encode(reply);
}

void Session::answer(std::vector<Bytes>& out) {
  out.push_back(std::visit([this](const auto& request) { return replyTo(request); }, requests_.front()));
  requests_.pop_front();
  ++statistics_.replies;
  did_ = Did::kRequest;
  unsent_ = true;
}

Status Session::take(const proto::PoseUpdate& update, Time now) {
  if (update.received_keyframe > keyframe().index)
    return Error{ErrorCode::kMalformed, "a pose update acknowledges a keyframe that was never sent"};
  // After a clock was set anew, times before it and after it cannot be compared.
  if (!clocks_.poseArrived(update.pose.time, now) || isJump(update.pose) || isTooFarAhead(update.pose.time))
    jumpTo(update.pose);
  else
    history_.add(update.pose);
  while (!predictions_.empty() && predictions_.front().time <= update.pose.time) {
    prediction_errors_.add(predictions_.front().pose, history_.at(predictions_.front().time));
    predictions_.pop_front();
  }
  if (update.received_keyframe > acknowledged_) {
    acknowledged_ = update.received_keyframe;
    while (!in_flight_.empty() && in_flight_.front().index <= acknowledged_) {
      if (in_flight_.front().index == acknowledged_) {
        clocks_.keyframeArrived(update.received_at, in_flight_.front().at);
        if (tiles_) tiles_->pace().keyframeArrived(acknowledged_, update.received_at);
      }
      in_flight_.pop_front();
    }
  }
  return {};
}

bool Session::isJump(const proto::TimedPose& pose) const {
  if (history_.empty() || pose.time <= history_.newest().time) return false;
  // The height is looked up for fast cameras only.
  if (!proto::isJump(history_.newest(), pose, 0)) return false;
  const auto height = [&](const proto::TimedPose& p) {
    return heightAboveGround(world_->hierarchy.scene(), p.pose.eye);
  };
  return proto::isJump(history_.newest(), pose, std::min(height(history_.newest()), height(pose)));
}

// Nothing known of the motion before holds after a jump. Of its speed something may, so the first keyframe is computed
// for a camera that goes on as fast as before, in any direction.
void Session::jumpTo(const proto::TimedPose& pose) {
  ++statistics_.jumps;
  if (!history_.empty() && history_.span() > Duration{}) {
    const Extrapolation motion = history_.extrapolate(proto::Predictor::kConstantVelocity);
    motion_before_jump_ = {glm::length(motion.velocity), motion.turnRate()};
  }
  history_.restart(pose);
  predictions_.clear();
  prediction_errors_ = {};
  region_share_ = {};
  if (path_ && !isPathFollowed(pose)) path_.reset();
  if (isFirst() && !isTooFarAhead(pose.time)) return;  // it starts from nothing, or from what the viewer holds
  target_.reset();
  jumped_ = true;
}

// Whether the last keyframe is for a time that no clock explains which shows `t` now: it was computed, here or before
// the viewer resumed, for a time stamp that was wrong. No keyframe could follow it for long.
bool Session::isTooFarAhead(Time t) const {
  constexpr Duration kMostAhead = Duration::seconds(5);
  return keyframe().index > 0 && keyframe().time > t + request_->keyframe_interval * 2 + kMostAhead;
}

// Whether the announced path is where the camera is.
bool Session::isPathFollowed(const proto::TimedPose& pose) const {
  const proto::TimedPose expected{pose.time, path_->at(pose.time)};
  const Region off{glm::distance(expected.pose.eye, pose.pose.eye),
                   proto::angleBetween(expected.pose.orientation, pose.pose.orientation)};
  return off.radius_m <= kMostOffPath.radius_m && off.angle_rad <= kMostOffPath.angle_rad;
}

Status Session::take(const proto::Resume& resume, Time) {
  if (!isFirst() || !history_.empty() || resumed_)
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
  aim();
}

Time Session::gridAtOrAfter(Time t) const {
  const int64_t T = request_->keyframe_interval.us;
  const int64_t steps = t.us >= 0 ? (t.us + T - 1) / T : -(-t.us / T);
  return {steps * T};
}

void Session::aim() {
  if (!request_ || history_.empty() || request_->strategy != proto::Strategy::kPredict || jumped_ || resume_) return;
  const Duration T = request_->keyframe_interval;
  // The client needs a keyframe when it reaches the grid point before it.
  const auto deadline = [&](Time t) { return clocks_.sendBy(t - T) - options_.safety; };
  if (target_ && deadline(*target_) + Duration{T.us / 2} >= now_) return;
  const Time next = isFirst() ? gridAtOrAfter(history_.newest().time) : gridAtOrAfter(keyframe().time + Duration{1});
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
  if (!request_ || history_.empty() || unsent_ || resume_ || in_flight_.size() >= options_.max_unacknowledged)
    return std::nullopt;
  // After a jump the newest pose counts at once: what is shown was computed for elsewhere.
  if (jumped_) return notTooSoon({history_.newest().time, {now_, now_}, 0});
  const Duration T = request_->keyframe_interval;
  const bool first = isFirst();
  const Time next = first ? gridAtOrAfter(history_.newest().time) : gridAtOrAfter(keyframe().time + Duration{1});
  // No more than real time has gone by, whatever the client's clock says.
  const int64_t most_skipped = (now_ - last_keyframe_at_).us / T.us + 1;
  const auto skippedTo = [&](Time t) {
    return first || t < next ? 0 : static_cast<uint64_t>(std::min((t - next).us / T.us, most_skipped));
  };

  if (request_->strategy == proto::Strategy::kPredict) {
    if (!target_) return std::nullopt;
    const Time deadline = clocks_.sendBy(*target_ - T) - options_.safety;
    Due due{deadline - compute_time_, deadline, false, compute_time_};
    if (options_.most_early > Duration{} && !first)
      due.earliest = due.release - std::min(options_.most_early, Duration{T.us / 2});
    return notTooSoon({*target_, due, skippedTo(*target_)});
  }
  // The pose of the grid point must have arrived; if those of several have, the newest one counts.
  const Time newest = history_.newest().time;
  if (first) return Plan{newest, {now_, now_}, 0};
  if (newest < next) return std::nullopt;
  const Time latest{next.us + (newest - next).us / T.us * T.us};
  return notTooSoon({latest, {now_, now_ + Duration{T.us / 2}, false, compute_time_}, skippedTo(latest)});
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
  proto::View view = viewFor(history_.newest().time + options_.prefetch_ahead);
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
  for (Bytes& reply : replies_) out.push_back(std::move(reply));
  replies_.clear();
  did_ = Did::kNothing;
  const auto next = plan();
  const auto begin = [&] {
    return start == Start::kEarly ? next->due.earliest.value_or(next->due.release) : next->due.release;
  };
  if (next && begin() <= now_) return computeKeyframe(*next, now_, scratch, out);
  if (is_greeting) return;  // which is due at once, unlike what follows
  if (resume_) return tryToResume();
  if (const auto due = requestDue(); due && due->release <= now_) return answer(out);
  if (const auto due = prefetchDue(); due && due->release <= now_) prefetch(scratch);
}

// Where the camera was, is, and is expected to be.
ExpectedMotion Session::expectedMotion() const {
  // With `delay` and `current` only the interval after the keyframe has to be predicted.
  if (request_->strategy != proto::Strategy::kPredict) return {history_, proto::Predictor::kConstantVelocity};
  if (request_->predictor == proto::Predictor::kKnownPath && path_) return ExpectedMotion(*path_);
  return {history_, request_->predictor};
}

// When a keyframe for `t` begins to be shown. The first section, and one after a jump, is shown as soon as it arrives.
Time Session::shownFrom(Time t) const {
  if (jumped_) return history_.newest().time;
  return std::min(isFirst() ? history_.newest().time : keyframe().time, t - request_->keyframe_interval);
}

// The keyframe's pose, and the region around it that the camera stays in while the section is shown.
proto::View Session::viewFor(Time t) const {
  const Duration T = request_->keyframe_interval;
  const ExpectedMotion motion = expectedMotion();
  proto::View view{motion.at(t), request_->lens, request_->tau_px};
  const Region region =
                   region_share_.of(regionOf(view.pose, motion, shownFrom(t), t + T), prediction_errors_.estimate()),
               unknown = unknownMotion(t + T - history_.newest().time);
  // Floats, as in the keyframe's header.
  view.region_radius_m = static_cast<float>(region.radius_m + unknown.radius_m + kPoseRounding.radius_m);
  view.region_angle_rad = static_cast<float>(region.angle_rad + unknown.angle_rad + kPoseRounding.angle_rad);
  return view;
}

// How far the camera may go in `time` while, after a jump, its poses do not tell its velocity yet.
Region Session::unknownMotion(Duration time) const {
  if (history_.span() >= PoseHistory::kBaseline) return {};
  const double s = jumped_ ? kShownAfterJump * request_->keyframe_interval.toSeconds() : time.toSeconds();
  return {motion_before_jump_.radius_m * s, std::min(motion_before_jump_.angle_rad * s, kMostUnknownTurn_rad)};
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
  const Duration allowed = sender_.startsFromNothing() ? kFirstThrough : request_->keyframe_interval;
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
  const double wanted_px = static_cast<float>(tolerance_.next(request_->tau_px, budget));
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
    visibility->expect(outlookOf(expectedMotion(), shownFrom(plan.time_client),
                                 plan.time_client + request_->keyframe_interval, request_->keyframe_interval,
                                 prediction_errors_.estimate().radius_m + kPoseRounding.radius_m));
  return sender_.send(view, plan.time_client, max_nodes, scratch.send, message, visibility);
}

void Session::computeKeyframe(const Plan& plan, Time now, SessionScratch& scratch, std::vector<Bytes>& out) {
  const double interval_s =
      isFirst() || jumped_ ? request_->keyframe_interval.toSeconds() : (plan.time_client - keyframe().time).toSeconds();
  if (jumped_) {
    sender_.restart();
    tolerance_.restart();
  }
  const proto::View view = viewFor(plan.time_client);
  if (const proto::Epochs& epochs = world_->hierarchy.epochs().epochs(); !epochs.empty())
    sender_.showAt(scene_time_.next(epochs, plan.time_client));
  Bytes message;
  // The second one starts from nothing, and so is as large as it was measured.
  if (!sendKeyframe(view, plan, mostNodes(), scratch, message))
    CHECK_TRUE(sendKeyframe(view, plan, std::numeric_limits<size_t>::max(), scratch, message));
  tolerance_.observe(sender_.triangles(), static_cast<double>(message.size()), interval_s);
  out.push_back(std::move(message));
  sendTiles(plan.time_client, view, interval_s, out);
  observeRegion(scratch);

  unsent_ = true;
  keyframe_before_last_at_ = isFirst() ? now - request_->keyframe_interval : last_keyframe_at_;
  last_keyframe_at_ = now;
  did_ = Did::kKeyframe;
  was_after_jump_ = std::exchange(jumped_, false);
  target_.reset();
  aim();
  in_flight_.push_back({keyframe().index, now});
  if (plan.time_client > history_.newest().time) predictions_.push_back({plan.time_client, view.pose});
  if (predictions_.size() > kMostPredictions) predictions_.pop_front();
  statistics_.keyframes += 1;
  statistics_.skipped_keyframes += plan.skipped;
  statistics_.nodes_added += scratch.send.delta.added.size();
  statistics_.nodes_removed += scratch.send.delta.removed.size();
  statistics_.tau_px = keyframe().tau_px;
  statistics_.is_coarse = keyframe().tau_px > 1.001 * request_->tau_px;  // it is a float
  statistics_.nodes_tested = sender_.adapter().testCount();
  statistics_.section_nodes = sender_.nodeCount();
  statistics_.remembered_nodes = sender_.adapter().memory().pages.knownCount();
  statistics_.memory_bytes = sender_.adapter().memory().pages.bytes();
}

// Tiles follow the keyframe that shows them, and those for where the camera will be in the next seconds, one of them
// each time.
void Session::sendTiles(Time t_client, const proto::View& view, double interval_s, std::vector<Bytes>& out) {
  constexpr int64_t kSecondsAhead = 3;
  if (!tiles_ || !(request_->relief || request_->imagery)) return;
  const Time later = t_client + Duration::seconds(1 + keyframe().index % kSecondsAhead);
  const std::array<proto::View, 2> views{view, proto::View{expectedMotion().at(later), view.lens, view.tau_px}};
  tiles_->choose(keyframe().index, views, *request_);
  tiles_->pace().keyframeSent(keyframe().index, now_, interval_s, request_->max_bytes_per_second);
  tiles_->take(out);
  statistics_.tiles = tiles_->statistics().tiles;
  statistics_.tile_bytes = tiles_->statistics().bytes;
}

// How much the region makes of the section. Along an announced path the region is not reduced: there it is no guess.
void Session::observeRegion(SessionScratch& scratch) {
  const bool is_guess = request_->strategy == proto::Strategy::kPredict &&
                        !(request_->predictor == proto::Predictor::kKnownPath && path_);
  if (!is_guess || !region_share_.isDue()) return;
  proto::View pose_alone = proto::viewOf(keyframe());
  pose_alone.region_radius_m = pose_alone.region_angle_rad = 0;
  const SectionSize size = sender_.measure(pose_alone, sender_.nodeCount() + 1, scratch.send);
  statistics_.nodes_measured += size.nodes;
  region_share_.observe(sender_.nodeCount(), size.nodes);
}

// The estimate rises at once and falls slowly, so that a plan holds for the slower of the recent keyframes.
void Session::noteComputeTime(Duration spent) {
  constexpr int64_t kRest = 4;  // times what a request took
  if (did_ == Did::kKeyframe) compute_time_ = std::max(spent, Duration{(compute_time_.us * 15 + spent.us) / 16});
  if (did_ == Did::kRequest) next_request_ = now_ + spent + spent * kRest;
}

}  // namespace foreland::server
