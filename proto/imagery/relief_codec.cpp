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

constexpr auto kSide = static_cast<ptrdiff_t>(kTileSide);
constexpr size_t kRoughnesses = 16, kGuesses = 4;

// Guesses at a height from its neighbours to the west and south, each what one kind of ground would be: a plane through
// three of them, another through W, S and SE, and straight lines along the row and the column.
using Guesses = std::array<int32_t, kGuesses>;

// At the borders neighbours that are missing are taken from the others.
Guesses guessesAt(const int32_t* at, uint32_t x, uint32_t y) {
  if (y == 0) {
    const int32_t west = x > 0 ? at[-1] : 0, line = x > 1 ? 2 * west - at[-2] : west;
    return {west, west, line, line};
  }
  const int32_t south = at[-kSide], line = y > 1 ? 2 * south - at[-2 * kSide] : south;
  if (x == 0) return {south, south, line, line};
  const int32_t west = at[-1], south_west = at[-kSide - 1], south_east = x + 1 < kTileSide ? at[1 - kSide] : south;
  return {west + south - south_west, west + south_east - south, x > 1 ? 2 * west - at[-2] : west, line};
}

// How well each guess did at the last texels: by column, of the row being coded up to here, and of the one before it
// from here on.
class Trust {
 public:
  struct Errors {
    std::array<uint32_t, kGuesses> of_guess{};
    uint32_t residual = 0;
  };

  // Sums over the four nearest texels.
  Errors around(uint32_t x) const {
    Errors sum;
    const Errors &west = row_[x], &south_west = corner_, &south = row_[x + 1], &south_east = row_[x + 2];
    for (size_t i = 0; i < kGuesses; ++i)
      sum.of_guess[i] = 2 * west.of_guess[i] + 2 * south.of_guess[i] + south_west.of_guess[i] + south_east.of_guess[i];
    sum.residual = 2 * west.residual + 2 * south.residual + south_west.residual + south_east.residual;
    return sum;
  }
  void note(uint32_t x, const Guesses& guesses, int32_t height, int32_t guess) {
    corner_ = row_[x + 1];
    Errors& here = row_[x + 1];
    for (size_t i = 0; i < kGuesses; ++i) here.of_guess[i] = distance(height, guesses[i]);
    here.residual = distance(height, guess);
  }
  void startRow() { corner_ = row_[0] = {}; }

 private:
  // Cut off where more would say nothing.
  static uint32_t distance(int32_t a, int32_t b) {
    return static_cast<uint32_t>(std::min<int64_t>(std::abs(int64_t{a} - b), 1 << 16));
  }
  std::array<Errors, kTileSide + 2> row_{};  // of columns -1 to kTileSide
  Errors corner_;                            // of the column before, in the row before
};

// The mean of the guesses, weighted by how little they were wrong.
int32_t mixOf(const Guesses& guesses, const Trust::Errors& errors) {
  int64_t sum = 0, weights = 0;
  for (size_t i = 0; i < kGuesses; ++i) {
    const uint64_t e = errors.of_guess[i] + 1;
    const auto weight = static_cast<int64_t>((uint64_t{1} << 24) / (e * e) + 1);
    sum += weight * guesses[i];
    weights += weight;
  }
  const int64_t mean = sum >= 0 ? (sum + weights / 2) / weights : -((-sum + weights / 2) / weights);
  return static_cast<int32_t>(std::clamp<int64_t>(mean, -kMaxReliefSteps, kMaxReliefSteps));
}

// Two to an octave where most ground is.
size_t roughnessOf(uint32_t sum) {
  const auto octave = static_cast<size_t>(std::bit_width(sum));
  const size_t half = octave >= 2 ? sum >> (octave - 2) & 1 : 0;
  return std::min(octave < 2 ? octave : 2 * octave - 2 + half, kRoughnesses - 1);
}

// Codes a tile into or from `steps`; false if what was read is out of range.
template <class Coder>
bool codeTile(Coder& coder, int32_t* steps) {
  std::array<NumberModel, kRoughnesses> models;
  NumberModel first;
  EscapeModel escape;
  Symbols<Coder> symbols(coder, escape);
  Trust trust;
  std::array<uint8_t, kTileSide> signs{};  // of the last residual in each column: 0, 1 negative, 2 positive
  for (uint32_t y = 0; y < kTileSide; ++y) {
    size_t west_sign = 0;
    trust.startRow();
    for (uint32_t x = 0; x < kTileSide; ++x, ++steps) {
      const Guesses guesses = guessesAt(steps, x, y);
      const Trust::Errors errors = trust.around(x);
      const int32_t guess = mixOf(guesses, errors);
      NumberModel& model = x == 0 && y == 0 ? first : models[roughnessOf(errors.residual)];
      const size_t sign_context = west_sign == 0          ? signs[x]
                                  : west_sign == signs[x] ? west_sign
                                  : west_sign == 1        ? 3
                                                          : 0;
      const int32_t residual = symbols.number(model, sign_context, *steps - guess);
      const int64_t height = int64_t{guess} + residual;
      if (std::abs(height) > kMaxReliefSteps) return false;
      *steps = static_cast<int32_t>(height);
      trust.note(x, guesses, *steps, guess);
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
