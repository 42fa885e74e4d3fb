// The error terms of one frame (THEORY section 4, P section 4), each between two surfaces that this frame's camera
// sees:
//
//   total          what is drawn, against the truth
//   refinement     S_view of the time shown, against the truth: what the tolerance allows
//   interpolation  between keyframes of the true poses, against S_view of the time shown
//   view           `current`: S_view of the camera's time, against S_view of the time shown
//   extrapolation  `predict`: what is drawn, against the same between keyframes of the true poses
//
// The time shown is t - delay. For `current` the refinement is that of the camera's time. All terms of a frame are
// taken over the same samples, so the total is at most the sum of the others in metres and in pixels, in the largest
// and in the root mean square: the triangle inequality. A frame in which it is not so has a mistake in it. Sections of
// true poses get the region of the keyframe that they stand for (oracle/flight_truth.h). One owner; a judge is
// for one flight.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "client/viewer.h"
#include "oracle/exact_keyframes.h"
#include "oracle/flight_truth.h"
#include "oracle/oracle.h"
#include "proto/space/path.h"
#include "server/session/world.h"

namespace foreland::lab {

enum class Term : uint8_t { kTotal, kRefinement, kInterpolation, kView, kExtrapolation };
inline constexpr size_t kTerms = 5;
const char* name(Term term);

struct FrameTerms {
  double time_s = 0;  // since the flight began
  double weight = 0, delay_ms = 0;
  std::array<oracle::Deviation, kTerms> terms{};  // by Term; zero where a strategy has none
  uint64_t triangles = 0;
  double tolerance_px = 0;    // that the frame states; infinite outside of the region of a keyframe that is shown
  double lod_motion_px = 0;   // the largest motion of a vertex by level of detail alone, in a 60th of a second
  bool breaks_bound = false;  // the total is more than the sum of the terms

  const oracle::Deviation& of(Term term) const { return terms[static_cast<size_t>(term)]; }
};

class FrameJudge {
 public:
  struct Flight {
    std::shared_ptr<const server::World> world;
    const proto::Path* path = nullptr;  // outlives the judge
    proto::Strategy strategy;
    proto::Lens lens;
    double tau_px = 1;
  };

  // `oracle` is lent.
  FrameJudge(Flight flight, oracle::Oracle& oracle);

  // `view` shows a mesh.
  FrameTerms judge(const client::FrameView& view, Time now);

 private:
  using Mesh = std::shared_ptr<const client::KeyframeMesh>;
  Mesh trueKeyframe(const proto::KeyframeHeader& header);
  Mesh viewAt(const oracle::SectionAt& chain, Time t) const;

  Flight flight_;
  oracle::Oracle& oracle_;
  oracle::SectionAt shown_, current_, keyframes_;
  oracle::ExactKeyframes true_keyframes_;
};

}  // namespace foreland::lab
