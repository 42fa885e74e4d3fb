#include "client/fly/player.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace foreland::client {

namespace {

const char* waitedFor(Player::Phase phase) {
  switch (phase) {
    case Player::Phase::kGreeting:
      return "a welcome";
    case Player::Phase::kPlanning:
      return "the tour or the ground heights";
    default:
      return "the first keyframe";
  }
}

// Where the camera was, between the frames that were drawn and at even steps.
proto::Path steeredPath(const FlightLog& log) {
  std::vector<const FlightLog::Entry*> frames;
  for (const FlightLog::Entry& entry : log.entries)
    if (entry.what == FlightLog::What::kSteered) frames.push_back(&entry);
  if (frames.empty()) return {};
  proto::Path path{.start = frames.front()->time, .step = Duration{16'667}, .poses = {}};
  const Duration flown = frames.back()->time - path.start;
  path.step = std::max(path.step, Duration{flown.us / static_cast<int64_t>(proto::Path::kMaxPoses - 2) + 1});
  size_t next = 0;
  for (Time at = path.start; path.poses.size() < 2 || path.end() < frames.back()->time; at = at + path.step) {
    while (next + 1 < frames.size() && frames[next]->time < at) ++next;
    const FlightLog::Entry &to = *frames[next], &from = *frames[next > 0 ? next - 1 : 0];
    const double between = static_cast<double>((to.time - from.time).us);
    const double share = between > 0 ? std::clamp(static_cast<double>((at - from.time).us) / between, 0.0, 1.0) : 1;
    path.poses.push_back({glm::mix(from.pose.eye, to.pose.eye, share),
                          glm::normalize(glm::slerp(from.pose.orientation, to.pose.orientation, share))});
  }
  return path;
}

}  // namespace

Player::Player(PlayerOptions options, proto::Path flown)
    : log_{.options = std::move(options), .entries = {}},
      viewer_(log_.options.request, log_.options.blend),
      path_(std::move(flown)) {
  if (!log_.options.has_meshes) viewer_.leaveMeshesEmpty();
}

Status Player::receive(ByteSpan message, Time now) {
  log_.entries.push_back(
      {.time = now, .what = FlightLog::What::kMessage, .message = Bytes(message.begin(), message.end())});
  const uint32_t before = viewer_.statistics().keyframes;
  const Status status = viewer_.receive(message, now);
  countGap(now, before);
  return status;
}

void Player::countGap(Time now, uint32_t keyframes_before) {
  if (viewer_.statistics().keyframes == keyframes_before) return;
  if (phase_ == Phase::kFlying && keyframes_before > 0)
    report_.longest_gap = std::max(report_.longest_gap, now - keyframe_at_);
  keyframe_at_ = now;
}

void Player::reconnect(Time now) {
  if (phase_ == Phase::kDone) return;
  log_.entries.push_back({.time = now, .what = FlightLog::What::kReconnect});
  viewer_.reconnect(now);
  if (phase_ == Phase::kStanding || phase_ == Phase::kFlying) return;
  ground_m_.clear();
  enter(Phase::kGreeting, now);
}

Status Player::frame(Time now) {
  log_.entries.push_back({.time = now, .what = FlightLog::What::kFrame});
  if (!phase_start_) phase_start_ = now;
  if (phase_ == Phase::kGreeting && viewer_.isGreeted()) {
    enter(Phase::kPlanning, now);
    if (Status s = plan(); !s.ok()) return s;
  }
  if (phase_ == Phase::kPlanning)
    if (Status s = takePlan(now); !s.ok()) return s;
  if (phase_ == Phase::kStanding || phase_ == Phase::kFlying) {
    if (jumps_) tellJump(now);
    view_ = viewer_.frame(now, camera(now));
    if (phase_ == Phase::kStanding && now >= path_.start) {
      before_flight_ = viewer_.statistics();
      enter(Phase::kFlying, now);
    }
    if (phase_ == Phase::kFlying) {
      if (jumps_) countJump(now);
      report_.seconds = std::max(0.0, (std::min(now, path_.end()) - path_.start).toSeconds());
      countFrame();
    }
    if (now >= path_.end()) enter(Phase::kDone, now);
  }
  return checkTimeout(now);
}

void Player::steer(Time now, const proto::Pose& pose) {
  log_.entries.push_back({.time = now, .what = FlightLog::What::kSteered, .pose = pose});
  if (phase_ == Phase::kGreeting) {
    if (!viewer_.isGreeted()) return;
    enter(Phase::kFlying, now);
  }
  view_ = viewer_.frame(now, pose);
  report_.seconds = (now - *phase_start_).toSeconds();
  countFrame();
}

void Player::jump(Time now) {
  log_.entries.push_back({.time = now, .what = FlightLog::What::kJump});
  viewer_.jump();
}

void Player::choose(Time now, const ViewChoice& choice) {
  log_.entries.push_back(
      {.time = now, .what = FlightLog::What::kChoice, .choice = std::make_shared<const ViewChoice>(choice)});
  viewer_.setRequest(choice.request);
  viewer_.setBlend(choice.blend);
}

void Player::enter(Phase phase, Time now) {
  phase_ = phase;
  phase_start_ = now;
}

// While flying there is no timeout: how late the server is stands in the report.
Status Player::checkTimeout(Time now) const {
  const bool flies_blind = phase_ == Phase::kFlying && view_.mesh == nullptr && viewer_.statistics().keyframes == 0;
  if (phase_ != Phase::kGreeting && phase_ != Phase::kPlanning && !flies_blind) return {};
  if (now - *phase_start_ <= log_.options.timeout) return {};
  return Error{ErrorCode::kIo, std::string("the server sent no answer: waited ") +
                                   std::to_string(log_.options.timeout.us / 1'000'000) + " s for " + waitedFor(phase_)};
}

Status Player::plan() {
  const PlayerOptions& o = log_.options;
  if (o.scene && viewer_.welcome()->epochs.empty())
    return Error{ErrorCode::kInvalidArgument, "this scene does not change in time: fly it without a scene time"};
  if (!o.track && o.tour == "jumps") return planJumps();
  if (!o.track) {
    viewer_.requestTour(o.tour, o.seconds);
    return {};
  }
  const proto::Welcome& welcome = *viewer_.welcome();
  Result<PlannedTrack> planned = planTrack(*o.track, viewer_.frameGrid().transform(), welcome.shape, o.track_options);
  if (!planned.ok()) return planned.error();
  planned_ = std::move(planned).value();
  note(planned_.notes);
  askGround();
  return {};
}

void Player::askGround() {
  const std::vector<glm::dvec2>& all = groundPositions();
  const size_t from = ground_m_.size(), to = std::min(all.size(), from + proto::kMaxGroundPoints);
  viewer_.requestGround({all.begin() + static_cast<ptrdiff_t>(from), all.begin() + static_cast<ptrdiff_t>(to)});
}

Status Player::takePlan(Time now) {
  if (hasGroundToAsk()) return takeGround(now);
  std::optional<proto::TourReply> tour = viewer_.takeTour();
  if (!tour) return {};
  return setPath({.start = {}, .step = tour->step, .poses = std::move(tour->poses)}, now);
}

Status Player::takeGround(Time now) {
  std::optional<proto::GroundReply> ground = viewer_.takeGround();
  if (!ground) return {};
  ground_m_.insert(ground_m_.end(), ground->heights_m.begin(), ground->heights_m.end());
  if (viewer_.welcome()->vertical.zero_surface == proto::ZeroSurface::kEllipsoid)
    planned_.undulations_m.insert(planned_.undulations_m.end(), ground->undulations_m.begin(),
                                  ground->undulations_m.end());
  if (!ground->heights_m.empty() && ground_m_.size() < groundPositions().size()) {
    askGround();
    return {};
  }
  if (jumps_) return startJumps(now);
  Result<TrackPath> path =
      pathOverGround(planned_, viewer_.frameGrid().transform(), ground_m_, log_.options.track_options);
  if (!path.ok()) return path.error();
  note(path->notes);
  return setPath(std::move(path->path), now);
}

Status Player::planJumps() {
  const proto::Welcome& welcome = *viewer_.welcome();
  Result<JumpTour> tour = JumpTour::plan(viewer_.frameGrid().transform(), welcome.shape, log_.options.seconds);
  if (!tour.ok()) return tour.error();
  jumps_ = std::move(tour).value();
  askGround();
  return {};
}

Status Player::startJumps(Time now) {
  jumps_->setGround(ground_m_);
  const proto::Pose pose = jumps_->at({});
  path_ = {.start = now + log_.options.standing, .step = jumps_->length(), .poses = {pose, pose}};
  startScene();
  enter(Phase::kStanding, now);
  return {};
}

void Player::startScene() {
  if (const auto& scene = log_.options.scene) viewer_.setSceneClock({path_.start, scene->scene_time, scene->rate});
}

proto::Pose Player::camera(Time now) const { return jumps_ ? jumps_->at(now - path_.start) : path_.at(now); }

void Player::tellJump(Time now) {
  const size_t view = jumps_->viewAt(now - path_.start);
  if (view != std::exchange(flown_view_, view)) viewer_.jump();
}

// With `delay` the camera's view from before the jump may still be shown.
void Player::countJump(Time now) {
  const Duration t = now - path_.start;
  if (t >= jumps_->length()) return;
  const size_t view = jumps_->viewAt(t);
  const Time jump = path_.start + JumpTour::kEvery * static_cast<int64_t>(view);
  const bool shows_view = view_.mesh && glm::distance(view_.pose.eye, jumps_->at(t).eye) < JumpTour::kSpeed_mps;
  jump_reports_.count(*jumps_, view, now - jump, shows_view, view_.tolerance_px, log_.options.request.tau_px);
}

Status Player::setPath(proto::Path path, Time now) {
  path.start = now + log_.options.standing;
  for (proto::Pose& pose : path.poses) pose = log_.options.exaggeration.askedPose(pose);
  if (Status s = path.validate(); !s.ok()) return s;
  path_ = std::move(path);
  startScene();
  if (log_.options.knowledge == PathKnowledge::kAnnounced) viewer_.announcePath(path_);
  enter(Phase::kStanding, now);
  return {};
}

void Player::countFrame() {
  ++report_.frames;
  if (!view_.mesh) {
    ++report_.frames_without_mesh;
    return;
  }
  report_.nodes = view_.mesh->to_nodes;
  report_.triangles = view_.mesh->triangleCount();
  if (!viewer_.welcome()->epochs.empty()) {
    report_.scene_last = view_.mesh->to.scene_time;
    if (!report_.scene_first) report_.scene_first = view_.mesh->from.scene_time;
  }
  node_sum_ += report_.nodes;
  triangle_sum_ += static_cast<double>(report_.triangles);
}

FlightReport Player::report() const {
  FlightReport r = report_;
  r.jumps = jump_reports_.reports();
  r.session = viewer_.statistics();
  if (phase_ == Phase::kFlying || phase_ == Phase::kDone) {
    r.keyframes_flying = r.session.keyframes - before_flight_.keyframes;
    r.late_keyframes_flying = r.session.late_keyframes - before_flight_.late_keyframes;
    r.frames_outside = r.session.frames_outside - before_flight_.frames_outside;
  }
  const double shown = static_cast<double>(std::max<uint64_t>(r.frames - r.frames_without_mesh, 1));
  r.mean_nodes = node_sum_ / shown;
  r.mean_triangles = triangle_sum_ / shown;
  return r;
}

Replayed replay(const FlightLog& log, const std::function<bool(const Player&, Time)>& on_frame) {
  Replayed replayed{Player(log.options, log.options.is_steered ? steeredPath(log) : proto::Path{}), {}};
  Player& player = replayed.player;
  Bytes unsent;
  for (const FlightLog::Entry& entry : log.entries) {
    if (entry.what == FlightLog::What::kMessage) replayed.status = player.receive(entry.message, entry.time);
    if (entry.what == FlightLog::What::kReconnect) player.reconnect(entry.time);
    const bool is_steered = entry.what == FlightLog::What::kSteered;
    if (entry.what == FlightLog::What::kFrame) replayed.status = player.frame(entry.time);
    if (entry.what == FlightLog::What::kJump) player.jump(entry.time);
    if (is_steered) player.steer(entry.time, entry.pose);
    if (entry.what == FlightLog::What::kChoice) player.choose(entry.time, *entry.choice);
    while (player.takeOutgoing(unsent)) continue;
    if (!replayed.status.ok()) break;  // the recorded flight ended here, too
    if ((is_steered || entry.what == FlightLog::What::kFrame) && !on_frame(player, entry.time)) break;
  }
  return replayed;
}

}  // namespace foreland::client
