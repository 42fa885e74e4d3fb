// Model files with random damage end in a model or an error.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/rng.h"
#include "terrain/model/model.h"

namespace foreland::test {

// Reads each file in turn, with some bytes changed, and one in `cut` of them cut short. How many were refused; a model
// that is read must have all vertices that it names.
template <class Read>
int countRefused(const std::vector<std::string>& files, int runs, uint64_t cut, Rng& rng, const Read& read) {
  int refused = 0;
  for (int i = 0; i < runs; ++i) {
    std::string bytes = files[static_cast<size_t>(i) % files.size()];
    for (uint64_t changes = 1 + rng.below(4); changes > 0; --changes)
      bytes[rng.below(bytes.size())] = static_cast<char>(rng.next());
    if (rng.below(cut) == 0) bytes.resize(rng.below(bytes.size()));
    const auto model = read(bytes);
    refused += !model.ok();
    if (!model.ok()) continue;
    for (const terrain::Corner& corner : model->corners) EXPECT_LT(corner.vertex, model->positions.size());
  }
  return refused;
}

}  // namespace foreland::test
