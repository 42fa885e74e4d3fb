#include "lab/latency/fly_cell.h"

#include <algorithm>
#include <cmath>

#include "lab/external/told_link.h"
#include "lab/external/told_motion.h"
#include "oracle/lod_motion.h"
#include "sim/world.h"

namespace foreland::lab {

namespace {

sim::ClientOptions clientOf(const LatencyFlight& flight, const LatencyCell& cell) {
  sim::ClientOptions client;
  client.request.lens = flight.lens;
  client.request.tau_px = cell.tau_px;
  client.request.strategy = cell.strategy;
  client.request.predictor = cell.predictor;
  client.request.keyframe_interval = cell.keyframes.shortest;
  client.request.longest_interval = cell.keyframes.longest;
  client.path = flight.path;
  client.announce_path = cell.strategy == proto::Strategy::kPredict && cell.predictor == proto::Predictor::kKnownPath;
  sim::LinkPair links = sim::fixedLink(Duration::seconds(1e-3 * cell.round_trip_ms));
  if (cell.link == "trace") links = *flight.trace;
  if (cell.link_command.empty() && cell.link != "trace" && cell.link != "fixed")
    links = sim::linkNamed(cell.link)->links();
  client.up = links.up;
  client.down = links.down;
  return client;
}

// The user's programs in one flight; null: ours.
struct Programs {
  std::unique_ptr<AskedProgram> predictor, link;

  static Result<Programs> start(const LatencyCell& cell, uint64_t seed) {
    Programs programs;
    const auto add = [&](const char* asked, const std::string& command, auto& out) -> Status {
      if (command.empty()) return {};
      auto program = AskedProgram::start({"--" + std::string(asked) + "-command", asked}, command, seed);
      if (!program) return program.error();
      out = std::move(*program);
      return {};
    };
    if (Status s = add("predictor", cell.predictor_command, programs.predictor); !s.ok()) return s.error();
    if (Status s = add("link", cell.link_command, programs.link); !s.ok()) return s.error();
    return programs;
  }
  Status status() const {
    for (const auto* program : {&predictor, &link})
      if (*program && !(*program)->status().ok()) return (*program)->status();
    return {};
  }
};

// Watches one flight and keeps what is measured of it.
class Recorder {
 public:
  Recorder(const LatencyFlight& flight, const LatencyCell& cell, oracle::Oracle& oracle)
      : flight_(flight),
        begin_(flight.path.start + kRunIn),
        end_(begin_ + Duration::seconds(flight.seconds)),
        judge_({flight.world, &flight.path, cell.strategy, flight.lens, cell.tau_px}, oracle) {
    result_.cell = cell;
  }

  Time end() const { return end_; }
  CellFlight take() { return std::move(result_); }

  void onFrame(const client::FrameView& view, Time now) {
    const bool is_next = last_version_ == view.mesh_version;
    if (now >= begin_ && now < end_) {
      if (flight_.judged.has(result_.shown.count)) {
        result_.frames.push_back(judge_.judge(view, now));
        if (is_next) result_.frames.back().lod_motion_px = lodMotion(view, now);
      }
      result_.shown.add(view, now);
    }
    last_version_ = view.mesh_version;
    last_weight_ = view.weight;
    last_frame_ = now;
  }

  void onKeyframe(const sim::ArrivedKeyframe& k) {
    if (k.at < begin_ || k.at >= end_) return;
    result_.keyframes.push_back({(k.at - flight_.path.start).toSeconds(), k.bytes, k.lateness.toMilliseconds(),
                                 k.computed.toMilliseconds(), k.work});
  }

 private:
  double lodMotion(const client::FrameView& view, Time now) {
    moved_px_.clear();
    oracle::collectLodMotion(*view.mesh, {last_weight_, view.weight}, view.pose, flight_.lens, moved_px_);
    const double most = moved_px_.empty() ? 0 : *std::max_element(moved_px_.begin(), moved_px_.end());
    return most / (60 * (now - last_frame_).toSeconds());
  }

  const LatencyFlight& flight_;
  Time begin_, end_;
  FrameJudge judge_;
  CellFlight result_;
  uint32_t last_version_ = 0;
  double last_weight_ = 0;
  Time last_frame_;
  std::vector<double> moved_px_;
};

}  // namespace

void ShownFrames::add(const client::FrameView& view, Time now) {
  const double frame_delay_ms = (now - view.shown_time).toMilliseconds();
  ++count;
  if (std::isinf(view.tolerance_px)) {
    ++outside;
  } else {
    tolerance_px += view.tolerance_px;
    tolerance_max_px = std::max<double>(tolerance_max_px, view.tolerance_px);
  }
  triangles += view.mesh->triangleCount();
  delay_ms += frame_delay_ms;
  delay_max_ms = std::max(delay_max_ms, frame_delay_ms);
}

CellFlight flyCell(const LatencyFlight& flight, const LatencyCell& cell, oracle::Oracle& oracle) {
  const sim::ComputeTime compute = [&prices = flight.prices](const sim::StepWork& work) { return prices.of(work); };
  const auto programs = Programs::start(cell, flight.seed);
  if (!programs) {
    CellFlight failed;
    failed.status = programs.error();
    return failed;
  }
  server::SessionOptions session;
  if (programs->predictor)
    session.foresee = [motion = std::make_shared<ToldMotion>(*programs->predictor)] { return motion->next(); };
  sim::ClientOptions client = clientOf(flight, cell);
  if (programs->link) {
    const sim::LinkPair links = toldLinks(*programs->link);
    client.up = links.up, client.down = links.down;
  }
  sim::World world(flight.world, session, compute, flight.seed, sim::Laws::kTrusted);
  world.addClient(client);
  Recorder recorder(flight, cell, oracle);
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) { recorder.onFrame(view, now); };
  world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe& k) { recorder.onKeyframe(k); };
  world.run(flight.path.start + kRunIn);
  const client::ViewerStatistics before = world.viewer(0).statistics();
  world.run(recorder.end());
  const client::ViewerStatistics& after = world.viewer(0).statistics();
  CellFlight result = recorder.take();
  result.status = programs->status();
  result.bytes_up = after.bytes_up - before.bytes_up;
  result.bytes_down = after.bytes_down - before.bytes_down;
  return result;
}

}  // namespace foreland::lab
