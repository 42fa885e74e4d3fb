// The range coder: what is coded is decoded, at the cost that the probabilities say, and any bytes can be read.
#include "proto/codec/range_coder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/rng.h"

namespace foreland::proto {
namespace {

uint64_t newSeed() { return static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed()); }

// A bit of one of eight contexts, each with a likelihood of its own, or a number of up to 16 bits.
struct Symbol {
  size_t context = 0;
  int bits = 0;  // 0: a context's
  uint32_t value = 0;
};

std::vector<Symbol> randomSymbols(Rng& rng, size_t count) {
  std::vector<Symbol> symbols(count);
  for (Symbol& s : symbols) {
    s.context = rng.below(8);
    s.bits = rng.below(4) == 0 ? static_cast<int>(1 + rng.below(16)) : 0;
    s.value = s.bits > 0 ? static_cast<uint32_t>(rng.below(1ull << s.bits)) : rng.below(100) < 14 * s.context ? 1 : 0;
  }
  return symbols;
}

template <class Coder>
uint32_t code(Coder& coder, std::array<AdaptiveBit, 8>& contexts, const Symbol& s) {
  if (s.bits > 0) return coder.codeEvenly(s.value, s.bits);
  return coder.code(contexts[s.context], s.value != 0) ? 1 : 0;
}

Bytes encoded(const std::vector<Symbol>& symbols) {
  Bytes bytes;
  RangeEncoder coder(bytes);
  std::array<AdaptiveBit, 8> contexts;
  for (const Symbol& s : symbols) EXPECT_EQ(code(coder, contexts, s), s.value);
  coder.finish();
  return bytes;
}

TEST(RangeCoder, DecodesWhatWasEncoded) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int round = 0; round < 500; ++round) {
    const std::vector<Symbol> symbols = randomSymbols(rng, rng.below(300));
    const Bytes bytes = encoded(symbols);
    RangeDecoder coder(bytes);
    std::array<AdaptiveBit, 8> contexts;
    for (Symbol s : symbols) {
      const uint32_t expected = s.value;
      s.value = 0;  // a decoder is not told
      ASSERT_EQ(code(coder, contexts, s), expected) << "seed " << seed << ", round " << round;
    }
    ASSERT_TRUE(coder.atEnd()) << "seed " << seed << ", round " << round;
  }
}

// Likely 0xff bytes, so that a carry runs through a long chain of them.
TEST(RangeCoder, PropagatesCarries) {
  for (int ones = 0; ones < 40; ++ones) {
    std::vector<Symbol> symbols(static_cast<size_t>(ones), Symbol{0, 8, 255});
    for (uint32_t last = 0; last < 256; last += 15) {
      symbols.push_back({0, 16, 65535});
      symbols.push_back({0, 8, last});
    }
    const Bytes bytes = encoded(symbols);
    RangeDecoder coder(bytes);
    std::array<AdaptiveBit, 8> contexts;
    for (const Symbol& s : symbols) ASSERT_EQ(code(coder, contexts, {0, s.bits, 0}), s.value) << ones;
    ASSERT_TRUE(coder.atEnd());
  }
}

TEST(RangeCoder, CostsWhatTheProbabilitiesSay) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  Bytes bytes;
  RangeEncoder coder(bytes);
  AdaptiveBit context;
  double expected = 0;
  for (int i = 0; i < 20000; ++i) {
    const bool value = rng.below(10) == 0;
    const double p = context.probability() / 32768.0;
    expected -= std::log2(value ? p : 1 - p);
    coder.code(context, value);
    ASSERT_NEAR(coder.bits(), expected, 1e-3 * expected + 1) << "seed " << seed;
  }
  coder.finish();
  EXPECT_NEAR(8.0 * static_cast<double>(bytes.size()), expected, 1e-3 * expected + 16) << "seed " << seed;
  EXPECT_LT(expected, 0.55 * 20000) << "seed " << seed;  // the entropy is 0.469 bits
}

TEST(AdaptiveBit, StaysAwayFromCertainty) {
  for (bool value : {false, true}) {
    AdaptiveBit bit;
    for (int i = 0; i < 5000; ++i) bit.learn(value);
    EXPECT_EQ(bit.probability(), value ? 32768 - AdaptiveBit::kMin : AdaptiveBit::kMin);
  }
}

TEST(RangeDecoder, ReadsAnyBytesAndKnowsWhenTheyEnd) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int round = 0; round < 500; ++round) {
    Bytes bytes(rng.below(60));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.next());
    RangeDecoder coder(bytes);
    std::array<AdaptiveBit, 8> contexts;
    size_t symbols = 0;
    for (; !coder.overrun() && symbols < 100000; ++symbols) {
      const Symbol s{rng.below(8), static_cast<int>(rng.below(17)), 0};
      ASSERT_LT(code(coder, contexts, s), s.bits > 0 ? 1u << s.bits : 2u) << "seed " << seed;
    }
    // Any symbol but a likely bit takes some of the input.
    ASSERT_LT(symbols, 100000u) << "seed " << seed;
    ASSERT_FALSE(coder.atEnd());
  }
}

}  // namespace
}  // namespace foreland::proto
