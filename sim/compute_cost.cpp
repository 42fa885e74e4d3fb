#include "sim/compute_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace foreland::sim {

namespace {

using Counts = std::array<double, kWorkKinds>;

// In the order of StepWork.
Counts countsOf(const StepWork& work) {
  Counts counts{};
  size_t kind = 0;
  work.fields([&](const char*, uint64_t count) { counts[kind++] = static_cast<double>(count); });
  return counts;
}

// What the viewer knows, its section included.
uint64_t knownNodes(const server::Session& session) {
  uint64_t sum = 0;
  for (const proto::KnownPage& page : session.knownPages()) sum += page.knowledge.known.count();
  return sum;
}

}  // namespace

StepWork StepWork::between(const server::SessionStatistics& before, const server::Session& session, uint64_t bytes) {
  const server::SessionStatistics& after = session.statistics();
  const uint64_t tests = after.nodes_tested - before.nodes_tested,
                 changed = after.nodes_added + after.nodes_removed - before.nodes_added - before.nodes_removed;
  return {.keyframes = after.keyframes - before.keyframes,
          .tested = tests - std::min(tests, changed),
          .swept = after.nodes_swept - before.nodes_swept,
          .changed = changed,
          .measured = after.nodes_measured - before.nodes_measured,
          .bytes = bytes,
          .resumed = after.resumed && !before.resumed ? knownNodes(session) : 0,
          .blocks = after.occlusion.tests - before.occlusion.tests,
          .segments = after.occlusion.segments - before.occlusion.segments,
          .rays = after.occlusion.rays - before.occlusion.rays,
          .queries = after.occlusion.queries - before.occlusion.queries};
}

StepWork& StepWork::operator+=(const StepWork& other) {
  keyframes += other.keyframes;
  tested += other.tested;
  swept += other.swept;
  changed += other.changed;
  measured += other.measured;
  bytes += other.bytes;
  resumed += other.resumed;
  blocks += other.blocks;
  segments += other.segments;
  rays += other.rays;
  queries += other.queries;
  return *this;
}

std::array<double, kWorkKinds> ComputePrices::each(const StepWork& work) const {
  Counts ns = countsOf(work);
  size_t kind = 0;
  fields([&](const char*, double price) { ns[kind++] *= price; });
  return ns;
}

Duration ComputePrices::of(const StepWork& work) const {
  double ns = 0;
  for (const double part : each(work)) ns += part;
  return Duration{static_cast<int64_t>(std::llround(ns * 1e-3))};
}

std::string ComputePrices::toJson() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  fields([&json](const char* key, double price) { json[key] = price; });
  return json.dump(2) + "\n";
}

Result<ComputePrices> readPrices(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return Error{ErrorCode::kNotFound, "cannot open the calibration '" + path.string() + "'"};
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object())
    return Error{ErrorCode::kMalformed,
                 path.string() + ": is no calibration; make one with `foreland bench calibrate`"};
  ComputePrices prices;
  prices.name = path.filename().string();
  std::string wrong;
  const auto read = [&](const char* key, double& value) {
    const auto it = json.find(key);
    const bool is_number = it != json.end() && it->is_number();
    if (is_number) value = it->get<double>();
    if (wrong.empty() && (!is_number || !std::isfinite(value) || value < 0)) wrong = key;
  };
  prices.fields(read);
  if (!wrong.empty())
    return Error{ErrorCode::kMalformed, path.string() + ": '" + wrong + "' must be a number, 0 or more"};
  return prices;
}

// Coordinate descent: each price in turn becomes the best one, not below zero, given the others. The problem is convex,
// and with columns scaled to the same size it converges in a few hundred rounds.
ComputePrices fitPrices(std::span<const TimedWork> steps) {
  constexpr int kRounds = 2000;
  Counts prices{}, square{};
  std::vector<Counts> rows;
  std::vector<double> residual;
  for (const TimedWork& step : steps) {
    if (step.seconds <= 0) continue;
    Counts row = countsOf(step.work);
    for (size_t i = 0; i < kWorkKinds; ++i) {
      row[i] *= 1e-9 / step.seconds;
      square[i] += row[i] * row[i];
    }
    rows.push_back(row);
    residual.push_back(1);
  }
  for (int round = 0; round < kRounds; ++round)
    for (size_t i = 0; i < kWorkKinds; ++i) {
      if (square[i] <= 0) continue;
      double along = 0;
      for (size_t r = 0; r < rows.size(); ++r) along += rows[r][i] * residual[r];
      const double next = std::max(0.0, prices[i] + along / square[i]);
      for (size_t r = 0; r < rows.size(); ++r) residual[r] -= (next - prices[i]) * rows[r][i];
      prices[i] = next;
    }
  ComputePrices fitted{.name = "fitted"};
  size_t kind = 0;
  fitted.fields([&](const char*, double& price) { price = prices[kind++]; });
  return fitted;
}

}  // namespace foreland::sim
