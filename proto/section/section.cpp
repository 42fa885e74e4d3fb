#include "proto/section/section.h"

#include <algorithm>
#include <string>

#include "base/vectors.h"

namespace foreland::proto {

bool contains(const Section& section, Slot slot) {
  return std::binary_search(section.slots.begin(), section.slots.end(), slot);
}

Status validate(const GridTopology& grid, const Section& section) {
  const auto& slots = section.slots;
  for (size_t i = 0; i < slots.size(); ++i) {
    const auto refuse = [&](const char* why) {
      return Error{ErrorCode::kMalformed, "section: slot " + std::to_string(slots[i]) + " " + why};
    };
    if (i > 0 && slots[i] <= slots[i - 1]) return refuse("is out of order");
    const NodeId n = grid.node(slots[i]);
    if (grid.isBase(n)) return refuse("is no node");
    for (NodeId parent : grid.parents(n))
      if (!std::binary_search(slots.begin(), slots.begin() + static_cast<ptrdiff_t>(i), grid.slot(parent)))
        return refuse("lacks a parent");
  }
  return {};
}

void diff(const Section& from, const Section& to, CutDelta& out) {
  out.added.clear();
  out.removed.clear();
  auto a = from.slots.begin(), b = to.slots.begin();
  while (a != from.slots.end() && b != to.slots.end()) {
    if (*a == *b)
      ++a, ++b;
    else if (*a < *b)
      out.removed.push_back(*a++);
    else
      out.added.push_back(*b++);
  }
  out.removed.insert(out.removed.end(), a, from.slots.end());
  out.added.insert(out.added.end(), b, to.slots.end());
}

Section apply(const Section& from, const CutDelta& delta) {
  Section kept, to;
  kept.slots.reserve(from.slots.size());
  std::set_difference(from.slots.begin(), from.slots.end(), delta.removed.begin(), delta.removed.end(),
                      std::back_inserter(kept.slots));
  CHECK_EQ(kept.slots.size() + delta.removed.size(), from.slots.size());
  to.slots.reserve(kept.slots.size() + delta.added.size());
  std::set_union(kept.slots.begin(), kept.slots.end(), delta.added.begin(), delta.added.end(),
                 std::back_inserter(to.slots));
  CHECK_EQ(to.slots.size(), kept.slots.size() + delta.added.size());
  return to;
}

uint32_t fingerprint(Slot slot) {
  // Not 0 of slot 0, which would not count.
  uint32_t h = (static_cast<uint32_t>(slot) + 1) * 0x9e3779b1u ^ static_cast<uint32_t>(slot >> 32) * 0x27d4eb2fu;
  h = (h ^ (h >> 15)) * 0x85ebca77u;
  h = (h ^ (h >> 13)) * 0xc2b2ae3du;
  return h ^ (h >> 16);
}

uint32_t fingerprint(std::span<const Slot> slots) {
  uint32_t sum = 0;
  runLoop<Vectors::kAvx2>(
      widestVectors(), slots.size(), [&](size_t begin, size_t end) __attribute__((always_inline)) {
        const Slot* const all = slots.data();
        uint32_t part = 0;
        for (size_t i = begin; i < end; ++i) part += fingerprint(all[i]);
        sum += part;
      });
  return sum;
}

}  // namespace foreland::proto
