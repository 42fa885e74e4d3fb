// Where the bytes of a scene at a distance come from: a store that answers ranges (terrain/fetch), or a test.
#pragma once

#include <cstdint>

#include "base/bytes.h"
#include "base/result.h"

namespace foreland::terrain {

class RangeSource {
 public:
  virtual ~RangeSource() = default;
  // Exactly `bytes` bytes from `offset` on; the caller may rely on no more than their number. Blocks while they come.
  // Several threads at once.
  virtual Result<Bytes> read(uint64_t offset, uint64_t bytes) = 0;
  // From now on reads, those in progress too, end soon, with errors.
  virtual void stop() {}
};

}  // namespace foreland::terrain
