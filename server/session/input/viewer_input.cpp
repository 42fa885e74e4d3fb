#include "server/session/input/viewer_input.h"

#include <utility>

namespace foreland::server {

Result<proto::ClientMessage> ViewerInput::decode(ByteSpan bytes) {
  auto message = proto::decodeClientMessage(bytes, poses_taken_);
  if (message.ok() && !request_ && !std::holds_alternative<proto::ViewRequest>(*message))
    return Error{ErrorCode::kMalformed, "the first message must be a view request"};
  return message;
}

void ViewerInput::take(proto::ViewRequest request, const RequestDefaults& defaults) {
  if (request.tau_px == 0) request.tau_px = defaults.tau_px;
  if (request.keyframe_interval == Duration{}) {
    request.keyframe_interval = defaults.keyframe_interval;
    request.longest_interval = request.order == 1 ? defaults.longest_interval : Duration{};
  }
  request_ = std::move(request);
}

Status ViewerInput::take(const proto::Resume& resume, bool is_first) {
  if (!is_first || !motion_.empty() || has_resumed_)
    return Error{ErrorCode::kMalformed, "a client resumes once, before its first pose, or not at all"};
  resume_ = resume;
  has_resumed_ = true;
  return {};
}

bool ViewerInput::take(const proto::PoseUpdate& update, Time arrived, Time now, const terrain::Scene& scene,
                       std::optional<Time> keyframe) {
  const auto isAnnounced = [&] {
    const bool is_next = !motion_.empty() && update.pose.time > motion_.newest().time;
    return update.has_jumped && is_next && announced_jumps_.take(arrived);
  };
  const bool has_jumped = !clocks_.poseArrived(update.pose.time, arrived) || motion_.isJump(update.pose, scene) ||
                          isTooFarAhead(keyframe, now) || isAnnounced();
  has_jumped ? motion_.jumpTo(update.pose) : motion_.add(update.pose);
  return has_jumped;
}

bool ViewerInput::isTooFarAhead(std::optional<Time> keyframe, Time now) const {
  constexpr Duration kMaxAhead = Duration::seconds(2);
  return keyframe && *keyframe > clocks_.clientTime(now) + clocks_.roundTrip() + bounds().most() * 2 + kMaxAhead;
}

proto::Resume ViewerInput::takeResume() { return *std::exchange(resume_, std::nullopt); }

size_t ViewerInput::keptBytes() const {
  return motion_.pathBytes() + requests_.bytes() + (resume_ ? resume_->section.size() : 0);
}

}  // namespace foreland::server
