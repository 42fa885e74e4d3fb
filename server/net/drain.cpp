#include "server/net/drain.h"

#include <memory>
#include <vector>

#include "server/net/viewer_connection.h"

namespace foreland::server {

Drain::Drain(ServerContext& context, Time now, Duration most)
    : context_(context), end_(now + most), turns_(context.viewers.size(), now, most) {}

void Drain::step(Time now) {
  // A copy, because a viewer may remove itself from the set.
  const std::vector<std::shared_ptr<ViewerConnection>> viewers(context_.viewers.begin(), context_.viewers.end());
  for (const auto& viewer : viewers) {
    viewer->check(now);
    if (viewer->isMigrating() || now < turns_.timeOf(asked_)) continue;
    viewer->migrate();
    ++asked_;
    ++context_.metrics.migrated;
  }
}

bool Drain::isOver(Time now) const { return context_.viewers.empty() || now >= end_; }

}  // namespace foreland::server
