#include "proto/refine/page_knowledge.h"

#include <bit>

#include "base/check.h"

namespace foreland::proto {

namespace {

constexpr int kLongest = 12;  // bits of a code word
constexpr int kWords = kPageSlots / 64;
constexpr int kRadiusBits = 8, kFinestBits = 8, kCodeBits = 2;

// A canonical prefix code of bytes whose words are as long for all bytes of as many ones (Schwartz and Kallick 1964).
struct ByteCode {
  std::array<uint8_t, 9> lengths{};  // by the number of ones
  std::array<uint16_t, 256> words{};
  // For decoding, by length: the first word that is longer, and where the words of the length stand among all, both as
  // if all words were filled up to kLongest bits.
  std::array<uint16_t, kLongest + 1> ends{}, firsts{};
  std::array<uint8_t, kLongest + 1> ranks{};
  std::array<uint8_t, 256> bytes{};  // by the order of their words

  explicit ByteCode(const std::array<uint8_t, 9>& of) : lengths(of) {
    uint32_t word = 0, rank = 0;
    for (uint32_t length = 1; length <= kLongest; ++length) {
      firsts[length] = static_cast<uint16_t>(word);
      ranks[length] = static_cast<uint8_t>(rank);
      for (uint32_t byte = 0; byte < 256; ++byte) {
        if (lengths[static_cast<size_t>(std::popcount(byte))] != length) continue;
        words[byte] = static_cast<uint16_t>(word >> (kLongest - length));
        bytes[rank++] = static_cast<uint8_t>(byte);
        word += 1u << (kLongest - length);
      }
      ends[length] = static_cast<uint16_t>(word);
    }
  }
};

// For bytes of any kind, mostly zeros, some of both, mostly ones. Made at the first use: the page's module is small.
const std::array<ByteCode, 4>& byteCodes() {
  static const std::array<ByteCode, 4> kCodes{
      ByteCode({8, 8, 8, 8, 8, 8, 8, 8, 8}), ByteCode({1, 5, 8, 10, 11, 11, 11, 10, 9}),
      ByteCode({3, 6, 7, 8, 9, 10, 9, 8, 5}), ByteCode({6, 10, 11, 12, 11, 10, 8, 5, 1})};
  return kCodes;
}

class BitWriter {
 public:
  explicit BitWriter(uint8_t* out) : out_(out) {}
  // At most 16 bits.
  void put(uint32_t value, int count) {
    held_ = held_ << count | value;
    for (held_bits_ += count; held_bits_ >= 8; held_bits_ -= 8)
      out_[size_++] = static_cast<uint8_t>(held_ >> (held_bits_ - 8));
  }
  // Fills up the last byte; returns the number of bytes.
  size_t finish() {
    put(0, (8 - held_bits_) & 7);
    return size_;
  }

 private:
  uint8_t* out_;
  size_t size_ = 0;
  uint64_t held_ = 0;  // only the last held_bits_ are still to be written
  int held_bits_ = 0;
};

class BitReader {
 public:
  explicit BitReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  // The next bits, at most 16, as if zeros followed the last byte.
  uint32_t peek(int count) {
    for (; held_bits_ < count; held_bits_ += 8) held_ = held_ << 8 | (at_ < bytes_.size() ? bytes_[at_++] : 0u);
    return static_cast<uint32_t>(held_ >> (held_bits_ - count)) & ((1u << count) - 1);
  }
  void skip(int count) { held_bits_ -= count; }
  uint32_t take(int count) {
    const uint32_t value = peek(count);
    skip(count);
    return value;
  }

 private:
  std::span<const uint8_t> bytes_;
  size_t at_ = 0;
  uint64_t held_ = 0;
  int held_bits_ = 0;
};

// A string of at most kPageSlots bits, by bytes.
using BitString = std::array<uint8_t, kPageSlots / 8>;

[[gnu::noinline]] void putBits(std::span<const uint8_t> bytes, BitWriter& out) {
  const std::array<ByteCode, 4>& codes = byteCodes();
  std::array<uint32_t, 9> count{};
  for (uint8_t byte : bytes) ++count[static_cast<size_t>(std::popcount(byte))];
  uint32_t best = 0, least = ~0u;
  for (uint32_t c = 0; c < codes.size(); ++c) {
    uint32_t bits = 0;
    for (size_t ones = 0; ones < count.size(); ++ones) bits += count[ones] * codes[c].lengths[ones];
    if (bits < least) least = bits, best = c;
  }
  out.put(best, kCodeBits);
  const ByteCode& code = codes[best];
  for (uint8_t byte : bytes) out.put(code.words[byte], code.lengths[static_cast<size_t>(std::popcount(byte))]);
}

[[gnu::noinline]] void takeBits(std::span<uint8_t> bytes, BitReader& in) {
  const ByteCode& code = byteCodes()[in.take(kCodeBits)];
  for (uint8_t& byte : bytes) {
    const uint32_t word = in.peek(kLongest);
    size_t length = 1;
    while (length < kLongest && word >= code.ends[length]) ++length;
    byte = code.bytes[code.ranks[length] + ((word - code.firsts[length]) >> (kLongest - length))];
    in.skip(static_cast<int>(length));
  }
}

}  // namespace

size_t packPage(const PageKnowledge& page, std::array<uint8_t, kMostPackedBytes>& out) {
  DCHECK_TRUE(!(page.settled - page.known).any());
  BitWriter writer(out.data());
  uint32_t any = 0;
  for (uint64_t word : page.known.words) any = any << 1 | (word != 0 ? 1 : 0);
  writer.put(page.radius.value, kRadiusBits);
  writer.put(any, kWords);
  writer.put(page.finest.value, kFinestBits);
  BitString bits;
  size_t size = 0;
  for (uint64_t word : page.known.words)
    for (int i = 0; word != 0 && i < 64; i += 8) bits[size++] = static_cast<uint8_t>(word >> i);
  putBits(std::span(bits).first(size), writer);
  bits = {};
  size_t known = 0;
  page.known.forEach([&](uint8_t low) {
    bits[known / 8] = static_cast<uint8_t>(bits[known / 8] | (page.settled.has(low) ? 1u << (known % 8) : 0));
    ++known;
  });
  putBits(std::span(bits).first((known + 7) / 8), writer);
  return writer.finish();
}

PageKnowledge unpackPage(std::span<const uint8_t> bytes) {
  PageKnowledge page;
  BitReader reader(bytes);
  page.radius.value = static_cast<uint8_t>(reader.take(kRadiusBits));
  const uint32_t any = reader.take(kWords);
  page.finest.value = static_cast<uint8_t>(reader.take(kFinestBits));
  BitString bits;
  takeBits(std::span(bits).first(8 * static_cast<size_t>(std::popcount(any))), reader);
  size_t at = 0;
  for (int w = 0; w < kWords; ++w)
    for (int i = 0; (any >> (kWords - 1 - w) & 1) != 0 && i < 64; i += 8)
      page.known.words[static_cast<size_t>(w)] |= uint64_t{bits[at++]} << i;
  takeBits(std::span(bits).first((page.known.count() + 7) / 8), reader);
  size_t known = 0;
  page.known.forEach([&](uint8_t low) {
    page.settled.add(low, (bits[known / 8] >> (known % 8) & 1) != 0);
    ++known;
  });
  return page;
}

}  // namespace foreland::proto
