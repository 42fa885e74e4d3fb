#include "oracle/flight_truth.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/quantile.h"
#include "oracle/exact_keyframes.h"
#include "oracle/flight_piece.h"
#include "oracle/ordered_work.h"
#include "oracle/pixel_spread.h"

namespace foreland::oracle {

namespace {

using client::KeyframeMesh;
using client::Player;

// Replays a flight, picks what is judged of it, and puts together what is found. What depends on frames before is done
// here, in their order; the rest is in pieces, on any thread.
class Measurement {
 public:
  Measurement(const client::FlightLog& log, const FlightTruthOptions& options)
      : options_(options),
        strategy_(log.options.request.strategy),
        blend_(log.options.blend),
        lens_(log.options.request.lens),
        exaggeration_(log.options.exaggeration),
        asked_interval_(log.options.request.keyframe_interval) {
    truth_.has_terms = options.sections != nullptr && options.terms_every > 0;
    for (const client::FlightLog::Entry& entry : log.entries)
      all_frames_ += entry.what == client::FlightLog::What::kFrame || entry.what == client::FlightLog::What::kSteered;
  }

  // What is to be judged of a frame, if anything.
  std::optional<FlightPiece> onFrame(const Player& player, Time now) {
    ++replayed_;
    if (player.phase() != Player::Phase::kFlying && player.phase() != Player::Phase::kDone) return std::nullopt;
    const client::FrameView& view = player.view();
    if (!view.mesh) return std::nullopt;
    if (frames_ == 0) chooseStrides(player);
    takeChoices(player.viewer());
    const bool is_new = std::exchange(measured_version_, view.mesh_version) != view.mesh_version;
    if (is_new) mesh_.reset();
    const double delay_ms = (now - view.shown_time).toMilliseconds();
    if (strategy_ != proto::Strategy::kPredict) {
      delay_sum_ms_ += delay_ms;
      truth_.delay_max_ms = std::max(truth_.delay_max_ms, delay_ms);
    }
    FlightPiece piece{.mesh = {},
                      .shape = player.viewer().welcome()->shape,
                      .lens = lens_,
                      .exaggeration = exaggeration_,
                      .frame = replayed_};
    bool is_judged = is_new && takeMesh(player, piece);
    if (frames_++ % truth_.frame_every == 0) {
      is_judged = true;
      takeFrame(player, now, piece);
      if (!is_new) takeMotion(view, (now - last_frame_).toSeconds(), piece);
    }
    last_frame_ = now;
    last_weight_ = view.weight;
    if (!is_judged) return std::nullopt;
    if (!mesh_) mesh_ = std::make_shared<KeyframeMesh>(*view.mesh);  // the player changes its own
    piece.mesh = mesh_;
    return piece;
  }

  // In the order of frames.
  void take(const FlightJudgement& found) {
    if (truth_.cracks == 0) truth_.first_crack = found.cracks.first;
    truth_.cracks += found.cracks.cracks;
    if (found.keyframe) truth_.keyframes.add(*found.keyframe), addParts(*found.keyframe);
    truth_.keyframes_over_tau += found.is_keyframe_over_tolerance;
    if (found.extrapolation) truth_.extrapolation.add(*found.extrapolation);
    if (found.shown) addFrame(found);
    if (found.interpolation) truth_.interpolation.add(*found.interpolation);
    if (found.view) truth_.view.add(*found.view);
    if (found.motion) truth_.lod_motion.add(*found.motion);
    for (const double px : found.moved_px) moved_px_.add(px);
    done_ = static_cast<double>(found.frame) / static_cast<double>(all_frames_);
  }

  // The share of the flight of which all is judged.
  double done() const { return done_; }

  FlightTruth finish(bool is_whole) {
    for (TermNorms* norms : {&truth_.keyframes, &truth_.frames, &truth_.interpolation, &truth_.view,
                             &truth_.extrapolation, &truth_.lod_motion})
      norms->finish();
    truth_.is_whole = is_whole;
    truth_.lod_motion_p99_px = moved_px_.quantile(0.99);
    truth_.outside_measured = outside_px_.size();
    truth_.outside_p99_px = quantile(outside_px_, 0.99);
    truth_.outside_max_px = quantile(outside_px_, 1);
    truth_.delay_mean_ms = delay_sum_ms_ / static_cast<double>(std::max<uint64_t>(frames_, 1));
    return truth_;
  }

 private:
  // Who steers may change them on the way.
  void takeChoices(const client::Viewer& viewer) {
    strategy_ = viewer.request().strategy;
    lens_ = viewer.request().lens;
    blend_ = viewer.blend();
  }

  // The interval is the server's if the flight asked for none.
  void chooseStrides(const Player& player) {
    const Duration interval = asked_interval_.us > 0 ? asked_interval_ : player.viewer().welcome()->keyframe_interval;
    const auto frames_per_keyframe = static_cast<uint32_t>(std::max(1L, std::lround(60 * interval.toSeconds())));
    const uint64_t most = options_.max_frames > 0 ? options_.max_frames : all_frames_;
    const auto stride = [&](uint64_t count) { return static_cast<uint32_t>((count + most - 1) / most); };
    truth_.frame_every = coprimeStride(std::max({1u, options_.frame_every, stride(all_frames_)}), frames_per_keyframe);
    truth_.keyframe_every = std::max(1u, stride(all_frames_ / frames_per_keyframe));
  }

  // Meshes with which nodes move on while the next keyframe is awaited are of a keyframe that was measured already.
  bool takeMesh(const Player& player, FlightPiece& piece) {
    const KeyframeMesh& mesh = *player.view().mesh;
    const bool is_keyframe = std::exchange(measured_keyframe_, mesh.to.index) != mesh.to.index;
    if (is_keyframe) is_keyframe_judged_ = keyframes_++ % truth_.keyframe_every == 0;
    piece.looks_for_cracks = is_keyframe_judged_;
    if (!is_keyframe || !is_keyframe_judged_) return is_keyframe_judged_;
    FlightPiece::Keyframe& keyframe = piece.keyframe.emplace();
    const bool has_terms = isTurn(terms_of_keyframes_);
    if (strategy_ != proto::Strategy::kPredict || !has_terms) return true;
    keyframe.true_pose = player.path().at(mesh.to.time);
    keyframe.exact = keyframeAt(player, mesh.to);
    return true;
  }

  void takeFrame(const Player& player, Time now, FlightPiece& piece) {
    const client::FrameView& view = player.view();
    const bool is_outside = std::isinf(view.tolerance_px);
    piece.shown = {.weight = view.weight,
                   .pose = view.pose,
                   .tolerance_px = is_outside ? view.mesh->to.frameTolerance() : view.tolerance_px,
                   .is_outside = is_outside};
    if (isTurn(terms_of_frames_)) piece.shown->terms = termsOf(player, now);
  }

  FlightPiece::Terms termsOf(const Player& player, Time now) {
    const client::FrameView& view = player.view();
    const auto sectionAt = [&](Time t) {
      return SectionRequest{
          .pose = player.path().at(t), .lens = lens_, .tau_px = view.mesh->to.tau_px, .scene_time = sceneTimeOf(view)};
    };
    FlightPiece::Terms terms{.shown = sectionAt(view.shown_time), .from = {}, .to = {}, .current = {}};
    if (strategy_ == proto::Strategy::kPredict && blend_ == client::Blend::kKeyframe) {
      terms.from = keyframeAt(player, view.mesh->from);
      terms.to = keyframeAt(player, view.mesh->to);
    }
    if (strategy_ == proto::Strategy::kCurrent) terms.current = sectionAt(now);
    return terms;
  }

  void takeMotion(const client::FrameView& view, double seconds, FlightPiece& piece) const {
    if (seconds > 0) piece.motion = {{last_weight_, view.weight}, seconds, view.pose};
  }

  // Whether the terms of what is judged are measured, of which there were `count` before.
  bool isTurn(uint64_t& count) const { return truth_.has_terms && count++ % options_.terms_every == 0; }

  // Of the ground that the frame shows.
  static Time sceneTimeOf(const client::FrameView& view) {
    const proto::KeyframeHeader &from = view.mesh->from, &to = view.mesh->to;
    return {from.scene_time.us +
            std::llround(static_cast<double>(view.weight) * static_cast<double>((to.scene_time - from.scene_time).us))};
  }

  // What a keyframe would have been, had its pose been known.
  std::shared_ptr<ExactSection> keyframeAt(const Player& player, const proto::KeyframeHeader& header) {
    return exact_.at(player.path().at(header.time), lens_, header);
  }

  void addFrame(const FlightJudgement& found) {
    truth_.frames.add(*found.shown);
    truth_.weights_judged.add(found.weight);
    addParts(*found.shown);
    truth_.uncovered_samples += found.shown->uncovered;
    truth_.frames_over_tau += found.is_over_tolerance;
    if (!found.is_outside) return;
    outside_px_.push_back(found.shown->max_px);
    truth_.outside_over_tau += found.is_over_tolerance;
  }

  void addParts(const SceneDeviation& d) {
    truth_.object_silhouette_error_px = std::max(truth_.object_silhouette_error_px, d.silhouette_px);
    truth_.object_interior_error_px = std::max(truth_.object_interior_error_px, d.interior_px);
    truth_.object_vertices_judged += d.object_vertices;
    truth_.source_error_px = std::max(truth_.source_error_px, d.sources.max_px);
    truth_.source_excess_px = std::max(truth_.source_excess_px, d.sources.excess_px);
    truth_.source_samples_judged += d.sources.samples;
  }

  const FlightTruthOptions& options_;
  proto::Strategy strategy_;
  client::Blend blend_;
  proto::Lens lens_;
  client::Exaggeration exaggeration_;
  Duration asked_interval_;
  FlightTruth truth_;
  ExactKeyframes exact_;
  std::shared_ptr<const KeyframeMesh> mesh_;  // that was shown last; null if nothing of it was judged yet
  uint32_t measured_version_ = 0, measured_keyframe_ = 0;
  bool is_keyframe_judged_ = false;
  Time last_frame_;
  double last_weight_ = 0;
  uint64_t all_frames_ = 0, replayed_ = 0, frames_ = 0, keyframes_ = 0;  // frames_: with a mesh, while flying
  uint64_t terms_of_frames_ = 0, terms_of_keyframes_ = 0;
  PixelSpread moved_px_;
  std::vector<double> outside_px_;  // errors of frames that no region covers
  double delay_sum_ms_ = 0, done_ = 0;
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
  Measurement measurement(log, options);
  std::vector<SceneOracle> twins;
  std::vector<FlightJudge> judges;
  oracle.exaggerate(log.options.exaggeration.factor);
  const unsigned workers = workerCount(options.threads);
  for (unsigned i = 0; i < workers; ++i) twins.push_back(oracle.twin());
  for (SceneOracle& twin : twins) judges.emplace_back(twin, options.sections ? options.sections() : SectionAt());
  bool goes_on = true;
  {
    OrderedWork<FlightPiece, FlightJudgement> work(
        workers, [&](const FlightPiece& piece, unsigned worker) { return judges[worker].judge(piece); },
        [&](const FlightJudgement& found) {
          measurement.take(found);
          if (goes_on && options.on_progress) goes_on = options.on_progress(measurement.done());
        });
    client::replay(log, [&](const Player& player, Time now) {
      std::optional<FlightPiece> piece = measurement.onFrame(player, now);
      if (piece) work.add(std::move(*piece));
      return goes_on;
    });
    if (goes_on) work.finish();
  }
  FlightTruth truth = measurement.finish(goes_on);
  truth.object_interior_per_tau = oracle.objects().interiorPerTau();
  return truth;
}

}  // namespace foreland::oracle
