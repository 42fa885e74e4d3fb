// What the page sorts by equals what std::sort makes, whatever comes in.
#include "base/sort.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland {
namespace {

TEST(Sort, HeapSortEqualsStdSort) {
  const uint64_t seed = test::seedOr(1);
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (int round = 0; round < 2'000; ++round) {
    std::vector<uint32_t> numbers(rng.below(50));
    const uint32_t most = 1 + static_cast<uint32_t>(rng.below(100));  // few, so that some are equal
    for (uint32_t& n : numbers) n = static_cast<uint32_t>(rng.below(most));
    std::vector<uint32_t> ascending = numbers, descending = numbers;
    heapSort(ascending.begin(), ascending.end());
    heapSort(descending.begin(), descending.end(), std::greater<>());
    std::sort(numbers.begin(), numbers.end());
    ASSERT_EQ(ascending, numbers) << round;
    std::reverse(numbers.begin(), numbers.end());
    ASSERT_EQ(descending, numbers) << round;
  }
}

TEST(Sort, HeapSortMovesWhatItSorts) {
  std::vector<std::string> words{"node", "", "keyframe", "a name that is longer than what a string holds", "cut"};
  std::vector<std::string> expected = words;
  std::sort(expected.begin(), expected.end());
  heapSort(words.begin(), words.end());
  EXPECT_EQ(words, expected);
}

}  // namespace
}  // namespace foreland
