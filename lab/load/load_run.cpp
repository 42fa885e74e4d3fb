#include "lab/load/load_run.h"

#include <algorithm>
#include <numeric>

#include "base/quantile.h"
#include "lab/external/told_link.h"
#include "lab/load/load_simulation.h"
#include "lab/load/named.h"

namespace foreland::lab {

namespace {

constexpr std::array<const char*, 4> kPolicies{"fifo", "edf", "least-laxity", "fair"};
constexpr std::array<const char*, 3> kPhases{"synchronised", "random", "staggered"};
constexpr std::array<const char*, 2> kQueues{"shared", "stealing"};
constexpr std::array<const char*, 3> kMixes{"mixed", "survey", "tours"};

// What is hidden is found out by blocks, segments, rays and queries together.
std::array<double, 8> sharesOf(const sim::StepWork& work, const sim::ComputePrices& prices) {
  std::array<double, 8> shares{};
  const auto ns = prices.each(work);
  for (size_t kind = 0; kind < ns.size(); ++kind) shares[std::min(kind, shares.size() - 1)] += ns[kind];
  const double all = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= std::max(all, 1.0);
  return shares;
}

}  // namespace

const char* name(LoadPolicy policy) { return kPolicies[static_cast<size_t>(policy)]; }
const char* name(Phases phases) { return kPhases[static_cast<size_t>(phases)]; }
const char* name(LoadStart start) { return start == LoadStart::kLate ? "late" : "early"; }
Result<LoadPolicy> policyNamed(const std::string& name) { return named<LoadPolicy>(name, "policy", kPolicies); }
Result<Phases> phasesNamed(const std::string& name) { return named<Phases>(name, "phases", kPhases); }
const char* name(LoadQueues queues) { return kQueues[static_cast<size_t>(queues)]; }
Result<LoadQueues> queuesNamed(const std::string& name) { return named<LoadQueues>(name, "kind of queues", kQueues); }
Result<Mix> mixNamed(const std::string& name) { return named<Mix>(name, "mix of viewers", kMixes); }

// Jain, Chiu, Hawe: a quantitative measure of fairness (DEC-TR-301, 1984).
double LoadSimulation::fairness() const {
  double sum = 0, squares = 0;
  for (const auto& v : viewers_) {
    const double asked = options_.seconds / v->light.request().keyframe_interval.toSeconds();
    const double got = static_cast<double>(v->in_time) / asked;
    sum += got, squares += got * got;
  }
  return squares > 0 ? sum * sum / (static_cast<double>(viewers_.size()) * squares) : 0;
}

void LoadSimulation::addVariability(LoadFigures& f) const {
  if (due_us_.empty()) return;
  const double intervals = static_cast<double>(due_us_.size());
  const double budget_us = 1e3 * options_.keyframe_ms * static_cast<double>(options_.workers * servers_.size());
  const double all_us = static_cast<double>(std::accumulate(due_us_.begin(), due_us_.end(), int64_t{0}));
  const auto most_us = static_cast<double>(*std::max_element(due_us_.begin(), due_us_.end()));
  const auto over =
      std::count_if(due_us_.begin(), due_us_.end(), [&](int64_t us) { return static_cast<double>(us) > budget_us; });
  if (all_us > 0) f.peak_over_mean = most_us / (all_us / intervals);
  f.over_budget_share = static_cast<double>(over) / intervals;
}

LoadRun LoadSimulation::result() const {
  LoadRun run{.options = options_,
              .status = programs_.status(),
              .figures = figures_,
              .viewers = {},
              .used = {},
              .lateness_ms = lateness_ms_,
              .cluster = {}};
  for (const auto& v : viewers_) run.viewers.push_back(v->tally);
  LoadFigures& f = run.figures;
  std::sort(run.lateness_ms.begin(), run.lateness_ms.end());
  const double n = static_cast<double>(std::max<uint64_t>(f.keyframes, 1));
  f.missed_share = static_cast<double>(f.missed) / n;
  f.ahead_mean_ms /= n;
  f.tau_times_mean /= static_cast<double>(std::max<uint64_t>(received_, 1));
  f.lateness_p50_ms = quantile(lateness_ms_, 0.5), f.lateness_p99_ms = quantile(lateness_ms_, 0.99);
  f.lateness_max_ms = quantile(lateness_ms_, 1);
  f.work_p99_ms = quantile(work_ms_, 0.99);
  for (const double ms : work_ms_) f.work_mean_ms += ms / n;
  const double bin_us =
      static_cast<double>(kUtilisationBin.us) * static_cast<double>(options_.workers * servers_.size());
  for (size_t bin = 0; bin + 1 < servers_[0].busy_us.size(); ++bin) {  // the last one is beyond the end
    int64_t busy_us = 0;
    for (const Server& server : servers_) busy_us += server.busy_us[bin];
    run.used.push_back(static_cast<double>(busy_us) / bin_us);
  }
  for (const double used : run.used) f.utilisation += used / static_cast<double>(run.used.size());
  f.utilisation_peak = quantile(run.used, 0.99);
  f.at_once_p99_ms = quantile(at_once_ms_, 0.99);
  addVariability(f);
  f.jain = fairness();
  f.shares = sharesOf(work_, options_.prices);
  if (isCluster()) addClusterResult(run);
  return run;
}

LoadRun runLoad(const std::shared_ptr<const server::World>& world, const LoadOptions& options) {
  auto programs = LoadPrograms::start(options);
  if (!programs) {
    LoadRun failed;
    failed.options = options;
    failed.status = programs.error();
    return failed;
  }
  LoadOptions with_links = options;
  if (programs->link) with_links.links = toldLinks(*programs->link);
  LoadSimulation simulation(world, with_links, *programs);
  simulation.run();
  return simulation.result();
}

}  // namespace foreland::lab
