#include "proto/imagery/relief_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "base/check.h"
#include "proto/codec/range_coder.h"
#include "proto/codec/symbols.h"

namespace foreland::proto {

namespace {

constexpr size_t kRoughnesses = 14;

// The known neighbours of a height: to the west, south, south-west and south-east. At the southern and western borders
// those that are missing are taken from the others.
struct Neighbours {
  int32_t west, south, south_west, south_east;

  static Neighbours of(const int32_t* at, uint32_t x, uint32_t y) {
    constexpr auto kSide = static_cast<ptrdiff_t>(kTileSide);
    if (y == 0) {
      const int32_t west = x > 0 ? at[-1] : 0;
      return {west, west, west, west};
    }
    const int32_t south = at[-kSide];
    const int32_t south_east = x + 1 < kTileSide ? at[1 - kSide] : south;
    if (x == 0) return {south, south, south, south_east};
    return {at[-1], south, at[-kSide - 1], south_east};
  }

  // The plane through the three, kept between west and south where the ground bends.
  int32_t predict() const {
    const int32_t low = std::min(west, south), high = std::max(west, south);
    return std::clamp(west + south - south_west, low, high);
  }
  size_t roughness() const {
    const uint32_t sum = static_cast<uint32_t>(std::abs(west - south_west)) +
                         static_cast<uint32_t>(std::abs(south - south_west)) +
                         static_cast<uint32_t>(std::abs(south_east - south));
    // Two to an octave where most ground is.
    const auto octave = static_cast<size_t>(std::bit_width(sum));
    const size_t half = octave >= 2 ? sum >> (octave - 2) & 1 : 0;
    return std::min(octave < 2 ? octave : 2 * octave - 2 + half, kRoughnesses - 1);
  }
};

// Codes a tile into or from `steps`; false if what was read is out of range.
template <class Coder>
bool codeTile(Coder& coder, int32_t* steps) {
  std::array<NumberModel, kRoughnesses> models;
  NumberModel first;
  EscapeModel escape;
  Symbols<Coder> symbols(coder, escape);
  std::array<uint8_t, kTileSide> signs{};  // of the last residual in each column: 0, 1 negative, 2 positive
  for (uint32_t y = 0; y < kTileSide; ++y) {
    size_t west_sign = 0;
    for (uint32_t x = 0; x < kTileSide; ++x, ++steps) {
      const Neighbours near = Neighbours::of(steps, x, y);
      const int32_t predicted = near.predict();
      NumberModel& model = x == 0 && y == 0 ? first : models[near.roughness()];
      const size_t sign_context = west_sign == 0          ? signs[x]
                                  : west_sign == signs[x] ? west_sign
                                  : west_sign == 1        ? 3
                                                          : 0;
      const int32_t residual = symbols.number(model, sign_context, *steps - predicted);
      const int64_t height = int64_t{predicted} + residual;
      if (std::abs(height) > kMostReliefSteps) return false;
      *steps = static_cast<int32_t>(height);
      west_sign = signs[x] = residual == 0 ? 0 : residual < 0 ? 1 : 2;
    }
  }
  return true;
}

}  // namespace

Bytes encodeRelief(std::span<const int32_t> steps) {
  CHECK_EQ(steps.size(), kTileTexels);
  std::vector<int32_t> copy(steps.begin(), steps.end());
  Bytes out;
  RangeEncoder encoder(out);
  CHECK_TRUE(codeTile(encoder, copy.data()));
  encoder.finish();
  return out;
}

Status decodeRelief(ByteSpan bytes, std::span<int32_t> steps) {
  CHECK_EQ(steps.size(), kTileTexels);
  RangeDecoder decoder(bytes);
  std::fill(steps.begin(), steps.end(), 0);
  if (!codeTile(decoder, steps.data()) || !decoder.atEnd())
    return Error{ErrorCode::kMalformed, "the heights of a tile are damaged"};
  return {};
}

}  // namespace foreland::proto
