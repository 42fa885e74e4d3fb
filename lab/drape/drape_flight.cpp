#include "lab/drape/drape_flight.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/quantile.h"
#include "sim/client_drape.h"
#include "sim/world.h"

namespace foreland::lab {

namespace {

// Takes note of when keyframes and frames of a flight arrive.
class ArrivalNotes {
 public:
  explicit ArrivalNotes(double tau_px) : tau_px_(tau_px) {}

  void onKeyframe(const sim::ArrivedKeyframe& keyframe) { lateness_ms_.push_back(1e3 * keyframe.lateness.toSeconds()); }
  void onFrame(const client::FrameView& view, Time now) {
    if (!view.mesh) return;
    const double now_ms = 1e-3 * static_cast<double>(now.us);
    arrivals_.first_picture_ms = std::min(arrivals_.first_picture_ms, now_ms);
    if (view.tolerance_px <= 1.0001 * tau_px_) arrivals_.tolerance_ms = std::min(arrivals_.tolerance_ms, now_ms);
  }
  DrapeArrivals take() {
    if (!lateness_ms_.empty()) arrivals_.lateness_p99_ms = quantile(lateness_ms_, 0.99);
    return arrivals_;
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  double tau_px_;
  std::vector<double> lateness_ms_;
  DrapeArrivals arrivals_{kNever, kNever, kNever};
};

sim::World worldOf(const DrapeFlight& flight) {
  return {flight.world,
          {},
          [&flight](const sim::StepWork& work) { return flight.prices.of(work); },
          flight.seed,
          sim::Laws::kTrusted};
}

sim::ClientOptions clientOf(const DrapeFlight& flight) {
  sim::ClientOptions client;
  client.request.lens = flight.lens;
  client.request.tau_px = flight.tau_px;
  client.request.predictor = flight.predictor;
  const bool is_relief = flight.scene->tiles().layers()[flight.layer].content == proto::TileContent::kRelief;
  client.request.relief = is_relief;
  client.request.imagery = !is_relief;
  client.path = flight.path;
  client.announce_path = flight.predictor == proto::Predictor::kKnownPath;
  client.up = flight.links.up;
  client.down = flight.links.down;
  return client;
}

}  // namespace

Result<DrapeExperiment> DrapeExperiment::create(const DrapeFlight& flight, double every_s) {
  std::vector<proto::Pose> poses;
  for (double at = 0; at < flight.seconds; at += every_s)
    poses.push_back(flight.poseAt(Time{} + kDrapeStanding + Duration::seconds(at)));
  auto judge = DrapeJudge::create(flight.scene, flight.lens, std::move(poses), every_s);
  if (!judge) return judge.error();
  return DrapeExperiment(flight, std::move(*judge), every_s);
}

Time DrapeExperiment::judgedAt(size_t frame) const {
  return Time{} + kDrapeStanding + Duration::seconds(every_s_ * static_cast<double>(frame));
}

DrapeExperiment::Ours DrapeExperiment::flyOurs() {
  sim::World world = worldOf(flight_);
  world.addClient(clientOf(flight_));
  sim::ClientDrape drape(flight_.scene->tiles().layers()[flight_.layer].content);
  ArrivalNotes notes(flight_.tau_px);
  world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe& keyframe) {
    notes.onKeyframe(keyframe);
    drape.onKeyframe(world.viewer(0));
  };
  size_t next = 0;
  std::optional<uint64_t> first_view_bytes;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    notes.onFrame(view, now);
    if (const auto handover = drape.handoverTo(view.mesh_version))
      judge_.compare(std::min(next, judge_.frames() - 1), image_, handover->before, handover->after);
    const double texel_px = drape.texelPx(view.mesh_version);
    const sim::DrawnTiles drawn = drape.drawn(view.mesh_version, view.weight);
    const float stated_px = world.viewer(0).statistics().texel_px[flight_.layer];
    if (!first_view_bytes && stated_px > 0 && stated_px <= server::TileSender::kTexel_px)
      first_view_bytes = world.viewer(0).statistics().tile_bytes;
    if (next >= judge_.frames() || now < judgedAt(next)) return;
    judge_.judge(next++, image_, drawn, texel_px);
  };
  world.run(end());
  const client::ViewerStatistics& statistics = world.viewer(0).statistics();
  const uint64_t bytes = world.session(0).statistics().tile_bytes;
  return {{.way = "foreland",
           .asked_px = server::TileSender::kTexel_px,
           .bytes = bytes,
           .first_view_bytes = first_view_bytes.value_or(bytes),
           .quality = judge_.take(),
           .keyframes_late = statistics.keyframes > 0 ? double(statistics.late_keyframes) / statistics.keyframes : 0},
          notes.take()};
}

DrapeArrivals DrapeExperiment::flyWithoutTiles() const {
  sim::World world = worldOf(flight_);
  sim::ClientOptions client = clientOf(flight_);
  client.request.relief = client.request.imagery = false;
  world.addClient(client);
  ArrivalNotes notes(flight_.tau_px);
  world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe& keyframe) { notes.onKeyframe(keyframe); };
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) { notes.onFrame(view, now); };
  world.run(end());
  return notes.take();
}

DrapeFigures DrapeExperiment::pull(TileRule rule, double texel_px) {
  TilePuller puller(flight_.scene, flight_.layer, flight_.lens,
                    {.rule = rule, .texel_px = texel_px, .links = flight_.links, .seed = flight_.seed});
  DrapeFigures figures{.way = rule == TileRule::kDistance ? "by distance" : "by area", .asked_px = texel_px};
  size_t next = 0;
  for (Time now; now < end(); now = now + sim::World::kFrame) {
    if (now < Time{} + kDrapeStanding) figures.first_view_bytes = puller.bytes();
    const sim::DrawnTiles before = puller.drawn();
    puller.frame(now, flight_.poseAt(now));
    if (puller.drawn() != before) judge_.compare(std::min(next, judge_.frames() - 1), image_, before, puller.drawn());
    if (next < judge_.frames() && now >= judgedAt(next))
      judge_.judge(next++, image_, puller.drawn(), std::numeric_limits<double>::infinity());
  }
  figures.bytes = puller.bytes();
  figures.quality = judge_.take();
  return figures;
}

DrapeFigures DrapeExperiment::pullForPsnr(TileRule rule, double psnr_db) {
  constexpr double kFinest_px = 0.25, kCoarsest_px = 16;
  DrapeFigures fine = pull(rule, kFinest_px), coarse = pull(rule, kCoarsest_px);
  for (int i = 0; i < 7; ++i) {
    DrapeFigures middle = pull(rule, std::sqrt(fine.asked_px * coarse.asked_px));
    (middle.quality.psnr_db >= psnr_db ? fine : coarse) = std::move(middle);
  }
  const double range_db = fine.quality.psnr_db - coarse.quality.psnr_db;
  const double share = range_db > 0 ? std::clamp((psnr_db - coarse.quality.psnr_db) / range_db, 0.0, 1.0) : 1;
  const auto between = [&](uint64_t from, uint64_t to) {
    return static_cast<uint64_t>(std::llround(std::lerp(double(from), double(to), share)));
  };
  DrapeFigures figures = share < 0.5 ? coarse : fine;
  figures.bytes = between(coarse.bytes, fine.bytes);
  figures.first_view_bytes = between(coarse.first_view_bytes, fine.first_view_bytes);
  return figures;
}

}  // namespace foreland::lab
