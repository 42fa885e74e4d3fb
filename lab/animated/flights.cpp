#include "lab/animated/flights.h"

#include <algorithm>
#include <cmath>

#include "oracle/scene_truth.h"
#include "sim/world.h"

namespace foreland::lab {

Result<AnimatedFlight> flyAnimated(const std::shared_ptr<const server::World>& world,
                                   const std::shared_ptr<const terrain::Scene>& scene, const proto::Path& path,
                                   const FlightOptions& options, double rate, uint32_t judge_every) {
  constexpr double kStanding_s = 1, kStillSlack_px = 0.01;
  auto oracle = oracle::sceneOracle(scene);
  if (!oracle) return oracle.error();
  sim::World flown(
      world, {}, [](const sim::StepWork&) { return Duration::milliseconds(8); }, 1, sim::Laws::kTrusted);
  sim::ClientOptions client;
  client.request.lens = options.lens;
  client.request.tau_px = options.tau_px;
  client.request.strategy = proto::Strategy::kPredict;
  client.request.predictor = proto::Predictor::kKnownPath;
  client.request.keyframe_interval = options.keyframe_interval;
  client.path = path;
  client.path.start = Time::seconds(kStanding_s);
  client.announce_path = true;
  bool is_set = false;
  client.at_frame = [&](client::Viewer& viewer, Time) {
    if (!std::exchange(is_set, true))
      viewer.setSceneClock({client.path.start, world->hierarchy.epochs().epochs().first(), rate});
  };
  AnimatedFlight figures;
  uint64_t frames = 0;
  flown.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (now < client.path.start || frames++ % judge_every != 0 || std::isinf(view.tolerance_px)) return;
    const double error_px = oracle->error(*view.mesh, view.weight, view.pose, options.lens, view.tolerance_px).max_px;
    figures.max_error_px_frames = std::max(figures.max_error_px_frames, error_px);
    figures.frames_over_tau += error_px > view.tolerance_px + kStillSlack_px ? 1 : 0;
    ++figures.frames_judged;
  };
  flown.addClient(client);
  flown.run(Time::seconds(kStanding_s + options.seconds));
  const client::ViewerStatistics& s = flown.viewer(0).statistics();
  figures.bytes_down = s.bytes_down;
  figures.keyframes = s.keyframes;
  figures.late_keyframes = s.late_keyframes;
  return figures;
}

}  // namespace foreland::lab
