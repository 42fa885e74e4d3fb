// What a frame shows and what is guaranteed of it: the camera and the tolerance for what the schedule shows. Used where
// frames are drawn, like schedule.h. One owner; times are the client's clock.
#pragma once

#include <vector>

#include "client/schedule.h"
#include "proto/message/message.h"
#include "proto/space/timed_poses.h"

namespace foreland::client {

// Where the camera was in the last seconds.
class CameraPath {
 public:
  // Times that do not ascend are ignored.
  void add(Time now, const proto::Pose& pose);
  // The next pose that is added is one to which the camera jumps. Large jumps are recognised (proto/space/jump.h).
  void jump() { jumps_next_ = true; }

  // Whether it has jumped to where it is.
  bool hasJustJumped() const;
  bool hasJumpedSince(Time t) const;
  // Where the camera is; null before the first pose.
  const proto::Pose* newest() const { return poses_.empty() ? nullptr : &poses_.back().pose; }
  // Where the camera was. A pose between the two sides of a jump was never seen. There must have been a pose.
  proto::Pose at(Time t) const;

 private:
  bool isJump(const proto::TimedPose& before, const proto::TimedPose& after) const;

  std::vector<proto::TimedPose> poses_;
  std::vector<Time> jumps_;  // that were told, ascending
  bool jumps_next_ = false;
};

// What a frame is drawn with: the camera's pose and lens, and how far eyes that see it are from the pose's, as the two
// of a head.
struct FrameCamera {
  proto::Pose pose;
  proto::Lens lens;
  double eye_radius_m = 0;
};

struct ShownFrame {
  proto::Pose pose;        // the camera: M(t), or M(t_d) with strategy `delay`
  float tolerance_px = 0;  // as FrameView::tolerance_px
  // An eye is outside the region that a shown keyframe is computed for, or the lens sees more than the keyframe's.
  bool is_outside = false;
};

// `shown` must have an interval; the pose of `now` is the last one of `camera`; its lens may be another one than the
// keyframes shown were computed for, as after a window has grown.
ShownFrame showFrame(const Schedule::Shown& shown, const CameraPath& camera, const FrameCamera& now,
                     proto::Strategy strategy);

}  // namespace foreland::client
