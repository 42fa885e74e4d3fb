#include "apps/bench_latency.h"

#include <cstdio>

#include "bench/latency/experiment.h"
#include "bench/report.h"
#include "bench/tables.h"

namespace foreland::apps {

namespace {

void addGridOptions(CLI::App& sub, bench::GridRequest& grid) {
  sub.add_option("--strategies", grid.strategies, "delay,current,predict (default: all)")->delimiter(',');
  sub.add_option("--predictors", grid.predictors, "of predict: " + proto::predictorNames() + " (default: all)")
      ->delimiter(',');
  sub.add_option("--round-trips", grid.round_trips_ms, "of the link `fixed`, in ms (default: 0,50,100,200,400)")
      ->delimiter(',');
  sub.add_option("--links", grid.links, "fixed, wifi, lte, starlink, geo, trace (default: fixed)")->delimiter(',');
  sub.add_option("--keyframes-ms", grid.keyframes_ms, "intervals (default: 200, and 100 and 500 for some)")
      ->delimiter(',');
  sub.add_option("--taus", grid.taus_px, "tolerances in pixels (default: 1, and 2 for some)")->delimiter(',');
  sub.add_flag_callback(
      "--full", [&grid] { grid.size = bench::GridSize::kFull; }, "all combinations, with tolerances of 0.5, 1 and 2");
}

// The recorded link, if there is one; it has no latency of its own.
Result<std::optional<bench::LinkPair>> traceOf(const LatencyArguments& args) {
  const bool is_wanted = std::find(args.grid.links.begin(), args.grid.links.end(), "trace") != args.grid.links.end();
  if (!is_wanted && args.trace_down.empty() && args.trace_up.empty()) return std::optional<bench::LinkPair>();
  if (!is_wanted || args.trace_down.empty() || args.trace_up.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "a recorded link takes --links trace, --trace-up FILE and --trace-down FILE"};
  const auto up = bench::LinkTrace::read(args.trace_up), down = bench::LinkTrace::read(args.trace_down);
  if (!up) return up.error();
  if (!down) return down.error();
  bench::LinkPair pair = bench::fixedLink(Duration::milliseconds(40));
  pair.up.trace = std::make_shared<bench::LinkTrace>(*up);
  pair.down.trace = std::make_shared<bench::LinkTrace>(*down);
  return std::optional(pair);
}

Result<bench::LatencyFlight> flightOf(const LatencyArguments& args, const PlannedFlight& planned) {
  auto objects = server::objectsOf(planned.scene);
  if (!objects) return objects.error();
  auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  auto trace = traceOf(args);
  if (!trace) return trace.error();
  bench::LatencyFlight flight{.world = std::make_shared<server::World>(planned.scene, std::move(*objects)),
                              .path = planned.path,
                              .seconds = args.flight.flight.seconds,
                              .lens = {1.0471975511965976, args.width_px, args.height_px},
                              .prices = *prices,
                              .trace = *trace,
                              .seed = args.experiment.seed};
  flight.path.start = Time{} + bench::kStanding;
  if ((flight.path.end() - flight.path.start - bench::kRunIn).toSeconds() < flight.seconds) {
    char text[160];
    std::snprintf(text, sizeof text, "the track is flown for %.1f s only; ask for at most %.0f --seconds",
                  (flight.path.end() - flight.path.start).toSeconds(),
                  (flight.path.end() - flight.path.start - bench::kRunIn).toSeconds());
    return Error{ErrorCode::kInvalidArgument, text};
  }
  return flight;
}

nlohmann::ordered_json summaryOf(const bench::LatencyResult& result) {
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  uint64_t violations = 0;
  for (const bench::CellFigures& c : result.cells) {
    violations += c.bound_violations;
    char text[240];
    std::snprintf(text, sizeof text,
                  "%-26s %-8s %3.0f ms, %3.0f ms, %.1f px: total p99 %6.2f px, rms %.3f px, %5.0f kbit/s",
                  c.cell.how().c_str(), c.cell.link.c_str(), c.cell.round_trip_ms, c.cell.keyframe_ms, c.cell.tau_px,
                  c.terms[0].p99_px, c.terms[0].rms_px, c.down_kbit_s);
    cells.push_back(text);
  }
  return {{"cells", std::move(cells)}, {"bound_violations", violations}};
}

}  // namespace

CLI::App* addLatency(CLI::App& app, LatencyArguments& args) {
  CLI::App* sub =
      app.add_subcommand("latency", "error against latency, for strategies, predictors, links and intervals");
  args.flight.flight.seconds = 6;
  addPathOptions(*sub, args.flight);
  addGridOptions(*sub, args.grid);
  sub->add_option("--trace-up", args.trace_up, "mahimahi trace of the link `trace`, to the server");
  sub->add_option("--trace-down", args.trace_down, "mahimahi trace of the link `trace`, to the viewer");
  addScreenOptions(*sub, args.width_px, args.height_px);
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

Result<nlohmann::ordered_json> latency(const LatencyArguments& args) {
  const auto cells = bench::cellsOf(args.grid);
  if (!cells) return cells.error();
  FlightArguments longer = args.flight;
  longer.flight.seconds += bench::kRunIn.toSeconds() + 1;
  const auto planned = planFlight(longer);
  if (!planned) return planned.error();
  const auto flight = flightOf(args, *planned);
  if (!flight) return flight.error();
  const Progress progress(cells->size());
  const bench::LatencyResult result =
      bench::flyGrid(*flight, *cells, args.experiment.threads, [&](size_t done) { progress.show(done); });

  nlohmann::ordered_json about{{"experiment", "latency"}};
  about.update(aboutExperiment(args.experiment, flight->prices));
  about["scene"] = std::filesystem::path(args.flight.scene).filename().string();
  about.update(flightReport(args.flight, *planned));
  about["seconds"] = flight->seconds;
  about["viewport"] = std::to_string(args.width_px) + "x" + std::to_string(args.height_px);
  nlohmann::ordered_json summary = about;
  summary.update(summaryOf(result));
  if (args.experiment.out.empty()) return summary;
  if (Status s = bench::writeLatency(args.experiment.out, about, result); !s.ok()) return s.error();
  summary["out"] = args.experiment.out.string();
  return summary;
}

}  // namespace foreland::apps
