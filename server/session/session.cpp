#include "server/session/session.h"

#include <algorithm>
#include <limits>

#include "proto/codec/section_codec.h"
#include "server/view/ground.h"
#include "server/view/tour.h"

namespace foreland::server {

namespace {

// Poses are rounded on the wire, both ways.
constexpr Region kPoseRounding{0.01, 4e-4};
constexpr Duration kPrefetchEvery = Duration::milliseconds(500);

// Where a viewer limits its bytes: what an added node costs, beyond which tolerance bytes count no more, and how long
// the first section may take on the link.
constexpr double kBitsOfNode = 10, kCoarsest_px = 200;
constexpr Duration kFirstThrough = Duration::seconds(1);

// By which factor the tolerance rises while a section has too many nodes for the server, the viewer, or the link.
constexpr double kCoarserForServer = 2, kCoarserForViewer = 1.15, kCoarserForLink = 1.3;

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

Status Session::take(const proto::TourRequest& request, Time) {
  auto path = planTour(world_->hierarchy.scene(), request.name, request.seconds);
  if (!path) return path.error();
  replies_.push_back(proto::encode(proto::TourReply{request.id, path->step, std::move(path->poses)}));
  return {};
}

Status Session::take(const proto::GroundRequest& request, Time) {
  proto::GroundReply reply{request.id, {}};
  reply.heights_m.reserve(request.positions.size());
  for (const glm::dvec2& p : request.positions)
    reply.heights_m.push_back(static_cast<float>(
        groundHeight(world_->hierarchy.scene(), p.x, p.y).value_or(std::numeric_limits<double>::quiet_NaN())));
  replies_.push_back(proto::encode(reply));
  return {};
}

Status Session::take(const proto::PoseUpdate& update, Time now) {
  if (update.received_keyframe > keyframe().index)
    return Error{ErrorCode::kMalformed, "a pose update acknowledges a keyframe that was never sent"};
  history_.add(update.pose);
  while (!predictions_.empty() && predictions_.front().time <= update.pose.time) {
    prediction_errors_.add(predictions_.front().pose, history_.at(predictions_.front().time));
    predictions_.pop_front();
  }
  clocks_.poseArrived(update.pose.time, now);
  if (update.received_keyframe > acknowledged_) {
    acknowledged_ = update.received_keyframe;
    while (!in_flight_.empty() && in_flight_.front().index <= acknowledged_) {
      if (in_flight_.front().index == acknowledged_) clocks_.keyframeArrived(update.received_at, in_flight_.front().at);
      in_flight_.pop_front();
    }
  }
  return {};
}

// A section that cannot be resumed from is no mistake of the viewer's: it is sent a whole section then.
Status Session::take(const proto::Resume& resume, Time) {
  if (!isFirst() || !history_.empty())
    return Error{ErrorCode::kMalformed, "a client resumes before its first pose, or not at all"};
  const Hierarchy& hierarchy = world_->hierarchy;
  if (resume.scene_id != hierarchy.scene().id()) return {};
  const auto sections =
      proto::decodeSections(hierarchy.grid(), hierarchy.objects().set, resume.section, options_.max_section_nodes);
  if (!sections.ok() || proto::fingerprint(*sections) != resume.fingerprint) return {};
  if (!sender_.resume(*sections, resume.keyframe, resume.time, resume.fingerprint)) return {};
  acknowledged_ = resume.keyframe;
  statistics_.resumed = true;
  return {};
}

Time Session::gridAtOrAfter(Time t) const {
  const int64_t T = request_->keyframe_interval.us;
  const int64_t steps = t.us >= 0 ? (t.us + T - 1) / T : -(-t.us / T);
  return {steps * T};
}

void Session::aim() {
  if (!request_ || history_.empty() || request_->strategy != proto::Strategy::kPredict) return;
  const Duration T = request_->keyframe_interval;
  // The client needs a keyframe when it reaches the grid point before it.
  const auto deadline = [&](Time t) { return clocks_.sendBy(t - T) - options_.safety; };
  if (target_ && deadline(*target_) + Duration{T.us / 2} >= now_) return;
  const Time next = isFirst() ? gridAtOrAfter(history_.newest().time) : gridAtOrAfter(keyframe().time + Duration{1});
  const Duration behind = now_ + compute_time_ - deadline(next);
  target_ = behind > Duration{} ? gridAtOrAfter(next + behind) : next;
}

std::optional<Session::Plan> Session::plan() const {
  if (!request_ || history_.empty() || unsent_ || in_flight_.size() >= options_.max_unacknowledged) return std::nullopt;
  const Duration T = request_->keyframe_interval;
  const bool first = isFirst();
  const Time next = first ? gridAtOrAfter(history_.newest().time) : gridAtOrAfter(keyframe().time + Duration{1});
  const auto skippedTo = [&](Time t) { return first || t < next ? 0 : static_cast<uint64_t>((t - next).us / T.us); };

  if (request_->strategy == proto::Strategy::kPredict) {
    if (!target_) return std::nullopt;
    const Time deadline = clocks_.sendBy(*target_ - T) - options_.safety;
    return Plan{*target_, {deadline - compute_time_, deadline}, skippedTo(*target_)};
  }
  // The pose of the grid point must have arrived; if those of several have, the newest one counts.
  const Time newest = history_.newest().time;
  if (first) return Plan{newest, {now_, now_}, 0};
  if (newest < next) return std::nullopt;
  const Time latest{next.us + (newest - next).us / T.us * T.us};
  return Plan{latest, {now_, now_ + Duration{T.us / 2}}, skippedTo(latest)};
}

std::optional<Session::Due> Session::due() const {
  if (!replies_.empty()) return Due{now_, now_};
  const auto prefetch = prefetchDue();
  if (const auto p = plan()) return prefetch && prefetch->release < p->due.release ? prefetch : p->due;
  return prefetch;
}

// Its deadline is half a second later, so that keyframes are preferred.
std::optional<Session::Due> Session::prefetchDue() const {
  if (options_.prefetch_ahead == Duration{} || isFirst()) return std::nullopt;
  return Due{next_prefetch_, next_prefetch_ + kPrefetchEvery};
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

void Session::step(Time now, SessionScratch& scratch, std::vector<Bytes>& out) {
  now_ = std::max(now_, now);
  for (Bytes& reply : replies_) out.push_back(std::move(reply));
  replies_.clear();
  const auto next = plan();
  if (next && next->due.release <= now_) return computeKeyframe(*next, now_, scratch, out);
  if (const auto due = prefetchDue(); due && due->release <= now_) prefetch(scratch);
}

// Where the camera was, is, and is expected to be.
ExpectedMotion Session::expectedMotion() const {
  // With `delay` and `current` only the interval after the keyframe has to be predicted.
  if (request_->strategy != proto::Strategy::kPredict) return {history_, proto::Predictor::kConstantVelocity};
  if (request_->predictor == proto::Predictor::kKnownPath && path_) return ExpectedMotion(*path_);
  return {history_, request_->predictor};
}

// When a keyframe for `t` begins to be shown. The first section is shown as soon as it arrives.
Time Session::shownFrom(Time t) const {
  return std::min(isFirst() ? history_.newest().time : keyframe().time, t - request_->keyframe_interval);
}

// The keyframe's pose, and the region around it that the camera stays in while the section is shown.
proto::View Session::viewFor(Time t) const {
  const Duration T = request_->keyframe_interval;
  const ExpectedMotion motion = expectedMotion();
  proto::View view{motion.at(t), request_->lens, request_->tau_px};
  const Region region = regionOf(view.pose, motion, shownFrom(t), t + T), error = prediction_errors_.estimate();
  // Floats, as in the keyframe's header.
  view.region_radius_m = static_cast<float>(region.radius_m + error.radius_m + kPoseRounding.radius_m);
  view.region_angle_rad = static_cast<float>(region.angle_rad + error.angle_rad + kPoseRounding.angle_rad);
  return view;
}

// A mesh has four triangles a root and two a node; the union of two sections is a little larger.
size_t Session::mostNodes() const {
  if (request_->max_triangles == 0) return options_.max_section_nodes;
  const proto::GridShape& shape = world_->hierarchy.grid().shape();
  const double nodes = 0.5 * (0.97 * request_->max_triangles - 4.0 * shape.roots_x * shape.roots_y);
  return std::min(options_.max_section_nodes, static_cast<size_t>(std::max(1.0, nodes)));
}

// Sets the tolerance that the viewer's budget allows, and a coarser one if the section would still be too large for the
// viewer or the link. One refinement answers both questions, and is all that is done in most keyframes.
void Session::fitBudget(proto::View& view, SessionScratch& scratch) {
  const size_t most_nodes = mostNodes();
  std::optional<std::pair<double, SectionSize>> last;  // tolerance and size of the section that was measured last
  const auto sizeAt = [&](double tau_px) {
    if (last && last->first == tau_px) return last->second;
    view.tau_px = tau_px;
    last = {tau_px, sender_.measure(view, most_nodes, scratch.send)};
    return last->second;
  };
  double tau_px =
      static_cast<float>(tolerance_.next(request_->tau_px, {request_->max_triangles, request_->max_bytes_per_second}));
  view.tau_px = tau_px;
  if (!sender_.fitsSurely(view, most_nodes))
    tau_px = raiseUntil(tau_px, request_->max_triangles > 0 ? kCoarserForViewer : kCoarserForServer,
                        [&](double tau) { return sizeAt(tau).fits; });
  if (request_->max_bytes_per_second > 0)
    tau_px = raiseUntil(tau_px, kCoarserForLink, [&](double tau) {
      return tau >= kCoarsest_px || static_cast<double>(sizeAt(tau).added) <= mostAdded();
    });
  view.tau_px = tau_px;
  tolerance_.force(tau_px);
}

// How many nodes may be added before the delta takes the link longer than an interval, which would make this keyframe
// late, and the next ones.
double Session::mostAdded() const {
  const Duration allowed = isFirst() ? kFirstThrough : request_->keyframe_interval;
  return 8.0 * request_->max_bytes_per_second * allowed.toSeconds() / kBitsOfNode;
}

void Session::computeKeyframe(const Plan& plan, Time now, SessionScratch& scratch, std::vector<Bytes>& out) {
  const double interval_s =
      isFirst() ? request_->keyframe_interval.toSeconds() : (plan.time_client - keyframe().time).toSeconds();
  proto::View view = viewFor(plan.time_client);
  fitBudget(view, scratch);
  Bytes message;
  ViewerOcclusion* const visibility = request_->occlusion ? occlusion_.get() : nullptr;
  if (visibility)
    visibility->expect(ViewerOcclusion::sweepsAhead(
        expectedMotion(), shownFrom(plan.time_client), plan.time_client + request_->keyframe_interval,
        request_->keyframe_interval, prediction_errors_.estimate().radius_m + kPoseRounding.radius_m));
  sender_.send(view, plan.time_client, scratch.send, message, visibility);
  const size_t nodes = sender_.adapter().nodeCount();
  tolerance_.observe(sender_.triangles(), static_cast<double>(message.size()), interval_s);
  out.push_back(std::move(message));

  unsent_ = true;
  target_.reset();
  aim();
  in_flight_.push_back({keyframe().index, now});
  if (plan.time_client > history_.newest().time) predictions_.push_back({plan.time_client, view.pose});
  statistics_.keyframes += 1;
  statistics_.skipped_keyframes += plan.skipped;
  statistics_.nodes_added += scratch.send.delta.added.size();
  statistics_.nodes_removed += scratch.send.delta.removed.size();
  statistics_.section_nodes = nodes;
  statistics_.remembered_nodes = sender_.adapter().memory().pages.knownCount();
  statistics_.memory_bytes = sender_.adapter().memory().pages.bytes();
}

// The estimate rises at once and falls slowly, so that a plan holds for the slower of the recent keyframes.
void Session::noteComputeTime(Duration spent) {
  compute_time_ = std::max(spent, Duration{(compute_time_.us * 15 + spent.us) / 16});
}

}  // namespace foreland::server
