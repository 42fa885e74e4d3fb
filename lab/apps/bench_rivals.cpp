#include "lab/apps/bench_rivals.h"

#include "apps/options/options.h"
#include "lab/programs/run_program.h"
#include "lab/programs/temporary_folder.h"
#include "lab/programs/write_file.h"

namespace foreland::apps {

namespace {

namespace fs = std::filesystem;

Status checkInstalled(const fs::path& sources) {
  std::error_code ignored;
  if (!fs::exists(sources / "measure.mjs", ignored))
    return Error{ErrorCode::kNotFound, sources.string() +
                                           " has no measure.mjs; rivals are flown from the sources: name their "
                                           "lab/rivals by --sources"};
  if (fs::exists(sources / "node_modules/cesium/package.json", ignored)) return {};
  return Error{ErrorCode::kNotFound, "the rivals are not installed; run: npm ci --prefix " + sources.string()};
}

nlohmann::ordered_json linkOf(const LinkArguments& link) {
  nlohmann::ordered_json words{"--model", link.link == "trace" ? "fixed" : link.link};
  if (link.link != "trace") return words;
  for (const auto& [name, value] : {std::pair<const char*, std::string>{"--round-trip", "40"},
                                    {"--trace-up", fs::absolute(link.trace_up).string()},
                                    {"--trace-down", fs::absolute(link.trace_down).string()}}) {
    words.push_back(name);
    words.push_back(value);
  }
  return words;
}

Result<nlohmann::ordered_json> planOf(const RivalsArguments& args, const PlannedFlight& planned,
                                      const fs::path& folder) {
  auto plan = lab::writeFlightPlan({.scene = planned.scene,
                                    .scene_path = args.flight.scene,
                                    .path = planned.path,
                                    .seconds = planned.options.seconds,
                                    .poses_per_s = args.poses_per_s,
                                    .tau_px = planned.options.tau_px},
                                   folder);
  if (!plan) return plan.error();
  std::error_code ignored;
  plan->update({{"programs", fs::read_symlink("/proc/self/exe", ignored).parent_path().string()},
                {"keyframe_ms", args.flight.keyframe_ms},
                {"link", linkOf(args.link)},
                {"rivals", args.rivals},
                {"qualities", args.qualities},
                {"protocol", args.protocol},
                {"predictor", args.predictor}});
  return plan;
}

}  // namespace

CLI::App* addRivals(CLI::App& app, RivalsArguments& args) {
  CLI::App* sub =
      app.add_subcommand("rivals", "one flight in a browser, by us and by CesiumJS, MapLibre and 3DTilesRendererJS");
  args.flight.flight.seconds = 10;
  addFlightOptions(*sub, args.flight);
  addLinkOptions(*sub, args.link, "wifi");
  sub->add_option("--poses", args.poses_per_s, "that are shown in a second")
      ->type_name(number("HZ"))
      ->check(within(1.0, 60.0))
      ->capture_default_str();
  sub->add_option("--rival", args.rivals, "that are flown beside us; default: all")
      ->type_name(text("NAME"))
      ->check(oneOf({"cesium", "maplibre", "3d-tiles"}));
  sub->add_option("--quality", args.qualities, "of the rivals, in pixels of their own measure; default: some for each")
      ->type_name(number("PX"))
      ->check(within(0.05, 1000.0));
  sub->add_option("--protocol", args.protocol,
                  "by which tiles are fetched: http2 by nginx, or http1, where each connection has a link of its own")
      ->type_name(text("NAME"))
      ->check(oneOf({"http1", "http2"}))
      ->capture_default_str();
  sub->add_option("--predictor", args.predictor, "of our own flight")
      ->type_name(text("NAME"))
      ->check(oneOf({"velocity", "path"}))
      ->capture_default_str();
  sub->add_option("--sources", args.sources, "folder of measure.mjs and its node_modules")->type_name(folder("DIR"));
  return sub;
}

Result<nlohmann::ordered_json> rivals(const RivalsArguments& args) {
  if (Status s = checkInstalled(args.sources); !s.ok()) return s.error();
  if (const auto links = linksOf(args.link); !links) return links.error();
  const auto planned = planFlightOverPlane(args.flight);
  if (!planned) return planned.error();
  const lab::TemporaryFolder scratch;
  if (scratch.path().empty())
    return Error{ErrorCode::kIo, "no temporary folder can be made; set TMPDIR to where one can"};
  const auto plan = planOf(args, *planned, scratch.path());
  if (!plan) return plan.error();
  const std::string text = plan->dump();
  const fs::path file = scratch.path() / "plan.json";
  if (Status s = lab::writeFile(Bytes(text.begin(), text.end()), file); !s.ok()) return s.error();
  const auto printed = lab::runProgram({"node", (args.sources / "measure.mjs").string(), file.string()});
  if (!printed) return printed.error();
  nlohmann::ordered_json report{{"scene", fs::path(args.flight.scene).filename().string()}};
  report.update(flightReport(args.flight, *planned));
  report["link"] = args.link.link;
  const auto measured = nlohmann::ordered_json::parse(*printed, nullptr, false);
  if (measured.is_discarded()) return Error{ErrorCode::kMalformed, "measure.mjs printed what is no report"};
  report.update(measured);
  return report;
}

}  // namespace foreland::apps
