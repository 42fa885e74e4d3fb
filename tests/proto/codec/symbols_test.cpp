// Numbers coded by learnt decisions: what is coded is decoded, whatever its size.
#include "proto/codec/symbols.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"

namespace foreland::proto {
namespace {

uint64_t newSeed() { return static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed()); }

struct Model {
  NumberModel number;
  std::array<AdaptiveBit, 8> tree;
  EscapeModel escape;
};

// Codes a number with each of the four sign contexts, then a small one as a tree.
template <class Coder>
class Both {
 public:
  explicit Both(Coder& coder) : symbols_(coder, model_.escape) {}
  int32_t number(size_t i, int32_t value) { return symbols_.number(model_.number, i % 4, value); }
  uint32_t small(uint32_t value) { return symbols_.template tree<3>(model_.tree, value); }
  uint32_t orByte(uint32_t value) { return symbols_.template treeOrByte<3>(model_.tree, value); }

 private:
  Model model_;
  Symbols<Coder> symbols_;
};

int32_t randomNumber(Rng& rng) {
  const auto magnitude = static_cast<int32_t>(rng.next() >> (33 + rng.below(31)));
  return rng.below(2) ? magnitude : -magnitude;
}

TEST(Symbols, NumbersOfAnySizeComeBack) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  std::vector<int32_t> numbers{0, 1, -1, std::numeric_limits<int32_t>::max(), -std::numeric_limits<int32_t>::max()};
  for (int width = 1; width < 31; ++width)
    for (int32_t off : {-1, 0, 1}) numbers.insert(numbers.end(), {(1 << width) + off, -(1 << width) + off});
  for (int i = 0; i < 5000; ++i) numbers.push_back(randomNumber(rng));
  Bytes bytes;
  RangeEncoder encoder(bytes);
  Both<RangeEncoder> writer(encoder);
  for (size_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(writer.number(i, numbers[i]), numbers[i]);
  encoder.finish();
  RangeDecoder decoder(bytes);
  Both<RangeDecoder> reader(decoder);
  for (size_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(reader.number(i, 0), numbers[i]) << "seed " << seed;
  EXPECT_TRUE(decoder.atEnd());
}

TEST(Symbols, TreesComeBackWithAndWithoutAByte) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  std::vector<uint32_t> numbers;
  for (uint32_t n = 0; n < 7 + 256; ++n) numbers.push_back(n);  // all that treeOrByte<3> can take
  for (int i = 0; i < 1000; ++i) numbers.push_back(static_cast<uint32_t>(rng.below(7 + 256)));
  Bytes bytes;
  RangeEncoder encoder(bytes);
  Both<RangeEncoder> writer(encoder);
  for (uint32_t n : numbers) {
    ASSERT_EQ(writer.small(n % 8), n % 8);
    ASSERT_EQ(writer.orByte(n), n);
  }
  encoder.finish();
  RangeDecoder decoder(bytes);
  Both<RangeDecoder> reader(decoder);
  for (uint32_t n : numbers) {
    ASSERT_EQ(reader.small(0), n % 8) << "seed " << seed;
    ASSERT_EQ(reader.orByte(0), n) << "seed " << seed;
  }
  EXPECT_TRUE(decoder.atEnd());
}

TEST(Symbols, LearnWhichNumbersAreLikely) {
  Bytes bytes;
  RangeEncoder encoder(bytes);
  Both<RangeEncoder> writer(encoder);
  for (int i = 0; i < 4000; ++i) writer.number(0, i % 2 == 0 ? 5 : 6);  // one bit each is left
  encoder.finish();
  EXPECT_LT(8.0 * static_cast<double>(bytes.size()), 1.3 * 4000);
}

TEST(Symbols, AnyBytesGiveNumbers) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int round = 0; round < 300; ++round) {
    Bytes bytes(rng.below(200));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.next());
    RangeDecoder decoder(bytes);
    Both<RangeDecoder> reader(decoder);
    for (size_t i = 0; i < 200; ++i) {
      const int64_t number = reader.number(i, 0);
      ASSERT_LE(std::abs(number), std::numeric_limits<int32_t>::max()) << "seed " << seed;
      ASSERT_LT(reader.orByte(0), 7u + 256) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace foreland::proto
