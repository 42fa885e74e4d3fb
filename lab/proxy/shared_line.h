// One direction of a link that several connections share: what any of them sends is carried as one link carries all of
// it, in the order in which it was sent (sim/link.h). The proxy's thread.
#pragma once

#include "sim/link.h"

namespace foreland::lab {

class SharedLine final : public sim::Carrier {
 public:
  SharedLine(const sim::LinkOptions& options, uint64_t seed) : line_(options, seed) {}
  Carried carry(uint64_t link_seed, size_t bytes, Time now) override;

 private:
  sim::Link line_;
};

// These options, but the line is that of all connections; their rate still says how small pieces of bytes are.
sim::LinkOptions sharedByAll(const sim::LinkOptions& options, uint64_t seed);

}  // namespace foreland::lab
