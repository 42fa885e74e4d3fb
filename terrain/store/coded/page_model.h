// What a coder of pages knows of the numbers that it codes (group_codec.h): one probability for each context. Those of
// a scene start where its pages want them, which the scene file says, so that a group of few pages is coded nearly as
// well as the whole. Plain data.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "base/bytes.h"
#include "proto/codec/range_coder.h"
#include "proto/codec/symbols.h"

namespace foreland::terrain {

struct PageModel {
  // Half octaves of what a node's neighbours let expect of its height; how what its parents' errors allow compares with
  // that; half octaves between the least and the largest error that a node may have; levels from the finest on.
  static constexpr size_t kExpected = 24, kCaps = 10, kGaps = 14, kDepths = 4;

  std::array<proto::AdaptiveBit, 2> is_verbatim;  // by whether the page before was
  std::array<proto::AdaptiveBit, 128> radius;
  std::array<proto::NumberModel, kExpected * kCaps> height;
  proto::NumberModel copied_height;             // of nodes beyond the data
  std::array<proto::AdaptiveBit, 8> has_error;  // by three reasons why not
  std::array<std::array<proto::AdaptiveBit, 32>, kDepths * kGaps> error;
  proto::EscapeModel escape;

  std::span<proto::AdaptiveBit> contexts() {
    return {reinterpret_cast<proto::AdaptiveBit*>(this), sizeof(*this) / sizeof(proto::AdaptiveBit)};
  }
};
static_assert(std::is_trivially_copyable_v<PageModel> && alignof(PageModel) == alignof(proto::AdaptiveBit));

inline constexpr size_t kPageContexts = sizeof(PageModel) / sizeof(proto::AdaptiveBit);

// The probability of `true` that each context starts with, in steps of a quarter of an octave of the rarer answer.
class ModelStart {
 public:
  // Of contexts that answered so often.
  void set(size_t context, uint64_t no, uint64_t yes);
  // The model as it is at the start of a group.
  void apply(PageModel& model) const;

  // As few bytes as the contexts that are not even ask for.
  Bytes encode() const;
  // False if the bytes are no start.
  [[nodiscard]] bool decode(ByteSpan bytes);

  bool operator==(const ModelStart&) const = default;

 private:
  // 0: even; below kSteps `true` is so much rarer, from kSteps on `false`.
  static constexpr uint8_t kSteps = 28;
  static uint16_t probability(uint8_t step);

  std::array<uint8_t, kPageContexts> steps_{};
};

}  // namespace foreland::terrain
