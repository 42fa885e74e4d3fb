#include "server/net/rebalance.h"

#include <algorithm>
#include <numeric>

namespace foreland::server {
namespace {

using Viewer = Rebalance::Viewer;

// What viewers cost above what they should, in workers; nothing if that is not to be changed. Costs are means over some
// seconds, the load is of the last moment.
std::optional<double> excessOf(std::span<const Viewer> viewers, const Rebalance::Use& use) {
  const auto workers = static_cast<double>(use.workers);
  if (!use.fleet) {
    if (!use.is_overloaded) return std::nullopt;
    return (use.load - Rebalance::kGoal) * workers;
  }
  const double used = std::accumulate(viewers.begin(), viewers.end(), 0.0,
                                      [](double sum, const Viewer& viewer) { return sum + viewer.cost; }) /
                      workers;
  if (used < Rebalance::kLeast || used < Rebalance::kUneven * *use.fleet) return std::nullopt;
  return (used - std::max(*use.fleet, Rebalance::kLeast)) * workers;
}

}  // namespace

// A pause lets what was done show.
std::vector<size_t> Rebalance::choose(std::span<const Viewer> viewers, const Use& use, Time now) {
  if (now < next_) return {};
  auto excess = excessOf(viewers, use);
  if (!excess) {
    pause_ = kMinPause;
    return {};
  }
  std::vector<size_t> order;
  for (size_t i = 0; i < viewers.size(); ++i)
    if (viewers[i].cost > 0 && now >= viewers[i].since + kMinStay) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return viewers[a].cost > viewers[b].cost || (viewers[a].cost == viewers[b].cost && a < b);
  });
  const auto most = static_cast<size_t>(kMaxShare * static_cast<double>(viewers.size()));
  std::vector<size_t> chosen;
  for (const size_t i : order) {
    if (chosen.size() >= most || *excess <= 0) break;
    if (use.fleet && viewers[i].cost > *excess) continue;
    *excess -= viewers[i].cost;
    chosen.push_back(i);
  }
  if (!chosen.empty()) {
    next_ = now + pause_;
    pause_ = std::min(Duration{2 * pause_.us}, kMaxPause);
  }
  return chosen;
}

}  // namespace foreland::server
