// What a session knows of its viewer's camera and expects of it: poses received, an announced path, how good
// predictions have been, and jumps. One owner (a session). Bounded, beside the path.
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "proto/message/message.h"
#include "proto/space/path.h"
#include "server/view/expected_motion.h"
#include "server/view/foresight.h"
#include "server/view/pose_history.h"
#include "server/view/prediction_errors.h"
#include "server/view/region.h"
#include "server/view/region_share.h"
#include "terrain/store/scene.h"

namespace foreland::server {

class ViewerMotion {
 public:
  // From now on `foresight` takes the place of the predictor that a viewer asks for; to be called before the first
  // pose.
  void foreseeBy(std::unique_ptr<Foresight> foresight) { foresight_ = std::move(foresight); }
  void announce(proto::Path path) { path_ = std::move(path); }
  size_t pathBytes() const { return path_ ? path_->poses.capacity() * sizeof(proto::Pose) : 0; }
  // Takes the camera's next pose. Predictions for times up to it are judged by it.
  void add(const proto::TimedPose& pose);
  // Takes a pose to which the camera jumped. Nothing known of the motion before holds any more, and neither does an
  // announced path that does not pass there.
  void jumpTo(const proto::TimedPose& pose);

  // Whether the camera cannot have flown to `pose` from the newest one (proto/space/jump.h).
  bool isJump(const proto::TimedPose& pose, const terrain::Scene& scene) const;
  bool empty() const { return history_.empty(); }

  // All that follows needs at least one pose.

  const proto::TimedPose& newest() const { return history_.newest(); }
  // Where the camera was, is, and is expected to be. With `delay` and `current` only the interval after a keyframe has
  // to be predicted.
  ExpectedMotion expected(const proto::ViewRequest& request) const;
  // Whether poses tell how the camera moves: not yet where it stands since a jump.
  bool isMotionKnown() const { return history_.span() >= PoseHistory::kBaseline; }
  // Whether that is along the announced path.
  bool isOnPath(const proto::ViewRequest& request) const;

  // Notes what was expected for a keyframe `interval` after the one before it. Where the pose of its time is known, as
  // with the strategy `delay`, its error counts at once, and takes the place of an earlier one.
  void notePrediction(const proto::TimedPose& expected, Duration interval);
  // How far the eye may be from where it is expected for a keyframe after such an interval, metres.
  double eyeError(Duration interval) const;
  // Of the region around `centre` that the camera stays in from `begin` to `end`; as long as the poses since a jump do
  // not tell its velocity, also if it goes on for `unknown` in any direction as fast as before.
  RegionParts regionAround(const proto::Pose& centre, const ExpectedMotion& motion, Time begin, Time end,
                           Duration interval, Duration unknown) const;

  RegionShare& regionShare() { return region_share_; }
  const RegionShare& regionShare() const { return region_share_; }

 private:
  bool isPathFollowed(const proto::TimedPose& pose) const;
  Region unknownMotion(Duration time) const;

  struct Prediction {
    proto::TimedPose expected;
    Duration interval;  // of the keyframe that it was made for
  };
  PoseHistory history_;
  std::unique_ptr<Foresight> foresight_;  // null: viewers' predictors
  std::optional<proto::Path> path_;
  std::deque<Prediction> predictions_;  // of times for which no true pose has arrived yet
  PredictionErrors errors_;
  RegionShare region_share_;
  Region before_jump_;  // how far the camera went and turned in a second
};

}  // namespace foreland::server
