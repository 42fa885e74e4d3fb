// Fingerprints of slots, as docs/PROTOCOL.md has them.
#include "proto/section/section.h"

#include <gtest/gtest.h>

#include <set>

namespace foreland::proto {
namespace {

TEST(Fingerprints, OfSlotsOf32BitsAreTheProtocols) {
  for (const Slot slot : {Slot{0}, Slot{1}, Slot{1000}, Slot{0xfffffffe}}) {
    uint32_t h = (static_cast<uint32_t>(slot) + 1) * 0x9e3779b1u;
    h = (h ^ (h >> 15)) * 0x85ebca77u;
    h = (h ^ (h >> 13)) * 0xc2b2ae3du;
    EXPECT_EQ(fingerprint(slot), h ^ (h >> 16));
  }
}

TEST(Fingerprints, TellSlotsApartWhoseLower32BitsAreTheSame) {
  std::set<uint32_t> seen;
  for (Slot high = 0; high < 1000; ++high) EXPECT_TRUE(seen.insert(fingerprint(high << 32 | 12345)).second);
}

}  // namespace
}  // namespace foreland::proto
