// What was said of a page's nodes (kPageSlots), and the same in few bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/refine/slot_bits.h"
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

// Packs the knowledge of a page, whose settled nodes must be known, into the first bytes of `out` and returns how many
// they are. Some 30 where 70 stand in a PageKnowledge, for neighbours mostly share their fate: the known nodes' bits,
// and the settled ones' among these, are written by bytes, in that of four prefix codes which makes them shortest. The
// codes were fitted to flights (docs/decisions/0057-packed-memory.md). Some 0.3 us.
inline constexpr size_t kMostPackedBytes = 67;
size_t packPage(const PageKnowledge& page, std::array<uint8_t, kMostPackedBytes>& out);
// The inverse. `bytes` are what packPage() wrote; what follows is not read.
PageKnowledge unpackPage(std::span<const uint8_t> bytes);
// Of a packed page, without unpacking it: PageKnowledge::radius and knowsAnyOf64().
inline QuantisedRadius packedRadius(std::span<const uint8_t> bytes) { return {bytes[0]}; }
inline bool packedKnowsAnyOf64(std::span<const uint8_t> bytes, Slot first) {
  return (bytes[1] >> (7 - first % kPageSlots / 64) & 1) != 0;
}

}  // namespace foreland::proto
