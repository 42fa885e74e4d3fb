// Flights over heights that are drawn taller, or flatter, than they are (decision 0066): the picture is the scene with
// what lies along its z multiplied about the eye. The server knows nothing of that: it is asked for a view of the true
// scene that contains all that is drawn, with a tolerance so much smaller that no error is larger than wanted in the
// picture. The page does the same (client/web/src/draw/exaggeration.ts). Pure; any thread.
#pragma once

#include "proto/space/pose.h"

namespace foreland::client {

struct Exaggeration {
  static constexpr double kLeast = 0.5, kMost = 5;

  double factor = 1;    // kLeast to kMost
  proto::Lens drawn{};  // with which the picture is drawn
  proto::Lens asked{};  // which the server is told
  double finer = 1;     // how many pixels of the drawn picture an error of one pixel of the asked one may be

  // For all cameras without roll. Where the asked lens would have more pixels than a lens may, it has fewer for an
  // angle. About a millisecond.
  static Exaggeration of(double factor, const proto::Lens& drawn);

  // What the server is told of a drawn camera, whose roll is left out.
  proto::Pose askedPose(const proto::Pose& drawn_pose) const;
  // The camera without roll of which the server is told `asked_pose`.
  proto::Pose drawnPose(const proto::Pose& asked_pose) const;
};

}  // namespace foreland::client
