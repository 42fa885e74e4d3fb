// `foreland replay FILE`: flies a flight again that `foreland fly --record` recorded, as fast as it can, and reports as
// `fly` does; with --truth and --dump, too. Exit code 0 if it shows what the flight showed; 1 if it does not; 2 if it
// cannot be replayed. Main thread.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/fly/afterwards.h"
#include "apps/fly/fly_report.h"
#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "apps/stop_signal.h"
#include "client/fly/flight_digest.h"
#include "client/fly/recording.h"

namespace foreland::apps {

namespace {

struct ReplayOptions {
  std::filesystem::path recording;
  AfterwardsOptions afterwards;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

constexpr const char* kExitCodes = R"(
Exit code: 0 when the replay shows what the flight showed, as far as the recording goes; 1 when its sections, or what is
drawn, are others; 2 when it cannot be replayed.)";

int fail(const Error& error) {
  std::fprintf(stderr, "foreland replay: %s\n", error.message.c_str());
  return 2;
}

int compare(const ReplayedDigest& replayed, const std::string& file) {
  if (!replayed.recorded || replayed.shown == *replayed.recorded) return 0;
  const bool same_sections = replayed.shown.sections == replayed.recorded->sections;
  std::fprintf(stderr, "foreland replay: %s: %s\n", file.c_str(),
               same_sections ? "the sections are the same, but what is drawn is not, as after a change of the client "
                               "or with another compiler"
                             : "other sections than the flight's: the recording or the client has changed");
  return 1;
}

int run(const ReplayOptions& o) {
  Result<Afterwards> afterwards = Afterwards::prepare(o.afterwards);
  if (!afterwards.ok()) return fail(afterwards.error());
  const Result<client::Recording> recording = client::readRecording(o.recording);
  if (!recording.ok()) return fail(recording.error());

  client::FlightDigest digest;
  Status status;
  const client::Replayed replayed = client::replay(recording->log, [&](const client::Player& player, Time) {
    status = isStopRequested() ? Error{ErrorCode::kIo, "interrupted"} : afterwards->checkScene(player.viewer());
    digest.add(player.viewer(), player.view());
    return status.ok();
  });
  if (!status.ok()) return fail(status.error());
  FlySummary summary = summaryOf(replayed.player);
  if (!replayed.status.ok()) summary.error = replayed.status.error().message;
  summary.replayed = ReplayedDigest{digest.value(), recording->shown};
  const Status added = addAfterwards(*afterwards, recording->log, o.format, summary);
  print(summary, o.format);
  if (!added.ok()) return fail(added.error());
  return compare(*summary.replayed, o.recording.string());
}

int main(int argc, char** argv) {
  ReplayOptions o;
  CLI::App app("Flies a recorded flight again, and reports.", "foreland replay");
  app.footer(std::string(reportHelp()) + kExitCodes);
  app.add_option("FILE", o.recording, "written by `foreland fly --record`, or saved by the page")
      ->type_name(file("FILE"))
      ->required();
  addAfterwardsOptions(app, o.afterwards);
  app.add_flag_callback(
         "--json", [&o] { o.format = apps::ReportFormat::kJson; }, "print the report as JSON")
      ->group("The report");
  const auto exit_code =
      parseCommandLine(app, argc, argv,
                       {{"record a flight", "foreland fly ws://127.0.0.1:8080 --tour canyon --record flight.rec"},
                        {"fly it again, and measure it", "foreland replay flight.rec --truth hills.fls"}});
  if (exit_code) return *exit_code;
  catchStopSignals();
  return run(o);
}

}  // namespace

}  // namespace foreland::apps

int main(int argc, char** argv) { return foreland::apps::main(argc, argv); }
