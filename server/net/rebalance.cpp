#include "server/net/rebalance.h"

#include <algorithm>
#include <numeric>

#include "server/net/metrics/load.h"

namespace foreland::server {
namespace {

using Viewer = Rebalance::Viewer;
using Use = Rebalance::Use;

double costOf(std::span<const Viewer> viewers) {
  return std::accumulate(viewers.begin(), viewers.end(), 0.0,
                         [](double sum, const Viewer& viewer) { return sum + viewer.cost; });
}

// The share of its time that the server uses. A decision that cannot be repeated often is made by the last moment, one
// that can by means over some seconds, as costs are.
double usedBy(std::span<const Viewer> viewers, const Use& use) {
  if (!use.fleet) return use.load;
  return std::max({costOf(viewers) / static_cast<double>(use.workers), use.connections, use.processors});
}

bool isTooMuch(double used, const Use& use) {
  if (!use.fleet) return used > Load::kBusy;
  return used > Rebalance::kLeast && used > Rebalance::kUneven * *use.fleet;
}

double goalOf(const Use& use) { return use.fleet ? std::max(*use.fleet, Rebalance::kLeast) : Rebalance::kGoal; }

}  // namespace

// A pause lets what was done show.
std::vector<size_t> Rebalance::choose(std::span<const Viewer> viewers, const Use& use, Time now) {
  if (now < next_) return {};
  const double used = usedBy(viewers, use);
  if (!isTooMuch(used, use)) {
    pause_ = kMinPause;
    return {};
  }
  std::vector<size_t> order;
  for (size_t i = 0; i < viewers.size(); ++i)
    if (viewers[i].cost > 0 && now >= viewers[i].since + kMinStay) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return viewers[a].cost > viewers[b].cost || (viewers[a].cost == viewers[b].cost && a < b);
  });
  const double count = static_cast<double>(viewers.size()), all = costOf(viewers) + use.connections;
  const auto most = static_cast<size_t>(use.fleet ? std::max(1.0, kFewShare * count) : kMaxShare * count);
  double excess = used - goalOf(use);
  std::vector<size_t> chosen;
  for (const size_t i : order) {
    if (chosen.size() >= most || excess <= 0) break;
    const double share = used * (viewers[i].cost + use.connections / count) / all;
    if (use.fleet && share > excess) continue;
    excess -= share;
    chosen.push_back(i);
  }
  if (!chosen.empty() && !use.fleet) {
    next_ = now + pause_;
    pause_ = std::min(Duration{2 * pause_.us}, kMaxPause);
  }
  return chosen;
}

}  // namespace foreland::server
