// A viewer without a screen or a mesh: it asks for keyframes, sends poses and acknowledges what arrives, so that
// hundreds of them can be simulated beside the real sessions that serve them. If it holds its sections, in the replica
// of a real client, it can resume on another server. Bytes and times in, bytes out; one owner.
#pragma once

#include <optional>
#include <vector>

#include "base/bytes.h"
#include "client/replica.h"
#include "proto/message/message.h"
#include "proto/space/path.h"

namespace foreland::lab {

class LightViewer {
 public:
  static constexpr Duration kPoseInterval = Duration::milliseconds(50);
  enum class Holds : uint8_t { kNothing, kSections };

  // The camera flies `path` over and over, at the viewer's time plus `offset` into it; with `jump_every` it is
  // elsewhere on the path each time so much has gone by.
  struct Flight {
    std::shared_ptr<const proto::Path> path;
    Duration offset, jump_every;
  };
  LightViewer(const proto::ViewRequest& request, Flight flight, Holds holds = Holds::kNothing)
      : request_(request), flight_(std::move(flight)), holds_(holds) {}

  // The first message of a connection, the first one or another.
  Bytes connect();
  // With the predictor kKnownPath: the message that announces the path, which the camera then flies exactly, from
  // `from` until `to`, the viewer's time. Nothing with other predictors. To be sent after the first message.
  std::optional<Bytes> announce(Time from, Time to);
  // A pose; nothing while what is held must wait for the welcome, since it is presented before the first pose.
  std::optional<Bytes> pose(Time now);

  struct Received {
    bool is_keyframe = false;
    bool is_resumed = false;        // a keyframe that starts from another
    Time time{};                    // that a keyframe is for, the viewer's clock
    Duration lateness{};            // of a keyframe, to be shown; negative is early
    double tau_px = 0;              // that a keyframe states
    std::optional<Bytes> resume{};  // to be sent: what is held
  };
  Received receive(ByteSpan message, Time now);
  const proto::ViewRequest& request() const { return request_; }

 private:
  proto::Pose at(Time now) const;
  std::optional<Bytes> takeWelcome(proto::Welcome welcome);

  proto::ViewRequest request_;
  Flight flight_;
  Holds holds_;
  std::optional<proto::Path> announced_;
  bool is_greeted_ = false;
  std::optional<client::Replica> replica_;  // of Holds::kSections, after the first welcome
  proto::PoseMemory poses_sent_;
  proto::KeyframeMemory keyframes_taken_;
  uint32_t received_ = 0;
  Time received_at_;
};

}  // namespace foreland::lab
