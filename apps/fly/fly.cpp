// `foreland fly`: flies the headless player over a WebSocket, in real time. Afterwards it dumps frames and measures
// errors, if asked to, on a replay of the flight. One thread, or one for each of --viewers. Exit code 0 when the flight
// was flown to its end, 2 otherwise.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <random>

#include "apps/fly/afterwards.h"
#include "apps/fly/flight.h"
#include "apps/fly/fly_options.h"
#include "apps/fly/fly_report.h"
#include "apps/fly/link.h"
#include "apps/fly/many_viewers.h"
#include "apps/stop_signal.h"
#include "client/fly/net/web_socket_client.h"
#include "client/fly/player.h"
#include "client/fly/recording.h"

namespace foreland::apps {

namespace {

constexpr std::chrono::nanoseconds kFrame{1'000'000'000 / 60};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland fly: %s\n", error.message.c_str());
  return 2;
}

// Records a flight as it goes, if a file is named. A recording that cannot be written does not end the flight.
class FlightRecorder {
 public:
  static Result<FlightRecorder> begin(const std::filesystem::path& file, const client::PlayerOptions& options) {
    FlightRecorder recorder;
    if (file.empty()) return recorder;
    auto writer = client::RecordingWriter::create(file, options);
    if (!writer.ok()) return writer.error();
    recorder.writer_.emplace(std::move(writer).value());
    return recorder;
  }
  void onFrame(const client::Player& player) {
    if (!writer_ || !status_.ok()) return;
    digest_.add(player.viewer(), player.view());
    status_ = writer_->append(player.log().entries);
  }
  Status finish(const client::Player& player) {
    if (!writer_ || !status_.ok()) return status_;
    if (Status s = writer_->append(player.log().entries); !s.ok()) return s;
    return writer_->finish(digest_.value());
  }

 private:
  std::optional<client::RecordingWriter> writer_;
  client::FlightDigest digest_;
  Status status_;
};

int run(const FlyOptions& o) {
  Result<client::PlayerOptions> options = playerOptions(o);
  if (!options.ok()) return fail(options.error());
  if (o.viewers > 1) return flyMany(o, *options);
  Result<Afterwards> afterwards = Afterwards::prepare(o.afterwards);
  if (!afterwards.ok()) return fail(afterwards.error());
  if (!afterwards->canJudgeSeen()) {
    if (o.occlusion == "on")
      return fail(Error{ErrorCode::kInvalidArgument,
                        "--truth cannot judge what is seen in a scene that changes in time; use --occlusion off"});
    options->request.occlusion = false;
  }
  Result<FlightRecorder> recorder = FlightRecorder::begin(o.record, *options);
  if (!recorder.ok()) return fail(recorder.error());
  auto connection = client::WebSocketClient::connect(o.url, kConnectTimeout, o.connection);
  if (!connection.ok()) return fail(connection.error());

  client::Player player(*options);
  Link link(std::move(connection).value(), o.url, o.connection, std::random_device{}());
  const auto check = [&](const client::Player& welcomed) -> Status {
    if (o.occlusion == "on" && !welcomed.viewer().welcome()->occlusion)
      return Error{ErrorCode::kUnsupported,
                   "--occlusion on: this server leaves nothing out; start it with --occlusion auto, or fly with it"};
    if (o.exaggeration != 1 && welcomed.viewer().welcome()->shape.is_cube)
      return Error{ErrorCode::kUnsupported, "--exaggeration: a globe has no one direction of height"};
    if (o.exaggeration != 1 && !o.afterwards.truth.empty() && welcomed.viewer().welcome()->shape.sparse_levels > 0)
      return Error{ErrorCode::kUnsupported,
                   "--exaggeration: ground that is fine in places is judged at its true heights; leave out --truth"};
    return afterwards->checkScene(welcomed.viewer());
  };
  const auto record = [&](const client::Player& flying) { recorder->onFrame(flying); };
  const Status flown = fly(link, player, kFrame, {check, record});
  link.close();

  int exit_code = flown.ok() ? 0 : fail(flown.error());
  if (Status s = recorder->finish(player); !s.ok()) exit_code = fail(s.error());
  FlySummary summary = summaryOf(player);
  if (!flown.ok()) summary.error = flown.error().message;
  if (summary.flight.frames == 0) return exit_code == 0 ? 2 : exit_code;  // there is nothing to report
  if (Status s = addAfterwards(*afterwards, player.log(), o.format, summary); !s.ok()) exit_code = fail(s.error());
  print(summary, o.format);
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
