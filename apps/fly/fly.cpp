// `foreland fly`: flies the headless player over a WebSocket, in real time. Afterwards it dumps frames and measures
// errors, if asked to, on a replay of the flight. One thread, or one for each of --viewers. Exit code 0 when the flight
// was flown to its end, 2 otherwise.
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>

#include "apps/exact_sections.h"
#include "apps/fly/flight.h"
#include "apps/fly/fly_options.h"
#include "apps/fly/fly_report.h"
#include "apps/fly/link.h"
#include "apps/fly/many_viewers.h"
#include "apps/stop_signal.h"
#include "bench/oracle/scene_truth.h"
#include "client/fly/frame_dump.h"
#include "client/fly/net/web_socket_client.h"
#include "client/fly/player.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

namespace {

constexpr std::chrono::nanoseconds kFrame{1'000'000'000 / 60};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland fly: %s\n", error.message.c_str());
  return 2;
}

// The files that the options name, opened before the flight so that mistakes are reported at once.
struct Ground {
  std::shared_ptr<const terrain::Scene> truth;
  std::optional<bench::SceneOracle> oracle;  // of `truth`
  std::optional<client::FrameDump> dump;
};

Result<Ground> prepare(const FlyOptions& o) {
  Ground ground;
  if (!o.truth.empty()) {
    auto scene = terrain::Scene::open(o.truth);
    if (!scene.ok()) return scene.error();
    ground.truth = *scene;
    auto oracle = bench::sceneOracle(*scene);
    if (!oracle.ok()) return oracle.error();
    ground.oracle.emplace(std::move(oracle).value());
  }
  if (!o.dump.empty()) {
    auto dump = client::FrameDump::create(o.dump);
    if (!dump.ok()) return dump.error();
    ground.dump = std::move(dump).value();
  }
  return ground;
}

Status checkScene(const client::Player& player, const Ground& ground, const FlyOptions& o) {
  const auto& welcome = player.viewer().welcome();
  if (!welcome || !ground.truth || welcome->scene_id == ground.truth->id()) return {};
  return Error{ErrorCode::kInvalidArgument, "--truth " + o.truth.string() +
                                                " is not the scene that the server shows ('" + welcome->title +
                                                "'); name that scene's file"};
}

Status dumpFlight(const client::FlightLog& log, uint32_t every, client::FrameDump& dump) {
  Status status;
  uint64_t number = 0;
  client::replay(log, [&](const client::Player& player, Time now) {
    if (player.phase() != client::Player::Phase::kFlying && player.phase() != client::Player::Phase::kDone) return true;
    const client::FrameView& view = player.view();
    const uint64_t n = number++;
    if (n % every != 0 || !view.mesh) return true;
    status =
        dump.write({n, (now - player.path().start).toSeconds(), (view.scene_time - player.path().start).toSeconds()},
                   view, log.options.request);
    return status.ok();
  });
  return status;
}

bench::FlightTruth measure(const client::FlightLog& log, const Ground& ground, bench::SceneOracle& oracle,
                           const FlyOptions& o, double flown_s) {
  bench::FlightTruthOptions options{
      .frame_every = o.truth_every, .section_at = exactSections(ground.truth), .on_progress = {}};
  double told_s = 0;
  options.on_progress = [&](const bench::FlightTruth& truth) {
    if (truth.seconds < told_s + 5) return;
    told_s = truth.seconds;
    std::fprintf(stderr, "measured %.0f of %.0f s\n", truth.seconds, flown_s);
  };
  return bench::measureFlight(log, oracle, options);
}

int run(const FlyOptions& o) {
  Result<client::PlayerOptions> options = playerOptions(o);
  if (!options.ok()) return fail(options.error());
  if (o.viewers > 1) return flyMany(o, *options);
  Result<Ground> ground = prepare(o);
  if (!ground.ok()) return fail(ground.error());
  auto connection = client::WebSocketClient::connect(o.url, kConnectTimeout);
  if (!connection.ok()) return fail(connection.error());

  client::Player player(*options);
  Link link(std::move(connection).value(), o.url, std::random_device{}());
  const Status flown =
      fly(link, player, kFrame, [&](const client::Player& welcomed) { return checkScene(welcomed, *ground, o); });
  link.close();

  FlySummary summary{.request = options->request,
                     .blend = options->blend,
                     .flight = player.report(),
                     .truth = {},
                     .notes = {},
                     .error = {}};
  if (options->track) summary.notes = options->track->notes;
  summary.notes.insert(summary.notes.end(), player.notes().begin(), player.notes().end());
  int exit_code = flown.ok() ? 0 : fail(flown.error());
  if (!flown.ok()) summary.error = flown.error().message;
  if (summary.flight.frames == 0) return exit_code == 0 ? 2 : exit_code;  // there is nothing to report
  if (ground->dump) {
    if (Status s = dumpFlight(player.log(), o.dump_every, *ground->dump); !s.ok()) exit_code = fail(s.error());
    summary.dumped_frames = ground->dump->written();
  }
  if (ground->truth) { summary.truth = measure(player.log(), *ground, *ground->oracle, o, summary.flight.seconds); }
  std::fputs(text(summary, o.format).c_str(), stdout);
  return exit_code;
}

}  // namespace

}  // namespace foreland::apps

int main(int argc, char** argv) {
  const foreland::apps::ParsedFlyOptions parsed = foreland::apps::parseFlyOptions(argc, argv);
  if (parsed.exit_code) return *parsed.exit_code;
  foreland::apps::catchStopSignals();
  return foreland::apps::run(parsed.options);
}
