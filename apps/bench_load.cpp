#include "apps/bench_load.h"

#include <cstdio>

#include "apps/bench_flight.h"
#include "apps/options.h"

namespace foreland::apps {

namespace {

std::string lineOf(const bench::LoadRun& run) {
  const bench::LoadFigures& f = run.figures;
  char text[240];
  std::snprintf(text, sizeof text,
                "%-12s %-12s %-5s %4zu viewers: %6.2f %% of %llu missed, lateness p99 %7.2f ms, used %.2f (peak %.2f), "
                "Jain %.3f",
                name(run.options.policy), name(run.options.phases), name(run.options.start), run.options.viewers,
                100 * f.missed_share, static_cast<unsigned long long>(f.keyframes), f.lateness_p99_ms, f.utilisation,
                f.utilisation_peak, f.jain);
  return text;
}

// Searches run one after another on each thread, so that the most viewers of each is found on its own.
void search(const std::shared_ptr<const server::World>& world, std::vector<bench::LoadOptions>& runs) {
  for (bench::LoadOptions& run : runs) run.viewers = std::max<size_t>(1, bench::mostViewers(world, run));
}

}  // namespace

CLI::App* addLoad(CLI::App& app, LoadArguments& args) {
  CLI::App* sub = app.add_subcommand("load", "many viewers on few workers, in virtual time");
  bench::LoadRequest& request = args.request;
  sub->add_option("scene", args.scene, "scene file (foreland build)")->required();
  sub->add_option("--viewers", request.base.viewers, "how many; the first guess of --most-viewers")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  sub->add_option("--workers", request.base.workers, "of the server")->check(CLI::Range(1, 64))->capture_default_str();
  sub->add_option("--mix", args.mix, "mixed or survey")->capture_default_str();
  sub->add_option("--policies", request.policies, "fifo,edf,least-laxity,fair (default: all)")->delimiter(',');
  sub->add_option("--phases", request.phases, "synchronised,random,staggered (default: all)")->delimiter(',');
  sub->add_option("--starts", request.starts, "late,early (default: both)")->delimiter(',');
  sub->add_option("--seconds", request.base.seconds, "measured")
      ->check(CLI::Range(1.0, 3600.0) & isFinite())
      ->capture_default_str();
  sub->add_option("--tau", request.base.tau_px, "tolerance in pixels")
      ->check(CLI::Range(0.05, 1000.0) & isFinite())
      ->capture_default_str();
  sub->add_option("--keyframe-ms", request.base.keyframe_ms, "keyframe interval")
      ->check(CLI::Range(20.0, 10000.0) & isFinite())
      ->capture_default_str();
  sub->add_flag_callback(
      "--most-viewers", [&args] { args.search = Search::kMostViewers; },
      "find the largest number of viewers with under 0.1 % missed, for each run");
  sub->add_flag_callback(
      "--json", [&args] { args.format = bench::ReportFormat::kJson; }, "print JSON");
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

Result<nlohmann::ordered_json> load(const LoadArguments& args) {
  bench::LoadRequest request = args.request;
  const auto mix = bench::mixNamed(args.mix);
  if (!mix) return mix.error();
  const auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  request.base.mix = *mix;
  request.base.prices = *prices;
  request.base.seed = args.experiment.seed;
  auto runs = bench::runsOf(request);
  if (!runs) return runs.error();
  const auto scene = terrain::Scene::open(args.scene);
  if (!scene) return scene.error();
  auto objects = server::objectsOf(*scene);
  if (!objects) return objects.error();
  const auto world = std::make_shared<server::World>(*scene, std::move(*objects));

  if (args.search == Search::kMostViewers) search(world, *runs);
  const Progress progress(runs->size());
  const auto results = bench::runAll(world, *runs, args.experiment.threads, [&](size_t done) { progress.show(done); });
  nlohmann::ordered_json about{{"experiment", "load"}};
  about.update(aboutExperiment(args.experiment, *prices));
  about.update({{"scene", std::filesystem::path(args.scene).filename().string()},
                {"viewers", request.base.viewers},
                {"workers", request.base.workers},
                {"mix", args.mix},
                {"seconds", request.base.seconds},
                {"tau_px", request.base.tau_px},
                {"keyframe_ms", request.base.keyframe_ms}});
  if (!args.experiment.out.empty())
    if (Status s = bench::writeLoad(args.experiment.out, about, results); !s.ok()) return s.error();
  nlohmann::ordered_json summary = about;
  summary["runs"] = nlohmann::ordered_json::array();
  for (const bench::LoadRun& run : results)
    summary["runs"].push_back(args.format == bench::ReportFormat::kJson ? bench::rowOf(run)
                                                                        : nlohmann::ordered_json(lineOf(run)));
  return summary;
}

}  // namespace foreland::apps
