#include "lab/apps/bench_keyframes.h"

#include "apps/options/options.h"

namespace foreland::apps {

CLI::App* addKeyframes(CLI::App& app, KeyframesArguments& args) {
  args.flight.flight.tau_px = 2;
  args.flight.flight.seconds = 60;
  CLI::App* sub =
      app.add_subcommand("keyframes", "the work of a viewer's keyframes on the server, to be counted by callgrind");
  addFlightOptions(*sub, args.flight);
  sub->add_option("--predictor", args.predictor, "velocity, or path: the camera's path is announced")
      ->check(oneOf({"velocity", "path"}))
      ->capture_default_str();
  sub->add_option("--legs", args.options.legs, "parts of the flight that are flown, evenly apart")
      ->type_name(whole("N"))
      ->check(within(1, 1000))
      ->capture_default_str();
  sub->add_option("--leg-seconds", args.options.leg_s, "what counts of each, after a second")
      ->type_name(number("S"))
      ->check(within(0.2, 600.0))
      ->capture_default_str();
  sub->add_flag("--side-by-side", args.options.side_by_side,
                "fly the parts at once, keyframes in turn, for a simulated cache to count lines missed");
  return sub;
}

Result<nlohmann::ordered_json> keyframes(const KeyframesArguments& args) {
  const auto flight = planFlight(args.flight);
  if (!flight) return flight.error();
  const auto world = server::openWorld(flight->scene);
  if (!world) return world.error();
  lab::ServerFlightOptions options = args.options;
  options.request.lens = {1.0471975511965976, 1920, 1080};
  options.request.tau_px = flight->options.tau_px;
  options.request.keyframe_interval = flight->options.keyframe_interval;
  options.request.predictor =
      args.predictor == "path" ? proto::Predictor::kKnownPath : proto::Predictor::kConstantVelocity;
  nlohmann::ordered_json report = flightReport(args.flight, *flight);
  report.update(toJson(lab::flyForServer(*world, std::make_shared<const proto::Path>(flight->path), options)));
  return report;
}

}  // namespace foreland::apps
