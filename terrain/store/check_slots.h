// Calls a check for every slot of a file on several threads: what verifying terrains (verify.h) and surfaces shares.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "proto/topology/node.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

// Calls check(slot) for each slot below `slots`, from several threads at once. It returns whether the slot holds a
// node; the result is how many do.
template <class Check>
uint64_t checkSlots(proto::Slot slots, unsigned threads, const Check& check) {
  constexpr uint64_t kChunk = 1u << 14;
  std::atomic<uint64_t> nodes{0};
  const auto checkChunk = [&](uint64_t chunk, unsigned) {
    uint64_t found = 0;
    const uint64_t begin = chunk * kChunk, end = std::min<uint64_t>(begin + kChunk, slots);
    for (uint64_t slot = begin; slot < end; ++slot) found += check(static_cast<proto::Slot>(slot)) ? 1 : 0;
    nodes += found;
  };
  parallelFor((slots + kChunk - 1) / kChunk, threads, checkChunk, [](uint64_t) { return true; });
  return nodes;
}

}  // namespace foreland::terrain
