#include "client/viewer.h"

#include <algorithm>
#include <utility>

#include "client/area.h"

namespace foreland::client {

namespace {

template <class Reply>
std::optional<Reply> takeFirst(std::deque<Reply>& replies) {
  if (replies.empty()) return std::nullopt;
  std::optional<Reply> first = std::move(replies.front());
  replies.pop_front();
  return first;
}

// Replies that nobody asked for, or nobody takes, are not kept for good.
constexpr size_t kMaxReplies = 64;

template <class Reply>
void keepNewest(std::deque<Reply>& replies, Reply reply) {
  if (replies.size() == kMaxReplies) replies.pop_front();
  replies.push_back(std::move(reply));
}

}  // namespace

Viewer::Viewer(const proto::ViewRequest& request, Blend blend, Duration pose_interval)
    : request_(request), pose_interval_(pose_interval), blend_(blend) {
  send(proto::encode(asked()));
}

// Of the server. A spline of several keyframes needs equal intervals.
proto::ViewRequest Viewer::asked() const {
  proto::ViewRequest request = request_;
  request.order = orderOf(blend_);
  if (request.order > 1) request.longest_interval = {};
  return request;
}

// The server's is in force if none is asked for.
proto::KeyframeInterval Viewer::interval() const {
  const bool has_own = request_.keyframe_interval != Duration{}, bounds_own = has_own || asked().order > 1;
  return {has_own ? request_.keyframe_interval : welcome_->keyframe_interval,
          bounds_own ? asked().longest_interval : welcome_->longest_interval};
}

void Viewer::send(Bytes message) {
  statistics_.bytes_up += message.size();
  outgoing_.push_back(std::move(message));
}

bool Viewer::takeOutgoing(Bytes& message) {
  if (outgoing_.empty()) return false;
  message = std::move(outgoing_.front());
  outgoing_.pop_front();
  return true;
}

Status Viewer::receive(ByteSpan bytes, Time now) {
  statistics_.bytes_down += bytes.size();
  auto message = proto::decodeServerMessage(bytes, keyframes_taken_);
  if (!message) return message.error();
  if (auto* keyframe = std::get_if<proto::KeyframeMessage>(&*message)) return onKeyframe(*keyframe, now);
  if (auto* welcome = std::get_if<proto::Welcome>(&*message)) return onWelcome(std::move(*welcome));
  if (auto* tile = std::get_if<proto::TileMessage>(&*message)) return onTile(std::move(*tile));
  if (auto* statement = std::get_if<proto::TileStatement>(&*message)) {
    tiles_.add(*statement);
    statistics_.texel_px = statement->texel_px;
  }
  if (auto* tour = std::get_if<proto::TourReply>(&*message)) tour_ = std::move(*tour);
  if (auto* ground = std::get_if<proto::GroundReply>(&*message)) keepNewest(grounds_, std::move(*ground));
  if (auto* sight = std::get_if<proto::SightReply>(&*message)) sights_.push_back(std::move(*sight));
  if (auto* viewshed = std::get_if<proto::ViewshedReply>(&*message)) viewsheds_.push_back(std::move(*viewshed));
  if (auto* refusal = std::get_if<proto::Refusal>(&*message))
    return Error{ErrorCode::kUnsupported, "the server refuses: " + refusal->message};
  return {};
}

void Viewer::reconnect(Time now) {
  outgoing_.clear();
  grounds_.clear();
  sights_.clear();
  viewsheds_.clear();
  is_greeted_ = false;
  reconnected_at_ = now;
  received_keyframe_ = 0;
  poses_sent_ = {};
  keyframes_taken_ = {};
  last_pose_sent_.reset();
  send(proto::encode(asked()));
}

Status Viewer::onWelcome(proto::Welcome welcome) {
  if (is_greeted_) return Error{ErrorCode::kMalformed, "a second welcome on one connection"};
  is_greeted_ = true;
  const bool is_same_scene = welcome_ && welcome_->scene_id == welcome.scene_id && welcome_->shape == welcome.shape &&
                             welcome_->frame == welcome.frame;
  std::optional<proto::Resume> section;
  if (is_same_scene) section = replica_->makeResume(welcome);
  if (section) {
    send(proto::encode(*section));
  } else {
    replica_.emplace(welcome);
    timeline_.clear();
  }
  if (is_same_scene && tiles_.layers() == welcome.tile_layers) {
    tiles_.reenter(welcome.tile_bytes);
    if (tiles_.count() > 0) send(proto::encode(tiles_.held()));
  } else {
    tiles_.enter(welcome.tile_layers, welcome.tile_bytes);
  }
  welcome_ = std::move(welcome);
  if (path_) send(proto::encode(*path_));
  if (scene_clock_) send(proto::encode(*scene_clock_));
  return {};
}

Status Viewer::onTile(proto::TileMessage message) {
  ++statistics_.tiles;
  statistics_.tile_bytes += message.coded.size();
  return tiles_.add(std::move(message));
}

Status Viewer::onKeyframe(const proto::KeyframeMessage& message, Time now) {
  if (!replica_) return Error{ErrorCode::kMalformed, "a keyframe before the welcome"};
  if (Status s = replica_->apply(message.header, message.delta, blend_); !s.ok()) return s;
  if (reconnected_at_) {
    ++(message.header.base_index > 0 ? statistics_.resumed : statistics_.started_afresh);
    statistics_.longest_resume = std::max(statistics_.longest_resume, now - *reconnected_at_);
    reconnected_at_.reset();
  }
  received_keyframe_ = message.header.index;
  received_at_ = now;
  std::shared_ptr<const MeshPatch> patch = makePatch();
  timeline_.setInterval(interval());
  const Duration lateness = timeline_.add(patch, now, request_.strategy);
  addToDrawn(std::move(patch));
  drawn_->skipTo(timeline_.oldestVersion());
  ViewerStatistics& s = statistics_;
  s.worst_lateness = s.keyframes == 0 ? lateness : std::max(s.worst_lateness, lateness);
  s.last_lateness = lateness;
  s.late_keyframes += lateness > Duration{} ? 1 : 0;
  s.nodes_added += replica_->lastDelta().added.size();
  s.nodes_removed += replica_->lastDelta().removed.size();
  ++s.keyframes;
  return {};
}

std::shared_ptr<const MeshPatch> Viewer::makePatch() {
  auto patch = std::make_shared<MeshPatch>();
  has_meshes_ ? replica_->makePatch(*patch) : replica_->makeEmptyPatch(*patch);
  return patch;
}

void Viewer::addToDrawn(std::shared_ptr<const MeshPatch> patch) {
  drawn_->add(timeline_.newestVersion(), std::move(patch));
  if (draws_ahead_) drawn_->show(timeline_.newestVersion());
}

void Viewer::sendPose(Time now, const proto::Pose& pose) {
  const bool has_jumped = std::exchange(has_jumped_, false);
  send(proto::encode(proto::PoseUpdate{{now, pose}, received_keyframe_, received_at_, has_jumped}, poses_sent_));
  last_pose_sent_ = now;
}

// At a jump the server should not wait for the next pose that is due.
void Viewer::sendPoseIfDue(Time now, const proto::Pose& pose) {
  if (!is_greeted_) return;
  if (!last_pose_sent_ || now - *last_pose_sent_ >= pose_interval_ ||
      ((has_jumped_ || camera_.hasJustJumped()) && now > *last_pose_sent_))
    sendPose(now, pose);
}

void Viewer::jump() {
  camera_.jump();
  has_jumped_ = true;
}

FrameView Viewer::frame(Time now, const proto::Pose& pose) {
  camera_.add(now, pose);
  sendPoseIfDue(now, pose);

  Timeline::Shown shown = timeline_.at(now);
  if (shown.is_over && now - received_at_ >= Timeline::kTimeout && replica_->isInTransition()) {
    replica_->extend(Timeline::kExtension, blend_);
    std::shared_ptr<const MeshPatch> patch = makePatch();
    timeline_.extend(patch);
    addToDrawn(std::move(patch));
    shown = timeline_.at(now);
  }
  FrameView view{nullptr, static_cast<float>(shown.weight), pose, shown.shown_time, shown.version};
  if (!shown.mesh) return view;
  drawn_->show(shown.version);
  view.mesh = &drawn_->mesh();
  const ShownFrame frame = showFrame(shown, camera_, {pose, request_.lens, request_.eye_radius_m}, request_.strategy);
  view.pose = frame.pose;
  view.tolerance_px = frame.tolerance_px;
  ++statistics_.frames;
  if (frame.is_outside) ++statistics_.frames_outside;
  return view;
}

void Viewer::setRequest(const proto::ViewRequest& request) {
  request_ = request;
  send(proto::encode(asked()));
}

void Viewer::setBlend(Blend blend) {
  const uint32_t before = orderOf(std::exchange(blend_, blend));
  if (orderOf(blend) != before) send(proto::encode(asked()));
}

void Viewer::announcePath(const proto::Path& path) {
  path_ = path;
  send(proto::encode(path));
}

void Viewer::setSceneClock(const proto::SceneClock& clock) {
  scene_clock_ = clock;
  if (is_greeted_) send(proto::encode(clock));
}

void Viewer::requestTour(const std::string& name, double seconds) {
  send(proto::encode(proto::TourRequest{next_request_id_++, name, seconds}));
}

uint32_t Viewer::requestGround(std::vector<glm::dvec2> lattice_points) {
  send(proto::encode(proto::GroundRequest{next_request_id_, std::move(lattice_points)}));
  return next_request_id_++;
}

uint32_t Viewer::requestSight(proto::SightRequest request) {
  request.id = next_request_id_++;
  send(proto::encode(request));
  return request.id;
}

uint32_t Viewer::requestViewshed(proto::ViewshedRequest request) {
  request.id = next_request_id_++;
  send(proto::encode(request));
  return request.id;
}

void Viewer::cancelRequest(uint32_t id) { send(proto::encode(proto::RequestCancel{id})); }

std::optional<proto::TourReply> Viewer::takeTour() { return std::exchange(tour_, std::nullopt); }
std::optional<proto::GroundReply> Viewer::takeGround() { return takeFirst(grounds_); }

std::optional<proto::GroundReply> Viewer::takeGround(uint32_t id) {
  const auto reply = std::find_if(grounds_.begin(), grounds_.end(), [&](const auto& r) { return r.id == id; });
  if (reply == grounds_.end()) return std::nullopt;
  std::optional<proto::GroundReply> taken = std::move(*reply);
  grounds_.erase(reply);
  return taken;
}

std::optional<proto::SightReply> Viewer::takeSight() { return takeFirst(sights_); }
std::optional<proto::ViewshedReply> Viewer::takeViewshed() { return takeFirst(viewsheds_); }

std::optional<uint32_t> Viewer::area() const {
  if (!welcome_ || !camera_.newest()) return std::nullopt;
  const proto::LatticePosition at = frameGrid().transform().toLattice(camera_.newest()->eye);
  return areaOf(welcome_->shape, {at.x, at.y});
}

std::optional<double> Viewer::groundHeight(double x, double y) const {
  return replica_ ? replica_->heightAt(x, y) : std::nullopt;
}

}  // namespace foreland::client
