// A frame of a flight as a piece of work: what is to be judged of it, and what is found. flight_truth.h says what the
// terms are, and puts pieces together. A piece holds all that its judgement depends on, so any thread may make it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/fly/exaggeration.h"
#include "oracle/exact_keyframes.h"
#include "oracle/lod_motion.h"
#include "oracle/scene_oracle.h"

namespace foreland::oracle {

// Rounding of positions to floats and of poses on the wire is not an error of refinement: a hundredth of a pixel is let
// pass.
inline constexpr double kSlack_px = 0.01;

struct FlightPiece {
  using Mesh = std::shared_ptr<const client::KeyframeMesh>;

  Mesh mesh;  // that the frame shows
  proto::GridShape shape;
  proto::Lens lens;                   // that the server was told
  client::Exaggeration exaggeration;  // factor 1: `lens` is what is drawn with
  uint64_t frame = 0;                 // of those replayed
  bool looks_for_cracks = false;

  // The keyframe that the mesh leads to.
  struct Keyframe {
    proto::Pose true_pose;                // at its time
    std::shared_ptr<ExactSection> exact;  // of that pose; null: extrapolation is not measured
  };
  std::optional<Keyframe> keyframe{};

  // What interpolation and view are measured against; sections of the frame's scene time.
  struct Terms {
    SectionRequest shown;                    // for the pose at the time shown
    std::shared_ptr<ExactSection> from, to;  // the keyframes between which S_inter lies; null: it is what is drawn
    std::optional<SectionRequest> current;   // for the pose at the frame's time; nothing: view is not measured
  };
  struct Frame {
    double weight = 0;
    proto::Pose pose;
    double tolerance_px = 0;  // that it states; outside of a region, that of the keyframe it leads to
    bool is_outside = false;  // of the region of a keyframe that is shown
    std::optional<Terms> terms{};
  };
  std::optional<Frame> shown{};

  struct Motion {
    WeightStep weights;
    double seconds = 0;  // that it takes
    proto::Pose pose;
  };
  std::optional<Motion> motion{};
};

struct FlightJudgement {
  uint64_t frame = 0;
  CrackReport cracks{};
  std::optional<SceneDeviation> keyframe{}, shown{};
  std::optional<Deviation> extrapolation{}, interpolation{}, view{}, motion{};
  double weight = 0;                                   // of the frame shown
  bool is_outside = false, is_over_tolerance = false;  // of the frame shown
  bool is_keyframe_over_tolerance = false;
  std::vector<double> moved_px{};  // by each vertex that moves, in a 60th of a second
};

// What one thread judges with.
class FlightJudge {
 public:
  // `section_at` may be empty if no piece asks for a section.
  FlightJudge(SceneOracle& oracle, SectionAt section_at) : oracle_(oracle), section_at_(std::move(section_at)) {}

  FlightJudgement judge(const FlightPiece& piece);

 private:
  // The camera of the picture, of which the server was told `asked`.
  struct Drawn {
    proto::Pose pose;
    proto::Lens lens;
  };
  static Drawn drawn(const FlightPiece& piece, const proto::Pose& asked, const proto::Lens& lens);
  void judgeKeyframe(const FlightPiece& piece, FlightJudgement& found);
  void judgeFrame(const FlightPiece& piece, FlightJudgement& found);
  void measureTerms(const FlightPiece& piece, const FlightPiece::Terms& terms, FlightJudgement& found);
  void measureMotion(const FlightPiece& piece, FlightJudgement& found) const;

  SceneOracle& oracle_;
  SectionAt section_at_;
};

}  // namespace foreland::oracle
