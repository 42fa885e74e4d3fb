#include "lab/apps/bench_occlusion.h"
#include "apps/options/options.h"

#include <chrono>

#include "lab/occlusion/costs.h"
#include "lab/occlusion/predicted_views.h"

namespace foreland::apps {

CLI::App* addOcclusion(CLI::App& app, OcclusionArguments& args) {
  CLI::App* sub = app.add_subcommand("occlusion", "what leaving out hidden nodes saves, costs and shows");
  addFlightOptions(*sub, args.flight);
  sub->add_option("--predictor", args.predictor, "of the viewer's motion")
      ->type_name(text("NAME"))
      ->check(oneOf({"path", "hold", "velocity", "acceleration", "double-exponential", "kalman"}))
      ->capture_default_str();
  sub->add_option("--judge", args.judge.keyframes,
                  "keyframes that rays judge beside the first, and frames between; 0: none but the costs")
      ->type_name(whole("N"))
      ->check(within(0, 1000))
      ->capture_default_str();
  addScreenOptions(*sub, args.width_px, args.height_px);
  return sub;
}

Result<nlohmann::ordered_json> occlusion(const OcclusionArguments& args) {
  auto flight = planFlight(args.flight);
  if (!flight) return flight.error();
  const auto hierarchy = hierarchyOf(flight->scene);
  if (!hierarchy) return hierarchy.error();
  lab::FlightOptions& options = flight->options;
  options.lens.width_px = args.width_px;
  options.lens.height_px = args.height_px;
  const auto begin = std::chrono::steady_clock::now();
  const auto shared = server::SceneOcclusion::create(*hierarchy);
  if (!shared) return shared.error();
  const std::chrono::duration<double> build_s = std::chrono::steady_clock::now() - begin;

  const auto predicted = lab::predictedFlight(flight->path, options, *proto::predictorNamed(args.predictor));
  nlohmann::ordered_json report = flightReport(args.flight, *flight);
  report["predictor"] = args.predictor;
  report.update(apps::toJson(lab::measureOcclusionCosts(*hierarchy, **shared, predicted, options.keyframe_interval)));
  report["occluder_mib"] = static_cast<double>((*shared)->bytes()) / (1 << 20);
  report["occluder_build_s"] = build_s.count();
  if (args.judge.keyframes == 0) return report;
  server::ViewerOcclusion visibility(*hierarchy, **shared);
  lab::Foresight foresight(visibility, predicted);
  const auto judgement = lab::judgeOcclusion(*hierarchy, foresight, predicted.views, flight->path, options, args.judge);
  if (!judgement) return judgement.error();
  report.update(apps::toJson(*judgement));
  return report;
}

}  // namespace foreland::apps
