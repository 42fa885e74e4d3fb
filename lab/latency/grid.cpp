#include "lab/latency/grid.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim/link_models.h"

namespace foreland::lab {

namespace {

using proto::Predictor;
using proto::Strategy;

struct How {
  Strategy strategy;
  Predictor predictor;
  std::string command = {};
};

constexpr const char* kProgram = "program";  // among links

struct Axes {
  std::vector<How> hows;
  std::vector<std::string> links;
  std::vector<double> round_trips_ms, taus_px;
  std::vector<proto::KeyframeInterval> keyframes;
  std::string link_command = {};
};

Error invalid(const std::string& message) { return {ErrorCode::kInvalidArgument, message}; }

proto::KeyframeInterval fixed(int64_t ms) { return {Duration::milliseconds(ms), {}}; }

Axes fullAxes() {
  Axes axes{.hows = {{Strategy::kDelay, Predictor::kHold}, {Strategy::kCurrent, Predictor::kHold}},
            .links = {"fixed"},
            .round_trips_ms = {0, 50, 100, 200, 400},
            .taus_px = {0.5, 1, 2},
            .keyframes = {fixed(100), fixed(200), fixed(500), proto::kAdaptiveInterval}};
  for (const Predictor p : {Predictor::kHold, Predictor::kConstantVelocity, Predictor::kConstantAcceleration,
                            Predictor::kDoubleExponential, Predictor::kKalman, Predictor::kKnownPath})
    axes.hows.push_back({Strategy::kPredict, p});
  return axes;
}

Result<std::vector<How>> howsOf(const GridRequest& request) {
  std::vector<Strategy> strategies;
  for (const std::string& name : request.strategies) {
    const auto strategy = proto::strategyNamed(name);
    if (!strategy) return invalid("there is no strategy '" + name + "'; choose delay, current or predict");
    strategies.push_back(*strategy);
  }
  std::vector<Predictor> predictors;
  for (const std::string& name : request.predictors) {
    const auto predictor = proto::predictorNamed(name);
    if (!predictor) return invalid("there is no predictor '" + name + "'; choose one of " + proto::predictorNames());
    predictors.push_back(*predictor);
  }
  std::vector<How> hows;
  for (const How& how : fullAxes().hows) {
    const auto isWanted = [](const auto& wanted, auto value) {
      return wanted.empty() || std::find(wanted.begin(), wanted.end(), value) != wanted.end();
    };
    const bool has_predictor = how.strategy == Strategy::kPredict;
    if (isWanted(strategies, how.strategy) && (!has_predictor || isWanted(predictors, how.predictor)))
      hows.push_back(how);
  }
  const bool predicts =
      strategies.empty() || std::find(strategies.begin(), strategies.end(), Strategy::kPredict) != strategies.end();
  if (!request.predictor_command.empty() && !predicts)
    return invalid("--predictor-command is a predictor of the strategy predict; add it to --strategies");
  if (!request.predictor_command.empty())
    hows.push_back({Strategy::kPredict, Predictor::kConstantVelocity, request.predictor_command});
  return hows;
}

Status checkRange(const std::vector<double>& values, double least, double most, const char* what) {
  for (const double value : values) {
    char text[160];
    std::snprintf(text, sizeof text, "%s must be %g to %g, not %g", what, least, most, value);
    if (!(value >= least && value <= most)) return invalid(text);
  }
  return {};
}

Status check(const GridRequest& request) {
  if (Status s = checkRange(request.round_trips_ms, 0, 2000, "a round trip in ms"); !s.ok()) return s;
  for (const std::string& text : request.keyframes_ms)
    if (const auto interval = proto::keyframeIntervalFrom(text); !interval) return interval.error();
  if (Status s = checkRange(request.taus_px, 0.01, 1000, "a tolerance in pixels"); !s.ok()) return s;
  for (const std::string& link : request.links)
    if (link != "trace")
      if (const auto model = sim::linkNamed(link); !model) return model.error();
  return {};
}

void addAll(const Axes& axes, std::vector<LatencyCell>& out) {
  for (const double tau_px : axes.taus_px)
    for (const proto::KeyframeInterval& keyframes : axes.keyframes)
      for (const std::string& link : axes.links)
        for (const double round_trip_ms : link == "fixed" ? axes.round_trips_ms : std::vector<double>{0})
          for (const How& how : axes.hows) {
            const LatencyCell cell{how.strategy, how.predictor, link,        round_trip_ms,
                                   keyframes,    tau_px,        how.command, link == kProgram ? axes.link_command : ""};
            if (std::find(out.begin(), out.end(), cell) == out.end()) out.push_back(cell);
          }
}

}  // namespace

std::string LatencyCell::how() const {
  const std::string strategy_name = proto::name(strategy);
  return strategy == Strategy::kPredict ? strategy_name + " " + predictorText() : strategy_name;
}

std::string LatencyCell::predictorText() const {
  if (strategy != Strategy::kPredict) return "none";
  return predictor_command.empty() ? proto::name(predictor) : predictor_command;
}

Result<std::vector<LatencyCell>> cellsOf(const GridRequest& request) {
  if (Status s = check(request); !s.ok()) return s.error();
  auto hows = howsOf(request);
  if (!hows) return hows.error();
  Axes axes = fullAxes();
  const bool is_default = request.size == GridSize::kDefault;
  axes.hows = *hows;
  if (!request.links.empty()) axes.links = request.links;
  axes.link_command = request.link_command;
  if (!axes.link_command.empty()) axes.links.push_back(kProgram);
  if (!request.round_trips_ms.empty()) axes.round_trips_ms = request.round_trips_ms;
  if (is_default) axes.keyframes = {fixed(200)}, axes.taus_px = {1};
  if (!request.keyframes_ms.empty()) axes.keyframes.clear();
  for (const std::string& text : request.keyframes_ms) axes.keyframes.push_back(*proto::keyframeIntervalFrom(text));
  if (!request.taus_px.empty()) axes.taus_px = request.taus_px;
  std::vector<LatencyCell> cells;
  addAll(axes, cells);
  const bool is_narrowed = !request.links.empty() || !request.round_trips_ms.empty() || !request.link_command.empty();
  if (!is_default || is_narrowed || !request.keyframes_ms.empty() || !request.taus_px.empty()) return cells;

  Axes beside = axes;
  beside.round_trips_ms = {200};
  std::erase_if(beside.hows, [](const How& how) {
    return how.strategy == Strategy::kDelay ||
           (how.strategy == Strategy::kPredict && how.predictor != Predictor::kConstantVelocity &&
            how.predictor != Predictor::kKnownPath);
  });
  beside.keyframes = {fixed(100), fixed(500), proto::kAdaptiveInterval};
  addAll(beside, cells);
  beside.keyframes = {fixed(200)}, beside.taus_px = {2};
  addAll(beside, cells);
  return cells;
}

}  // namespace foreland::lab
