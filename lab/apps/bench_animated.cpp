#include "lab/apps/bench_animated.h"

#include "apps/options/date.h"
#include "apps/options/options.h"
#include "lab/animated/flights.h"
#include "lab/animated/orders.h"

namespace foreland::apps {

CLI::App* addAnimated(CLI::App& app, AnimatedArguments& args) {
  CLI::App* sub = app.add_subcommand("animated", "ground that changes in time, and blending of orders 1 to 3");
  addFlightOptions(*sub, args.flight);
  sub->add_option("--scene-speed", args.scene_speed, "how fast the scene's time goes; s, h, d and y are understood")
      ->type_name(text("SPEED"))
      ->capture_default_str();
  sub->add_option("--judge-every", args.judge_every, "judge one in so many frames against the truth")
      ->type_name(whole("N"))
      ->check(within(1, 10'000))
      ->capture_default_str();
  return sub;
}

Result<nlohmann::ordered_json> animated(const AnimatedArguments& args) {
  const auto rate = parseSceneSpeed(args.scene_speed);
  if (!rate)
    return Error{ErrorCode::kInvalidArgument,
                 "--scene-speed " + args.scene_speed + ": write for example 90d/s, -12h/s or 1y/s"};
  const auto flight = planFlight(args.flight);
  if (!flight) return flight.error();
  const auto opened = server::openWorld(flight->scene);
  if (!opened) return opened.error();
  const std::shared_ptr<const server::World>& world = *opened;
  const proto::Epochs& epochs = world->hierarchy.epochs().epochs();
  const lab::FlightOptions& options = flight->options;

  nlohmann::ordered_json report = flightReport(args.flight, *flight);
  report["scene_speed"] = args.scene_speed;
  report["epochs"] = epochs.size();
  const auto views = lab::keyframeViews(flight->path, options, lab::Guarantee::kEveryFrame);
  std::vector<Time> scene_times;
  if (!epochs.empty()) {
    const proto::SceneClock clock{Time{}, epochs.first(), *rate};
    for (size_t k = 0; k < views.size(); ++k)
      scene_times.push_back(clock.timeAt(epochs, Time{} + options.keyframe_interval * static_cast<int64_t>(k)));
    for (const auto& [name, speed] : {std::pair{"running", *rate}, std::pair{"stopped", 0.0}}) {
      const auto flown = lab::flyAnimated(world, flight->scene, flight->path, options, speed, args.judge_every);
      if (!flown) return flown.error();
      report[name] = apps::toJson(*flown);
    }
    report["bytes_over_stopped"] =
        report["running"]["bytes_down"].get<double>() / report["stopped"]["bytes_down"].get<double>();
  }
  for (const lab::OrderFigures& figures :
       lab::measureOrders(world->hierarchy, views, scene_times, options.keyframe_interval))
    report[figures.basis == oracle::Basis::kBSpline ? "b_spline" : "bernstein"]
          ["order_" + std::to_string(figures.order)] = apps::toJson(figures);
  return report;
}

}  // namespace foreland::apps
