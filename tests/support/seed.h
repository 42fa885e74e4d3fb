// The seed of a test that draws at random. FORELAND_SEED=N in the environment runs it with the seed that it printed;
// FORELAND_RANDOM_SEED=N, which ./check sets, takes the place of chance alone.
#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace foreland::test {

// FORELAND_SEED, or `otherwise` without it. Prints the very number that it returns.
inline uint64_t seedOr(uint64_t otherwise) {
  const char* set = std::getenv("FORELAND_SEED");
  const uint64_t seed = set != nullptr ? std::strtoull(set, nullptr, 10) : otherwise;
  std::printf("FORELAND_SEED=%" PRIu64 "\n", seed);
  return seed;
}

// Another one in each run, unless FORELAND_RANDOM_SEED says which.
inline uint64_t randomSeed() {
  const char* set = std::getenv("FORELAND_RANDOM_SEED");
  return seedOr(set != nullptr ? std::strtoull(set, nullptr, 10) : std::random_device{}());
}

}  // namespace foreland::test
