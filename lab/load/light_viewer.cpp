#include "lab/load/light_viewer.h"

#include <utility>

#include "base/check.h"

namespace foreland::lab {

// Forwards and back again, so that the path's end is no jump.
proto::Pose LightViewer::at(Time now) const {
  if (announced_) return announced_->at(now);
  const int64_t length = (flight_.path->end() - flight_.path->start).us;
  int64_t into = now.us + flight_.offset.us;
  if (flight_.jump_every.us > 0) into += now.us / flight_.jump_every.us * (length * 5 / 13);
  into %= 2 * length;
  return flight_.path->at(flight_.path->start + Duration{into < length ? into : 2 * length - into});
}

Bytes LightViewer::connect() {
  is_greeted_ = false;
  poses_sent_ = {};
  keyframes_taken_ = {};
  received_ = 0;
  return proto::encode(request_);
}

std::optional<Bytes> LightViewer::announce(Time from, Time to) {
  if (request_.predictor != proto::Predictor::kKnownPath) return std::nullopt;
  proto::Path path{.start = from, .poses = {}};
  for (Time t = from; t < to + path.step; t = t + path.step) path.poses.push_back(at(t));
  announced_ = std::move(path);
  return proto::encode(*announced_);
}

std::optional<Bytes> LightViewer::pose(Time now) {
  if (holds_ == Holds::kSections && !is_greeted_) return std::nullopt;
  return proto::encode(proto::PoseUpdate{{now, at(now)}, received_, received_at_}, poses_sent_);
}

std::optional<Bytes> LightViewer::takeWelcome(proto::Welcome welcome) {
  is_greeted_ = true;
  if (holds_ == Holds::kNothing) return std::nullopt;
  if (replica_)
    if (const auto resume = replica_->makeResume(welcome)) return proto::encode(*resume);
  replica_.emplace(welcome);
  return std::nullopt;
}

LightViewer::Received LightViewer::receive(ByteSpan message, Time now) {
  auto decoded = proto::decodeServerMessage(message, keyframes_taken_);
  CHECK_TRUE(decoded.ok());
  if (auto* welcome = std::get_if<proto::Welcome>(&*decoded)) return {.resume = takeWelcome(std::move(*welcome))};
  const auto* keyframe = std::get_if<proto::KeyframeMessage>(&*decoded);
  if (!keyframe) return {};
  if (replica_) CHECK_TRUE(replica_->apply(keyframe->header, keyframe->delta).ok());
  received_ = keyframe->header.index;
  received_at_ = now;
  return {.is_keyframe = true,
          .is_resumed = keyframe->header.base_index > 0,
          .time = keyframe->header.time,
          .lateness = now - (keyframe->header.time - request_.keyframe_interval),
          .tau_px = keyframe->header.tau_px};
}

}  // namespace foreland::lab
