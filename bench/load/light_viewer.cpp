#include "bench/load/light_viewer.h"

namespace foreland::bench {

// Forwards and back again, so that the path's end is no jump.
proto::Pose LightViewer::at(Time now) const {
  const int64_t length = (flight_.path->end() - flight_.path->start).us;
  int64_t into = now.us + flight_.offset.us;
  if (flight_.jump_every.us > 0) into += now.us / flight_.jump_every.us * (length * 5 / 13);
  into %= 2 * length;
  return flight_.path->at(flight_.path->start + Duration{into < length ? into : 2 * length - into});
}

Bytes LightViewer::pose(Time now) {
  return proto::encode(proto::PoseUpdate{{now, at(now)}, received_, received_at_}, poses_sent_);
}

std::optional<Duration> LightViewer::receive(ByteSpan message, Time now) {
  const auto decoded = proto::decodeServerMessage(message, keyframes_taken_);
  CHECK_TRUE(decoded.ok());
  const auto* keyframe = std::get_if<proto::KeyframeMessage>(&*decoded);
  if (!keyframe) return std::nullopt;
  received_ = keyframe->header.index;
  received_at_ = now;
  return now - (keyframe->header.time - request_.keyframe_interval);
}

}  // namespace foreland::bench
