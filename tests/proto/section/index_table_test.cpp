// A table of indices against std::map.
#include "proto/section/index_table.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "base/rng.h"

namespace foreland::proto {
namespace {

// Keys whose products share their upper bits, so that chains of cells grow long and wrap around the table's end.
// The last kind of keys differ in their upper halves alone.
uint64_t keyOf(uint64_t n, uint64_t kind) {
  constexpr uint64_t kInverse = 0xf1de83e19937733du;  // times 0x9e3779b97f4a7c15 is 1
  static_assert(kInverse * 0x9e3779b97f4a7c15u == 1);
  if (kind == 0) return n;
  if (kind == 3) return n << 32 | 7;
  return kInverse * (kind == 1 ? 0xffffffffffffff00u + n : n << 8);
}

class IndexTables : public testing::TestWithParam<uint64_t> {};

TEST_P(IndexTables, FindWhatWasInsertedAndNotErased) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  IndexTable table;
  std::map<uint64_t, uint32_t> expected;
  for (int i = 0; i < 20000; ++i) {
    const uint64_t key = keyOf(rng.below(200), GetParam());
    // Grows and shrinks in turns.
    if (rng.below(3) == (i / 1000 % 2 == 0 ? 0u : 1u)) {
      if (expected.erase(key) > 0) table.erase(key);
    } else if (!expected.contains(key)) {
      const auto index = static_cast<uint32_t>(1 + rng.below(1u << 31));
      table.insert(key, index);
      expected[key] = index;
    }
    ASSERT_EQ(table.size(), expected.size());
    const uint64_t other = keyOf(rng.below(220), GetParam());
    const auto it = expected.find(other);
    ASSERT_EQ(table.find(other), it == expected.end() ? IndexTable::kNone : it->second) << "step " << i;
    if (i % 1000 == 0) {
      for (const auto& [k, index] : expected) ASSERT_EQ(table.find(k), index) << "step " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Keys, IndexTables, testing::Values(0, 1, 2, 3));

TEST(IndexTable, ForgetsAllKeysAndTheirMemory) {
  IndexTable table;
  for (uint32_t key = 0; key < 10000; ++key) table.insert(key, key + 1);
  const size_t before = table.bytes();
  table.reset(100);
  EXPECT_LT(table.bytes(), before / 50);
  EXPECT_EQ(table.size(), 0u);
  for (uint32_t key = 0; key < 10000; ++key) ASSERT_EQ(table.find(key), IndexTable::kNone);
  table.insert(7, 3);
  EXPECT_EQ(table.find(7), 3u);
}

}  // namespace
}  // namespace foreland::proto
