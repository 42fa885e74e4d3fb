#include "server/net/rebalance.h"

#include <algorithm>

namespace foreland::server {

// A pause lets what was done show: costs and load are means over some seconds.
std::vector<size_t> Rebalance::choose(std::span<const Viewer> viewers, double load, bool is_overloaded, size_t workers,
                                      Time now) {
  if (now < next_) return {};
  if (!is_overloaded) {
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
  double excess = (load - kGoal) * static_cast<double>(workers);
  size_t chosen = 0;
  for (; chosen < std::min(order.size(), most) && excess > 0; ++chosen) excess -= viewers[order[chosen]].cost;
  order.resize(chosen);
  if (!order.empty()) {
    next_ = now + pause_;
    pause_ = std::min(Duration{2 * pause_.us}, kMaxPause);
  }
  return order;
}

}  // namespace foreland::server
