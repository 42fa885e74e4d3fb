#include "proto/refine/memory/page_knowledge.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "base/bits.h"
#include "base/check.h"

namespace foreland::proto {

namespace {

constexpr uint32_t kLongest = 12;  // bits of a code word
constexpr int kCodeBits = 2;

// In a byte. Not every processor has an instruction for it.
constexpr std::array<uint8_t, 256> kOnes = [] {
  std::array<uint8_t, 256> ones{};
  for (uint32_t byte = 0; byte < 256; ++byte) ones[byte] = static_cast<uint8_t>(std::popcount(byte));
  return ones;
}();

// A canonical prefix code of bytes whose words are as long for all bytes of as many ones (Schwartz and Kallick 1964).
struct ByteCode {
  std::array<uint8_t, 9> lengths;                  // by the number of ones
  std::array<uint16_t, 256> words{};               // by byte; the first bit is the lowest
  std::array<uint32_t, kLongest + 1> of_length{};  // how many words are so long
  std::array<uint8_t, 256> bytes{};                // by the order of their words

  explicit ByteCode(const std::array<uint8_t, 9>& of) : lengths(of) {
    uint32_t word = 0;
    size_t rank = 0;
    for (uint32_t length = 1; length <= kLongest; ++length, word <<= 1)
      for (uint32_t byte = 0; byte < 256; ++byte) {
        if (lengthOf(byte) != static_cast<int>(length)) continue;
        for (uint32_t bit = 0; bit < length; ++bit)
          words[byte] = static_cast<uint16_t>(words[byte] | (word >> (length - 1 - bit) & 1) << bit);
        ++word;
        ++of_length[length];
        bytes[rank++] = static_cast<uint8_t>(byte);
      }
  }
  int lengthOf(uint32_t byte) const { return lengths[kOnes[byte]]; }
};

// For bytes of any kind, mostly zeros, some of both, mostly ones. Made at the first use: the page's module is small.
const std::array<ByteCode, 4>& byteCodes() {
  static const std::array<ByteCode, 4> kCodes{
      ByteCode({8, 8, 8, 8, 8, 8, 8, 8, 8}), ByteCode({1, 5, 8, 10, 11, 11, 11, 10, 9}),
      ByteCode({3, 6, 7, 8, 9, 10, 9, 8, 5}), ByteCode({6, 10, 11, 12, 11, 10, 8, 5, 1})};
  return kCodes;
}

// In the code that makes them shortest.
void putBytes(std::span<const uint8_t> bytes, BitWriter& out) {
  const std::array<ByteCode, 4>& codes = byteCodes();
  uint32_t best = 0;
  int least = INT32_MAX;
  for (uint32_t c = 0; c < codes.size(); ++c) {
    int bits = 0;
    for (uint8_t byte : bytes) bits += codes[c].lengthOf(byte);
    if (bits < least) least = bits, best = c;
  }
  out.put(best, kCodeBits);
  for (uint8_t byte : bytes) out.put(codes[best].words[byte], codes[best].lengthOf(byte));
}

// Words of a length are consecutive numbers, and begin with twice what follows the last of those shorter by one.
uint8_t takeByte(const ByteCode& code, BitReader& in) {
  uint32_t word = 0, first = 0, rank = 0;
  for (uint32_t length = 1; length <= kLongest; ++length) {
    word = word << 1 | static_cast<uint32_t>(in.get(1));
    const uint32_t count = code.of_length[length];
    if (word - first < count) return code.bytes[rank + word - first];
    first = (first + count) << 1;
    rank += count;
  }
  return 0;  // no word
}

void takeBytes(std::span<uint8_t> bytes, BitReader& in) {
  const ByteCode& code = byteCodes()[in.get(kCodeBits)];
  for (uint8_t& byte : bytes) byte = takeByte(code, in);
}

}  // namespace

void packPage(const PageKnowledge& page, Bytes& out) {
  DCHECK_TRUE(!(page.settled - page.known).any());
  BitWriter writer(out);
  uint32_t any = 0;
  std::array<uint8_t, kPageSlots / 8> bytes;
  size_t size = 0;
  for (size_t w = 0; w < page.known.words.size(); ++w) {
    const uint64_t word = page.known.words[w];
    any |= (word != 0 ? 1u : 0u) << w;
    for (int i = 0; word != 0 && i < 64; i += 8) bytes[size++] = static_cast<uint8_t>(word >> i);
  }
  writer.put(page.radius.value, 8);
  writer.put(any, 4);
  writer.put(page.finest.value, 8);
  putBytes(std::span(bytes).first(size), writer);
  bytes = {};
  size_t known = 0;
  page.known.forEach([&](uint8_t low) {
    bytes[known / 8] = static_cast<uint8_t>(bytes[known / 8] | (page.settled.has(low) ? 1u << (known % 8) : 0));
    ++known;
  });
  putBytes(std::span(bytes).first((known + 7) / 8), writer);
  writer.finish();
}

PageKnowledge unpackPage(ByteSpan packed) {
  PageKnowledge page;
  BitReader reader(packed);
  page.radius.value = static_cast<uint8_t>(reader.get(8));
  const auto any = static_cast<uint32_t>(reader.get(4));
  page.finest.value = static_cast<uint8_t>(reader.get(8));
  std::array<uint8_t, kPageSlots / 8> bytes;
  takeBytes(std::span(bytes).first(8 * static_cast<size_t>(std::popcount(any))), reader);
  size_t at = 0;
  for (size_t w = 0; w < page.known.words.size(); ++w)
    for (int i = 0; (any >> w & 1) != 0 && i < 64; i += 8) page.known.words[w] |= uint64_t{bytes[at++]} << i;
  takeBytes(std::span(bytes).first((page.known.count() + 7) / 8), reader);
  size_t known = 0;
  page.known.forEach([&](uint8_t low) {
    page.settled.add(low, (bytes[known / 8] >> (known % 8) & 1) != 0);
    ++known;
  });
  return page;
}

}  // namespace foreland::proto
