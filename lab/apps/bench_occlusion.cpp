#include "lab/apps/bench_occlusion.h"
#include "apps/options/options.h"

#include <chrono>

#include "lab/occlusion/costs.h"
#include "lab/occlusion/predicted_views.h"
#include "lab/occlusion/street_path.h"

namespace foreland::apps {

CLI::App* addOcclusion(CLI::App& app, OcclusionArguments& args) {
  CLI::App* sub = app.add_subcommand("occlusion", "what leaving out hidden nodes saves, costs and shows");
  addFlightOptions(*sub, args.flight);
  sub->add_option("--predictor", args.predictor, "of the viewer's motion")
      ->type_name(text("NAME"))
      ->check(oneOf({"path", "hold", "velocity", "acceleration", "double-exponential", "kalman"}))
      ->capture_default_str();
  sub->add_option(
         "--judge", args.judge.keyframes,
         "keyframes that rays judge beside the first, and frames between; 0: none but the costs, also over globes")
      ->type_name(whole("N"))
      ->check(within(0, 1000))
      ->capture_default_str();
  CLI::Option* street = sub->add_option("--street", args.street_m,
                                        "instead of the tour fly along the streets between the scene's objects, so "
                                        "many metres above the ground")
                            ->type_name(number("M"))
                            ->check(within(0.5, 10'000.0));
  sub->add_option("--street-speed", args.street_mps, "metres a second")
      ->type_name(number("MPS"))
      ->check(within(0.1, 1000.0))
      ->needs(street)
      ->capture_default_str();
  addScreenOptions(*sub, args.width_px, args.height_px);
  return sub;
}

Result<nlohmann::ordered_json> occlusion(const OcclusionArguments& args) {
  auto flight =
      args.judge.keyframes == 0 && args.street_m == 0 ? planFlight(args.flight) : planFlightOverPlane(args.flight);
  if (!flight) return flight.error();
  const auto hierarchy = hierarchyOf(flight->scene);
  if (!hierarchy) return hierarchy.error();
  if (args.street_m > 0) {
    auto street = lab::streetPath(*hierarchy, {args.street_m, args.street_mps, args.flight.flight.seconds + 1});
    if (!street) return street.error();
    flight->path = std::move(*street);
    const double path_s = flight->path.step.toSeconds() * static_cast<double>(flight->path.poses.size() - 1);
    flight->options.seconds = std::min(args.flight.flight.seconds, path_s);
  }
  lab::FlightOptions& options = flight->options;
  options.lens.width_px = args.width_px;
  options.lens.height_px = args.height_px;
  const auto begin = std::chrono::steady_clock::now();
  const auto shared = server::SceneOcclusion::create(*hierarchy);
  if (!shared) return shared.error();
  const std::chrono::duration<double> build_s = std::chrono::steady_clock::now() - begin;

  const auto predicted = lab::predictedFlight(flight->path, options, *proto::predictorNamed(args.predictor));
  nlohmann::ordered_json report = flightReport(args.flight, *flight);
  if (args.street_m > 0)
    report.update({{"tour", "street"}, {"street_m", args.street_m}, {"street_mps", args.street_mps}});
  report["predictor"] = args.predictor;
  report.update(apps::toJson(lab::measureOcclusionCosts(*hierarchy, **shared, predicted, options.keyframe_interval)));
  report["occluder_mib"] = static_cast<double>((*shared)->bytes()) / (1 << 20);
  report["occluder_build_s"] = build_s.count();
  if (args.judge.keyframes == 0) return report;
  server::ViewerOcclusion visibility(*hierarchy, **shared);
  lab::Foresight foresight(visibility, predicted);
  const auto judgement =
      lab::judgeOcclusion(*hierarchy, {foresight, &foresight}, predicted.views, flight->path, options, args.judge);
  if (!judgement) return judgement.error();
  report.update(apps::toJson(*judgement));
  return report;
}

}  // namespace foreland::apps
