#include "lab/proxy/shared_line.h"

#include <algorithm>
#include <memory>

namespace foreland::lab {

sim::Carrier::Carried SharedLine::carry(uint64_t, size_t bytes, Time now) {
  line_.send(Bytes(bytes), now);
  const Time arrives = *line_.newestArrival();
  while (line_.nextArrival()) (void)line_.receive();
  return {std::max(now, line_.drainedAt()), arrives};
}

sim::LinkOptions sharedByAll(const sim::LinkOptions& options, uint64_t seed) {
  sim::LinkOptions shared = options;
  shared.carrier = std::make_shared<SharedLine>(options, seed);
  return shared;
}

}  // namespace foreland::lab
