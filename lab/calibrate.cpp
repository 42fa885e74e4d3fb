#include "lab/calibrate.h"

#include <cmath>

#include "base/quantile.h"
#include "server/view/tour.h"
#include "sim/world.h"

namespace foreland::lab {

namespace {

// At the end of each flight the viewer loses its connection and resumes, so often and so far apart.
constexpr int kResumes = 3;
constexpr Duration kBetweenResumes = Duration::milliseconds(300);

}  // namespace

std::vector<sim::TimedWork> timeSteps(std::shared_ptr<const server::World> world, double seconds) {
  using enum proto::Predictor;
  std::vector<std::pair<proto::Predictor, bool>> ways{{kConstantVelocity, false}, {kKnownPath, false}};
  if (world->occlusion) ways.insert(ways.end(), {{kConstantVelocity, true}, {kKnownPath, true}});
  std::vector<sim::TimedWork> steps;
  for (const char* tour : {"survey", "canyon", "spin", "orbit"})
    for (const double tau_px : {1.0, 2.0})
      for (const auto& [predictor, is_occluded] : ways) {
        sim::World flown(
            world, {}, [](const sim::StepWork& work) { return sim::ComputePrices{}.of(work); }, 1, sim::Laws::kTrusted);
        flown.on_step = [&](const sim::StepWork& work, double seconds_spent) {
          if (work.keyframes + work.resumed > 0) steps.push_back({work, seconds_spent});
        };
        sim::ClientOptions client = sim::onKnownTour(world->hierarchy.scene(), tour, seconds + 2);
        client.request.lens = {1.0471975511965976, 1920, 1080};
        client.request.tau_px = tau_px;
        client.request.predictor = predictor;
        client.request.occlusion = is_occluded;
        client.announce_path = predictor == proto::Predictor::kKnownPath;
        flown.addClient(client);
        flown.run(Time::seconds(seconds));
        for (int i = 1; i <= kResumes; ++i) {
          flown.loseConnection(0);
          flown.connectAgain(0);
          flown.run(Time::seconds(seconds) + kBetweenResumes * i);
        }
      }
  return steps;
}

Calibration calibrate(const std::vector<sim::TimedWork>& steps) {
  Calibration result{.prices = sim::fitPrices(steps), .steps = steps.size()};
  std::vector<double> errors;
  double priced_s = 0;
  for (const sim::TimedWork& step : steps) {
    const double price_s = result.prices.of(step.work).toSeconds();
    result.total_s += step.seconds;
    priced_s += price_s;
    errors.push_back(std::fabs(price_s / step.seconds - 1));
  }
  result.total_error = steps.empty() ? 0 : std::fabs(priced_s / result.total_s - 1);
  result.median_error = median(errors);
  return result;
}

}  // namespace foreland::lab
