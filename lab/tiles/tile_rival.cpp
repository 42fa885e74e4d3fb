#include "lab/tiles/tile_rival.h"

#include <algorithm>
#include <cmath>

#include "lab/tables.h"
#include "oracle/lod_motion.h"
#include "sim/world.h"

namespace foreland::lab {

namespace {

constexpr Duration kFrame = sim::World::kFrame;
constexpr int64_t kJudgeEvery = 61, kMotionEvery = 7;  // frames; coprime to those between two keyframes

Time endOf(const RivalFlight& flight) { return Time{} + kTilesStanding + Duration::seconds(flight.seconds); }

// What both ways of flying are judged by.
class Judge {
 public:
  Judge(const RivalFlight& flight, oracle::Oracle& oracle) : flight_(flight), oracle_(oracle) {}

  bool isInFlight(Time now) const { return now >= Time{} + kTilesStanding && now < endOf(flight_); }
  bool isJudged() const { return frames_ % kJudgeEvery == 0; }

  // Of any frame.
  void look(Time now, uint64_t bytes, size_t triangles, bool is_settled) {
    if (looked_at_++ % kLookEvery == 0)
      figures_.looks.push_back({(now - Time{}).toSeconds(), bytes, triangles, is_settled});
  }
  // Of a frame in flight.
  void note(size_t triangles, double jump_px, bool is_settled) {
    ++frames_;
    figures_.triangles += static_cast<double>(triangles);
    figures_.jump_max_px = std::max(figures_.jump_max_px, jump_px);
    unsettled_ = is_settled ? 0 : unsettled_ + 1;
    unsettled_frames_ += !is_settled;
    figures_.unsettled_longest_ms =
        std::max(figures_.unsettled_longest_ms, (kFrame * static_cast<int64_t>(unsettled_)).toMilliseconds());
  }
  void judge(const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose) {
    const std::array<oracle::DrawnShare, 1> drawn{oracle::DrawnShare{&mesh, weight, 1}};
    const oracle::Deviation d = oracle_.error(drawn, pose, flight_.lens);
    figures_.max_px = std::max(figures_.max_px, d.max_px);
    squares_ += d.rms_px * d.rms_px;
    ++judged_;
  }
  RivalFigures take() {
    const auto n = static_cast<double>(std::max<uint64_t>(frames_, 1));
    figures_.triangles /= n;
    figures_.unsettled_share = static_cast<double>(unsettled_frames_) / n;
    figures_.rms_px = judged_ > 0 ? std::sqrt(squares_ / static_cast<double>(judged_)) : 0;
    return figures_;
  }

 private:
  const RivalFlight& flight_;
  oracle::Oracle& oracle_;
  RivalFigures figures_;
  int64_t looked_at_ = 0;
  uint64_t frames_ = 0, unsettled_ = 0, unsettled_frames_ = 0, judged_ = 0;
  double squares_ = 0;
};

}  // namespace

CellTables tablesOf(const RivalFigures& figures) {
  CsvTable looks;
  for (const RivalLook& look : figures.looks) {
    looks.begin();
    looks.cell("time_s", rounded(look.time_s));
    looks.cell("bytes", std::to_string(look.bytes));
    looks.cell("triangles", std::to_string(look.triangles));
    looks.cell("settled", look.is_settled ? "1" : "0");
    looks.end();
  }
  return {apps::toJson(figures), {{"over_time.csv", looks.text()}}};
}

proto::Path withJump(const proto::Path& path, double seconds) {
  proto::Path jumping = path;
  const auto flown = static_cast<size_t>(seconds / path.step.toSeconds());
  for (size_t i = flown / 2; i < path.poses.size(); ++i)
    jumping.poses[i] = path.poses[(i + path.poses.size() / 4) % path.poses.size()];
  return jumping;
}

RivalFigures flyOurs(const RivalFlight& flight, oracle::Oracle& oracle) {
  sim::ClientOptions client;
  client.request.lens = flight.lens;
  client.request.tau_px = flight.tau_px;
  client.path = flight.path;
  client.up = flight.links.up;
  client.down = flight.links.down;
  Duration computed;
  const auto compute = [&](const sim::StepWork& work) {
    const Duration took = flight.prices.of(work);
    computed = computed + took;
    return took;
  };
  sim::World world(flight.world, {}, compute, flight.seed, sim::Laws::kTrusted);
  world.addClient(client);
  Judge judge(flight, oracle);
  uint32_t version = 0;
  double weight = 0;
  int64_t frame = 0;
  std::vector<double> moved_px;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    const bool is_moving = view.mesh_version == version && frame++ % kMotionEvery == 0;
    moved_px.assign(1, 0);
    if (is_moving && judge.isInFlight(now))
      oracle::collectLodMotion(*view.mesh, {weight, view.weight}, view.pose, flight.lens, moved_px);
    version = view.mesh_version, weight = view.weight;
    const bool is_settled = view.tolerance_px <= 1.001 * flight.tau_px;
    judge.look(now, world.viewer(0).statistics().bytes_down, view.mesh->triangleCount(), is_settled);
    if (!judge.isInFlight(now)) return;
    if (judge.isJudged()) judge.judge(*view.mesh, view.weight, view.pose);
    judge.note(view.mesh->triangleCount(), *std::max_element(moved_px.begin(), moved_px.end()), is_settled);
  };
  world.run(Time{} + kTilesStanding);
  const auto requests = [&] { return world.traffic(0).poses.messages + world.traffic(0).other_up.messages; };
  const uint64_t before = world.viewer(0).statistics().bytes_down, requests_before = requests();
  const Duration computed_before = computed;
  world.run(endOf(flight));
  RivalFigures figures = judge.take();
  figures.way = "foreland";
  figures.asked_px = flight.tau_px;
  figures.bytes = figures.bytes_once = world.viewer(0).statistics().bytes_down;
  figures.bytes_in_flight = figures.bytes - before;
  figures.requests = requests();
  figures.requests_in_flight = figures.requests - requests_before;
  figures.compute_ms = computed.toMilliseconds();
  figures.compute_in_flight_ms = (computed - computed_before).toMilliseconds();
  return figures;
}

Result<RivalFigures> flyTiles(const RivalFlight& flight, const TileOptions& options, TileTree& tree,
                              oracle::Oracle& oracle) {
  TileClient client(tree, options);
  Judge judge(flight, oracle);
  uint64_t before = 0, requests_before = 0;
  for (Time now; now < endOf(flight); now = now + kFrame) {
    const proto::Pose pose = flight.path.at(now);
    const auto frame = client.frame(now, pose);
    if (!frame) return frame.error();
    judge.look(now, client.statistics().bytes, frame->triangles, frame->is_complete);
    if (!judge.isInFlight(now)) {
      before = client.statistics().bytes, requests_before = client.statistics().requests;
      continue;
    }
    if (judge.isJudged()) judge.judge(tree.drawn(frame->drawn, pose.eye), 1, pose);
    judge.note(frame->triangles, frame->jump_px, frame->is_complete);
  }
  RivalFigures figures = judge.take();
  figures.way = options.codec == TileCodec::kDraco ? "draco" : "quantized-mesh";
  figures.asked_px = options.max_error_px;
  figures.bytes = client.statistics().bytes;
  figures.bytes_once = client.statistics().bytes_once;
  figures.bytes_in_flight = figures.bytes - before;
  figures.requests = client.statistics().requests;
  figures.requests_in_flight = figures.requests - requests_before;
  return figures;
}

Result<double> errorForRms(const RivalFlight& flight, double rms_px, TileTree& tree, oracle::Oracle& oracle) {
  double low = 0.1, high = 100;
  while (high > 1.05 * low) {
    TileOptions options{.lens = flight.lens, .max_error_px = std::sqrt(low * high), .links = flight.links};
    const auto figures = flyTiles(flight, options, tree, oracle);
    if (!figures) return figures.error();
    (figures->rms_px < rms_px ? low : high) = options.max_error_px;
  }
  return std::sqrt(low * high);
}

}  // namespace foreland::lab
