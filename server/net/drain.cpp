#include "server/net/drain.h"

#include <algorithm>
#include <memory>
#include <vector>

#include "server/net/viewer_connection.h"

namespace foreland::server {
namespace {

// Half of that or less is what one worker takes for a viewer that resumes.
constexpr Duration kBetweenViewers = Duration::milliseconds(40);

}  // namespace

Drain::Drain(ServerContext& context, Time now, Duration most)
    : context_(context),
      begin_(now),
      end_(now + most),
      viewers_(context.viewers.size()),
      spread_(std::min(Duration{most.us / 2}, kBetweenViewers * static_cast<int64_t>(viewers_))) {}

size_t Drain::turnsBy(Time now) const {
  if (now - begin_ >= spread_) return SIZE_MAX;  // and those that came meanwhile
  return static_cast<size_t>(static_cast<int64_t>(viewers_) * (now - begin_).us / spread_.us) + 1;
}

void Drain::step(Time now) {
  // A copy, because a viewer may remove itself from the set.
  const std::vector<std::shared_ptr<ViewerConnection>> viewers(context_.viewers.begin(), context_.viewers.end());
  for (const auto& viewer : viewers) {
    viewer->check(now);
    if (viewer->isHandingOver()) continue;
    if (asked_ >= turnsBy(now)) continue;
    viewer->handOver();
    ++asked_;
    ++context_.metrics.handed_over;
  }
}

bool Drain::isOver(Time now) const { return context_.viewers.empty() || now >= end_; }

}  // namespace foreland::server
