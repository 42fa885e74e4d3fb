// What one viewer has said: what it wants, how its camera moves, how its clock runs, and what waits for an answer. The
// session decides what to do about it. One owner (a session). Times are of the server's clock unless named otherwise.
#pragma once

#include <optional>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/message/keyframe_interval.h"
#include "proto/message/message.h"
#include "server/session/input/announced_jumps.h"
#include "server/session/input/clock_map.h"
#include "server/session/input/requests.h"
#include "server/session/input/scene_time.h"
#include "server/view/viewer_motion.h"

namespace foreland::server {

// For what a view request leaves open.
struct RequestDefaults {
  double tau_px = 1;
  Duration keyframe_interval, longest_interval;
};

class ViewerInput {
 public:
  // Decodes a message; an Error if it is malformed, or comes before the view request. Takes nothing of it but the poses
  // that later ones are coded against.
  Result<proto::ClientMessage> decode(ByteSpan bytes);

  void take(proto::ViewRequest request, const RequestDefaults& defaults);
  void take(const proto::Path& path) { motion_.announce(path); }
  // Where the scene has no epochs, its clock changes nothing.
  void take(const proto::SceneClock& clock) { scene_time_.take(clock); }
  Status take(const proto::TourRequest& request, const terrain::Scene& scene) { return requests_.add(request, scene); }
  Status take(const proto::GroundRequest& request) { return requests_.add(request); }
  Status take(const proto::SightRequest& request) { return requests_.add(request); }
  Status take(const proto::ViewshedRequest& request) { return requests_.add(request); }
  void take(const proto::RequestCancel& request) { requests_.cancel(request); }
  // An Error after the first pose or keyframe.
  Status take(const proto::Resume& resume, bool is_first);
  // Takes a pose. True if the camera has jumped to it: it says so, cannot have flown there, or its clock was set anew,
  // so that times before and after cannot be compared. It arrived at `arrived`, not after `now`. `keyframe` is the time
  // of the last keyframe that the viewer holds, if any.
  bool take(const proto::PoseUpdate& update, Time arrived, Time now, const terrain::Scene& scene,
            std::optional<Time> keyframe);

  bool hasGreeted() const { return request_.has_value(); }
  // What the viewer wants, with the defaults in it. It must have greeted.
  const proto::ViewRequest& request() const { return *request_; }
  proto::KeyframeInterval bounds() const { return {request_->keyframe_interval, request_->longest_interval}; }

  // Whether a keyframe for `keyframe` is for a time that is not foreseen at `now`: it was computed, here or before the
  // viewer resumed, for a time stamp that was wrong. No keyframe could follow it for long. Poses that a stalled link
  // holds back say nothing of the kind.
  bool isTooFarAhead(std::optional<Time> keyframe, Time now) const;

  const ViewerMotion& motion() const { return motion_; }
  ViewerMotion& motion() { return motion_; }
  const ClockMap& clocks() const { return clocks_; }
  ClockMap& clocks() { return clocks_; }
  SceneTime& sceneTime() { return scene_time_; }
  Requests& requests() { return requests_; }
  const Requests& requests() const { return requests_; }

  // A section to resume from that has not been looked at yet.
  bool isResuming() const { return resume_.has_value(); }
  proto::Resume takeResume();
  // What the viewer makes the server keep, as long as it likes: its announced path, requests that wait, a section to
  // resume from. O(requests).
  size_t keptBytes() const;

 private:
  std::optional<proto::ViewRequest> request_;
  proto::PoseMemory poses_taken_;
  ViewerMotion motion_;
  ClockMap clocks_;
  AnnouncedJumps announced_jumps_;
  SceneTime scene_time_;
  Requests requests_;
  std::optional<proto::Resume> resume_;
  bool has_resumed_ = false;  // or tried to
};

}  // namespace foreland::server
