#include "oracle/flight_truth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/quantile.h"
#include "oracle/exact_keyframes.h"
#include "oracle/lod_motion.h"

namespace foreland::oracle {

namespace {

using client::KeyframeMesh;
using client::Player;
using Mesh = std::shared_ptr<const KeyframeMesh>;

// Rounding of positions to floats and of poses on the wire is not an error of refinement: a hundredth of a pixel is let
// pass.
constexpr double kSlack_px = 0.01;

class Measurement {
 public:
  Measurement(const client::FlightLog& log, SceneOracle& oracle, const FlightTruthOptions& options)
      : oracle_(oracle),
        options_(options),
        strategy_(log.options.request.strategy),
        blend_(log.options.blend),
        lens_(log.options.request.lens),
        asked_interval_(log.options.request.keyframe_interval) {
    truth_.has_terms = options.section_at != nullptr;
  }

  bool onFrame(const Player& player, Time now) {
    if (player.phase() != Player::Phase::kFlying && player.phase() != Player::Phase::kDone) return true;
    const client::FrameView& view = player.view();
    if (!view.mesh) return true;
    if (frames_ == 0) chooseStride(player);
    takeChoices(player.viewer());
    truth_.seconds = (now - player.path().start).toSeconds();
    const bool is_new = std::exchange(measured_version_, view.mesh_version) != view.mesh_version;
    if (is_new) measureMesh(player);
    const double delay_ms = (now - view.shown_time).toMilliseconds();
    if (strategy_ != proto::Strategy::kPredict) {
      delay_sum_ms_ += delay_ms;
      truth_.delay_max_ms = std::max(truth_.delay_max_ms, delay_ms);
    }
    if (frames_++ % truth_.frame_every == 0) {
      measureFrame(player, now);
      if (!is_new) measureMotion(view, (now - last_frame_).toSeconds());
    }
    last_frame_ = now;
    last_weight_ = view.weight;
    return true;
  }

  // Who steers may change them on the way.
  void takeChoices(const client::Viewer& viewer) {
    strategy_ = viewer.request().strategy;
    lens_ = viewer.request().lens;
    blend_ = viewer.blend();
  }

  FlightTruth finish() {
    for (TermNorms* norms : {&truth_.keyframes, &truth_.frames, &truth_.interpolation, &truth_.view,
                             &truth_.extrapolation, &truth_.lod_motion})
      norms->finish();
    truth_.lod_motion_p99_px = quantile(moved_px_, 0.99);
    truth_.outside_measured = outside_px_.size();
    truth_.outside_p99_px = quantile(outside_px_, 0.99);
    truth_.outside_max_px = quantile(outside_px_, 1);
    truth_.object_interior_per_tau = oracle_.objects().interiorPerTau();
    truth_.delay_mean_ms = delay_sum_ms_ / static_cast<double>(std::max<uint64_t>(frames_, 1));
    return truth_;
  }

 private:
  // The interval is the server's if the flight asked for none.
  void chooseStride(const Player& player) {
    const Duration interval = asked_interval_.us > 0 ? asked_interval_ : player.viewer().welcome()->keyframe_interval;
    truth_.frame_every = coprimeStride(std::max(1u, options_.frame_every),
                                       static_cast<uint32_t>(std::max(1L, std::lround(60 * interval.toSeconds()))));
  }

  // Meshes with which nodes move on while the next keyframe is awaited are of a keyframe that was measured already.
  void measureMesh(const Player& player) {
    const KeyframeMesh& mesh = *player.view().mesh;
    const CrackReport cracks = oracle_.findCracks(mesh, player.viewer().welcome()->shape);
    if (truth_.cracks == 0) truth_.first_crack = cracks.first;
    truth_.cracks += cracks.cracks;
    if (std::exchange(measured_keyframe_, mesh.to.index) == mesh.to.index) return;
    const DrawnShare newest{.mesh = &mesh, .weight = 1};
    const SceneDeviation d = oracle_.error(mesh, 1, mesh.to.pose, lens_);
    truth_.keyframes.add(d);
    addObjects(d);
    if (strategy_ != proto::Strategy::kPredict || !options_.section_at) return;
    const proto::Pose pose = player.path().at(mesh.to.time);
    const Mesh exact = keyframeAt(player, mesh.to);
    const DrawnShare exact_share{.mesh = exact.get()};
    truth_.extrapolation.add(oracle_.terrain().difference({&newest, 1}, {&exact_share, 1}, pose, lens_));
  }

  void measureFrame(const Player& player, Time now) {
    const client::FrameView& view = player.view();
    const DrawnShare drawn{.mesh = view.mesh, .weight = view.weight};
    const SceneDeviation d = oracle_.error(*view.mesh, view.weight, view.pose, lens_);
    truth_.frames.add(d);
    truth_.weights_judged.add(view.weight);
    addObjects(d);
    truth_.uncovered_samples += d.uncovered;
    truth_.frames_over_tau += d.max_px > view.mesh->to.frameTolerance() + kSlack_px;
    if (std::isinf(view.tolerance_px)) outside_px_.push_back(d.max_px);
    if (options_.section_at) measureTerms(player, now, drawn);
    if (options_.on_progress) options_.on_progress(truth_);
  }

  void addObjects(const SceneDeviation& d) {
    truth_.object_silhouette_error_px = std::max(truth_.object_silhouette_error_px, d.silhouette_px);
    truth_.object_interior_error_px = std::max(truth_.object_interior_error_px, d.interior_px);
    truth_.object_vertices_judged += d.object_vertices;
  }

  void measureTerms(const Player& player, Time now, const DrawnShare& drawn) {
    const client::FrameView& view = player.view();
    const double tau_px = view.mesh->to.tau_px;
    const Mesh shown = options_.section_at(
        {.pose = player.path().at(view.shown_time), .lens = lens_, .tau_px = tau_px, .scene_time = sceneTimeOf(view)});
    const DrawnShare shown_share{.mesh = shown.get()};
    if (strategy_ == proto::Strategy::kPredict && blend_ == client::Blend::kKeyframe) {
      const Mesh from = keyframeAt(player, view.mesh->from), to = keyframeAt(player, view.mesh->to);
      const DrawnShare between[] = {{.mesh = from.get(), .share = 1.0 - view.weight},
                                    {.mesh = to.get(), .share = view.weight}};
      truth_.interpolation.add(oracle_.terrain().difference(between, {&shown_share, 1}, view.pose, lens_));
      return;
    }
    truth_.interpolation.add(oracle_.terrain().difference({&drawn, 1}, {&shown_share, 1}, view.pose, lens_));
    if (strategy_ != proto::Strategy::kCurrent) return;
    const Mesh current = options_.section_at(
        {.pose = player.path().at(now), .lens = lens_, .tau_px = tau_px, .scene_time = sceneTimeOf(view)});
    const DrawnShare current_share{.mesh = current.get()};
    truth_.view.add(oracle_.terrain().difference({&current_share, 1}, {&shown_share, 1}, view.pose, lens_));
  }

  // Of the ground that the frame shows.
  static Time sceneTimeOf(const client::FrameView& view) {
    const proto::KeyframeHeader &from = view.mesh->from, &to = view.mesh->to;
    return {from.scene_time.us +
            std::llround(static_cast<double>(view.weight) * static_cast<double>((to.scene_time - from.scene_time).us))};
  }

  void measureMotion(const client::FrameView& view, double seconds) {
    if (!(seconds > 0)) return;
    motions_px_.clear();
    const size_t seen = collectLodMotion(*view.mesh, {last_weight_, view.weight}, view.pose, lens_, motions_px_);
    Deviation motion;
    double sum2 = 0;
    for (double& px : motions_px_) {
      px /= 60 * seconds;
      motion.max_px = std::max(motion.max_px, px);
      sum2 += px * px;
    }
    motion.rms_px = std::sqrt(sum2 / static_cast<double>(std::max<size_t>(seen, 1)));
    moved_px_.insert(moved_px_.end(), motions_px_.begin(), motions_px_.end());
    truth_.lod_motion.add(motion);
  }

  // What a keyframe would have been, had its pose been known.
  Mesh keyframeAt(const Player& player, const proto::KeyframeHeader& header) {
    return exact_.at(options_.section_at, player.path().at(header.time), lens_, header);
  }

  SceneOracle& oracle_;
  const FlightTruthOptions& options_;
  proto::Strategy strategy_;
  client::Blend blend_;
  proto::Lens lens_;
  Duration asked_interval_;
  FlightTruth truth_;
  ExactKeyframes exact_;
  uint32_t measured_version_ = 0, measured_keyframe_ = 0;
  Time last_frame_;
  double last_weight_ = 0;
  std::vector<double> motions_px_, moved_px_;  // of a frame, and of all
  std::vector<double> outside_px_;             // errors of frames that no region covers
  uint64_t frames_ = 0;
  double delay_sum_ms_ = 0;
};

}  // namespace

void TermNorms::add(const Deviation& d) {
  ++count;
  max_px = std::max(max_px, d.max_px);
  max_m = std::max(max_m, d.max_m);
  mean_px += d.max_px;
  mean_m += d.max_m;
  rms_px += d.rms_px * d.rms_px;
  rms_m += d.rms_m * d.rms_m;
}

void TermNorms::finish() {
  const double n = static_cast<double>(std::max<uint64_t>(count, 1));
  mean_px /= n, mean_m /= n;
  rms_px = std::sqrt(rms_px / n), rms_m = std::sqrt(rms_m / n);
}

FlightTruth measureFlight(const client::FlightLog& log, SceneOracle& oracle, const FlightTruthOptions& options) {
  Measurement measurement(log, oracle, options);
  client::replay(log, [&](const Player& player, Time now) { return measurement.onFrame(player, now); });
  return measurement.finish();
}

}  // namespace foreland::oracle
