#include "lab/load/load_cast.h"

#include <numeric>
#include <utility>

#include "server/view/tour.h"

namespace foreland::lab {

namespace {

constexpr double kTour_s = 60;

std::shared_ptr<const proto::Path> tourOf(const terrain::Scene& scene, const char* tour) {
  return std::make_shared<const proto::Path>(server::planTour(scene, tour, kTour_s).value());
}

}  // namespace

LoadTours::LoadTours(const terrain::Scene& scene)
    : survey(tourOf(scene, "survey")),
      canyon(tourOf(scene, "canyon")),
      spin(tourOf(scene, "spin")),
      orbit(tourOf(scene, "orbit")) {}

LoadCast castOf(const LoadTours& tours, const LoadOptions& options, size_t role, Rng& chance) {
  const Duration offset = Duration::seconds(chance.uniform(0, kTour_s));
  LoadCast cast{
      .flight = {tours.survey, offset, Duration::seconds(options.crowd_jump_s)}, .request = {}, .links = options.links};
  cast.request.occlusion = options.occlusion != server::Occlusion::kOff;
  cast.request.tau_px = options.tau_px;
  cast.request.strategy = proto::Strategy::kPredict;
  cast.request.predictor = options.predictor;
  cast.request.keyframe_interval = Duration::seconds(1e-3 * options.keyframe_ms);
  if (options.mix == Mix::kSurvey) return cast;
  role %= 20;
  if (role >= 8 && role < 15) cast.flight.path = tours.canyon;
  if (role == 15 || role == 16) cast.flight.path = tours.spin;
  if (role >= 17 && options.mix == Mix::kTours) {
    cast.flight.path = tours.orbit;
    return cast;
  }
  if (role == 17) {  // nobody knows where it will be
    cast.is_jumper = true;
    cast.flight.jump_every = Duration::seconds(4);
    cast.request.predictor = proto::Predictor::kConstantVelocity;
  }
  if (role == 18) {
    cast.links.down.trace = nullptr;
    cast.links.down.carrier = nullptr;
    cast.links.down.bytes_per_second = 256e3 / 8;
  }
  if (role == 19) {
    cast.request.tau_px = options.tau_px / 4;
    cast.request.lens = {1.0471975511965976, 3840, 2160};
  }
  return cast;
}

std::vector<size_t> rolesOf(const LoadOptions& options, Rng& chance) {
  std::vector<size_t> roles(options.viewers);
  std::iota(roles.begin(), roles.end(), 0);
  if (options.cluster.servers > 1)
    for (size_t i = roles.size(); i > 1; --i) std::swap(roles[i - 1], roles[chance.below(i)]);
  return roles;
}

Time comesAt(size_t viewer, const LoadOptions& options) {
  const auto shareOf = [](size_t i, size_t all) { return static_cast<double>(i) / static_cast<double>(all); };
  const size_t before = options.before_step;
  if (before == 0 || before >= options.viewers) return Time::seconds(shareOf(viewer, options.viewers));
  if (viewer < before) return Time::seconds(shareOf(viewer, before));
  return Time::seconds(options.run_in_s + options.step_s * shareOf(viewer - before, options.viewers - before));
}

std::vector<LoadViewer> viewersOf(const LoadTours& tours, const LoadOptions& options, std::span<const size_t> roles) {
  Rng chance(options.seed);
  std::vector<LoadViewer> viewers;
  for (const size_t role : roles) {
    const uint64_t link_seed = chance.next();
    viewers.push_back({castOf(tours, options, role, chance), link_seed, {}, {}});
  }
  for (size_t i = 0; i < viewers.size(); ++i) {
    LoadViewer& v = viewers[i];
    const double share = static_cast<double>(i) / static_cast<double>(viewers.size());
    const auto interval_us = static_cast<double>(v.cast.request.keyframe_interval.us);
    v.comes = comesAt(i, options);
    if (options.phases == Phases::kRandom) v.clock = Duration{static_cast<int64_t>(chance.uniform(0, interval_us))};
    if (options.phases == Phases::kStaggered) v.clock = Duration{static_cast<int64_t>(share * interval_us)};
  }
  return viewers;
}

}  // namespace foreland::lab
