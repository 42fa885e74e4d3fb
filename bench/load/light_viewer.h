// A viewer without a screen or a section: it asks for keyframes, sends poses and acknowledges what arrives, so that
// hundreds of them can be simulated beside the real sessions that serve them. Bytes and times in, bytes out; one owner.
#pragma once

#include <vector>

#include "base/bytes.h"
#include "proto/message/message.h"
#include "proto/space/path.h"

namespace foreland::bench {

class LightViewer {
 public:
  static constexpr Duration kPoseInterval = Duration::milliseconds(50);

  // The camera flies `path` over and over, at the viewer's time plus `offset` into it; with `jump_every` it is
  // elsewhere on the path each time so much has gone by.
  struct Flight {
    std::shared_ptr<const proto::Path> path;
    Duration offset, jump_every;
  };
  LightViewer(const proto::ViewRequest& request, Flight flight) : request_(request), flight_(std::move(flight)) {}

  Bytes hello() const { return proto::encode(request_); }
  Bytes pose(Time now);
  // Returns by how much the keyframe is late to be shown; negative is early. Nothing if the message is no keyframe.
  std::optional<Duration> receive(ByteSpan message, Time now);
  const proto::ViewRequest& request() const { return request_; }

 private:
  proto::Pose at(Time now) const;

  proto::ViewRequest request_;
  Flight flight_;
  proto::PoseMemory poses_sent_;
  proto::KeyframeMemory keyframes_taken_;
  uint32_t received_ = 0;
  Time received_at_;
};

}  // namespace foreland::bench
