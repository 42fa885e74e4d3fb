// What was said of a page's nodes (kPageSlots), and the same in few bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/bytes.h"
#include "proto/refine/memory/slot_bits.h"
#include "proto/section/bounds.h"
#include "proto/topology/node.h"

namespace foreland::proto {

struct PageKnowledge {
  SlotBits known;              // nodes whose height was sent
  SlotBits settled;            // those of them whose error follows from decisions
  QuantisedRadius radius;      // of all nodes of the page
  QuantisedError finest{255};  // the least error that a node of the page was asked about

  // Whether any of the 64 slots from `first` on is known, a multiple of 64.
  bool knowsAnyOf64(Slot first) const { return known.words[first % kPageSlots / 64] != 0; }
  // What the client spends on the known nodes: records in blocks of 64, and the page.
  size_t clientBytes() const {
    size_t blocks = 0;
    for (uint64_t word : known.words) blocks += word != 0 ? 1 : 0;
    return kPageBytes + blocks * kBlockBytes;
  }
  static constexpr size_t kPageBytes = 128, kBlockBytes = 512;
  bool operator==(const PageKnowledge&) const = default;
};

struct KnownPage {
  Slot first = 0;
  PageKnowledge knowledge;
  bool operator==(const KnownPage&) const = default;
};

// Appends what is known of a page, whose settled nodes must be known, to `out`, in few bytes: some 30 where 70 stand in
// a PageKnowledge, for neighbours mostly share their fate. The known nodes' bits, and the settled ones' among these,
// are written by bytes, in that of four prefix codes which makes them shortest; the codes were fitted to flights
// (docs/decisions/0021-memory.md). Below a microsecond.
void packPage(const PageKnowledge& page, Bytes& out);
inline constexpr size_t kMaxPackedBytes = 67;
// The inverse. `packed` is what packPage() wrote; what follows is not read.
PageKnowledge unpackPage(ByteSpan packed);
// Of a packed page, without unpacking it: PageKnowledge::radius and knowsAnyOf64().
inline QuantisedRadius packedRadius(ByteSpan packed) { return {packed[0]}; }
inline bool packedKnowsAnyOf64(ByteSpan packed, Slot first) {
  return (packed[1] >> (first % kPageSlots / 64) & 1) != 0;
}

}  // namespace foreland::proto
