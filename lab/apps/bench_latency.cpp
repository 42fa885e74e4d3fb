#include "lab/apps/bench_latency.h"

#include <cstdio>

#include "apps/options/options.h"
#include "apps/report/report.h"
#include "base/fnv1a.h"
#include "lab/apps/bench_link.h"
#include "lab/latency/experiment.h"
#include "lab/tables.h"

namespace foreland::apps {

namespace {

void addGridOptions(CLI::App& sub, lab::GridRequest& grid) {
  const auto add = [&](const char* name, auto& values, const char* what) {
    return sub.add_option(name, values, what)->delimiter(',')->group("What is compared");
  };
  add("--strategies", grid.strategies, "of the viewer; by default all")
      ->type_name(text("NAMES"))
      ->check(oneOf({"delay", "current", "predict"}));
  add("--predictors", grid.predictors, "of predict; by default all")
      ->type_name(text("NAMES"))
      ->check(oneOf({"hold", "velocity", "acceleration", "double-exponential", "kalman", "path"}));
  add("--round-trips", grid.round_trips_ms, "of the link `fixed`, in milliseconds; by default 0,50,100,200,400")
      ->type_name(number("MS"));
  add("--links", grid.links, "by default fixed")
      ->type_name(text("NAMES"))
      ->check(oneOf({"fixed", "wifi", "lte", "starlink", "geo", "trace"}));
  sub.add_option("--predictor-command", grid.predictor_command,
                 "one more predictor, which is a program (docs/INSTRUMENT.md)")
      ->type_name(text("COMMAND"))
      ->group("What is compared");
  sub.add_option("--link-command", grid.link_command, "one more link, which is a program (docs/INSTRUMENT.md)")
      ->type_name(text("COMMAND"))
      ->group("What is compared");
  add("--keyframes-ms", grid.keyframes_ms,
      "intervals, which may be adaptive or such as 100-500; by default 200, and 100, 500 and adaptive for some")
      ->type_name(numberOrText("MS"));
  add("--taus", grid.taus_px, "tolerances in pixels; by default 1, and 2 for some")->type_name(number("PX"));
  sub.add_flag_callback(
         "--full", [&grid] { grid.size = lab::GridSize::kFull; }, "all combinations, with tolerances of 0.5, 1 and 2")
      ->group("What is compared");
}

// The recorded link, if there is one; it has no latency of its own.
Result<std::optional<sim::LinkPair>> traceOf(const LatencyArguments& args) {
  const bool is_wanted = std::find(args.grid.links.begin(), args.grid.links.end(), "trace") != args.grid.links.end();
  if (!is_wanted && args.trace_down.empty() && args.trace_up.empty()) return std::optional<sim::LinkPair>();
  if (!is_wanted || args.trace_down.empty() || args.trace_up.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "a recorded link takes --links trace, --trace-up FILE and --trace-down FILE"};
  auto pair = recordedLink(args.trace_up, args.trace_down);
  if (!pair) return pair.error();
  return std::optional(std::move(*pair));
}

Result<lab::LatencyFlight> flightOf(const LatencyArguments& args, const PlannedFlight& planned) {
  auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  auto trace = traceOf(args);
  if (!trace) return trace.error();
  auto judged = lab::JudgedFrames::atRate(args.judge_hz);
  if (!judged) return judged.error();
  const auto world = server::openWorld(planned.scene);
  if (!world) return world.error();
  lab::LatencyFlight flight{.world = *world,
                            .path = planned.path,
                            .seconds = args.flight.flight.seconds,
                            .judged = *judged,
                            .lens = {1.0471975511965976, args.width_px, args.height_px},
                            .prices = *prices,
                            .trace = *trace,
                            .seed = args.experiment.seed};
  flight.path.start = Time{} + lab::kStanding;
  if ((flight.path.end() - flight.path.start - lab::kRunIn).toSeconds() < flight.seconds) {
    char text[160];
    std::snprintf(text, sizeof text, "the track is flown for %.1f s only; ask for at most %.0f --seconds",
                  (flight.path.end() - flight.path.start).toSeconds(),
                  (flight.path.end() - flight.path.start - lab::kRunIn).toSeconds());
    return Error{ErrorCode::kInvalidArgument, text};
  }
  return flight;
}

nlohmann::ordered_json summaryOf(const std::vector<lab::LatencyCell>& cells,
                                 const std::vector<lab::CellTables>& tables) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  uint64_t violations = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    const lab::LatencyCell& c = cells[i];
    const nlohmann::ordered_json& row = tables[i].row;
    violations += row["bound_violations"].get<uint64_t>();
    char text[240];
    std::snprintf(
        text, sizeof text, "%-26s %-8s %3.0f ms, %s ms, %.1f px: total p99 %6.2f px, rms %.3f px, %5.0f kbit/s",
        c.how().c_str(), c.linkText().c_str(), c.round_trip_ms, proto::textOf(c.keyframes).c_str(), c.tau_px,
        row["total_p99_px"].get<double>(), row["total_rms_px"].get<double>(), row["down_kbit_s"].get<double>());
    lines.push_back(text);
  }
  return {{"cells", std::move(lines)}, {"bound_violations", violations}};
}

// Of the files that a path and a link were read from, their names say too little.
uint64_t digestOf(const lab::LatencyFlight& flight) {
  Fnv1a hash;
  addPath(flight.path, hash);
  if (flight.trace) addRecordings(*flight.trace, hash);
  return hash.value();
}

}  // namespace

CLI::App* addLatency(CLI::App& app, LatencyArguments& args) {
  CLI::App* sub =
      app.add_subcommand("latency", "error against latency, for strategies, predictors, links and intervals");
  args.flight.flight.seconds = 6;
  addPathOptions(*sub, args.flight);
  addGridOptions(*sub, args.grid);
  sub->add_option("--trace-up", args.trace_up, "mahimahi trace of the link `trace`, to the server")
      ->type_name(file("FILE"));
  sub->add_option("--trace-down", args.trace_down, "mahimahi trace of the link `trace`, to the viewer")
      ->type_name(file("FILE"));
  sub->add_option("--judge-hz", args.judge_hz,
                  "frames judged a second, which takes most of the time: 10 or a whole part of it, such as 5, 2 or 0.5")
      ->type_name(number("HZ"))
      ->capture_default_str();
  addScreenOptions(*sub, args.width_px, args.height_px);
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

Status checkArguments(const LatencyArguments& args) {
  if (const auto cells = lab::cellsOf(args.grid); !cells) return cells.error();
  if (const auto prices = pricesOf(args.experiment); !prices) return prices.error();
  if (const auto trace = traceOf(args); !trace) return trace.error();
  if (const auto judged = lab::JudgedFrames::atRate(args.judge_hz); !judged) return judged.error();
  return {};
}

Result<nlohmann::ordered_json> latency(const LatencyArguments& args) {
  const auto cells = lab::cellsOf(args.grid);
  if (!cells) return cells.error();
  FlightArguments longer = args.flight;
  longer.flight.seconds += lab::kRunIn.toSeconds() + 1;
  const auto planned = planFlightOverPlane(longer);
  if (!planned) return planned.error();
  const auto flight = flightOf(args, *planned);
  if (!flight) return flight.error();
  nlohmann::ordered_json about{{"experiment", "latency"}};
  about.update(aboutExperiment(args.experiment, flight->prices));
  about["scene"] = std::filesystem::path(args.flight.scene).filename().string();
  about.update(flightReport(args.flight, *planned));
  about["seconds"] = flight->seconds;
  about["judge_hz"] = flight->judged.hz();
  about["viewport"] = std::to_string(args.width_px) + "x" + std::to_string(args.height_px);
  nlohmann::ordered_json asked = askedOf(about, *planned->scene);
  asked["flight"] = digestOf(*flight);
  const Progress progress(cells->size());
  const auto tables = lab::flyGrid(*flight, *cells, asked, lab::KeptCells(args.experiment.cells),
                                   args.experiment.threads, [&](size_t done) { progress.show(done); });
  if (!tables) return tables.error();
  nlohmann::ordered_json summary = about;
  summary.update(summaryOf(*cells, *tables));
  if (!args.experiment.out.empty()) {
    if (Status s = lab::writeCells(args.experiment.out, about, lab::kLatencyNames, *tables); !s.ok()) return s.error();
    summary["out"] = args.experiment.out.string();
  }
  if (Status s = lab::checkBound(*tables); !s.ok()) return s.error();
  return summary;
}

}  // namespace foreland::apps
