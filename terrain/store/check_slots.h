// Calls a check for every record of a file on several threads: what verifying terrains (verify.h) and surfaces shares.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "proto/topology/node.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

// Calls check(place) for each place below `places`, from several threads at once. It returns whether the place holds a
// node; the result is how many do.
template <class Check>
uint64_t checkSlots(uint64_t places, unsigned threads, const Check& check) {
  constexpr uint64_t kChunk = 1u << 14;
  std::atomic<uint64_t> nodes{0};
  const auto checkChunk = [&](uint64_t chunk, unsigned) {
    uint64_t found = 0;
    const uint64_t begin = chunk * kChunk, end = std::min<uint64_t>(begin + kChunk, places);
    for (uint64_t place = begin; place < end; ++place) found += check(place) ? 1 : 0;
    nodes += found;
  };
  parallelFor((places + kChunk - 1) / kChunk, threads, checkChunk, [](uint64_t) { return true; });
  return nodes;
}

}  // namespace foreland::terrain
