// From a file's raw numbers to heights in metres: decides which numbers mean "no data" and which cannot be heights.
// First `observe` (some of) the data, then `classifySentinels`, then `decode` rows. One owner.
//
// Besides the tagged nodata value and what is not finite, -999, -9999, -32767, -32768 and 32767 are voids when no other
// height lies near them: such files exist, with the sentinel in the data and not in the header.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

class HeightDecoder {
 public:
  static constexpr float kLowestPlausible_m = -12000;   // below the deepest trench
  static constexpr float kHighestPlausible_m = 100000;  // above the highest mountain of any body
  static constexpr std::array<float, 5> kSentinels{-999, -9999, -32767, -32768, 32767};

  struct Units {
    double scale = 1, offset = 0;  // metres = raw * scale + offset
  };
  HeightDecoder(std::optional<double> nodata, Units units);

  void observe(std::span<const float> raw);
  void classifySentinels();
  void decode(std::span<float> values) const;  // raw numbers become metres, kVoid where there is no data

  const HeightSurvey& survey() const { return survey_; }
  std::vector<std::string> notes() const;

 private:
  bool isTaggedVoid(float raw) const;
  float metres(float raw) const { return static_cast<float>(raw * units_.scale + units_.offset); }

  std::optional<float> nodata_;
  Units units_;
  HeightSurvey survey_;
  std::array<uint64_t, kSentinels.size()> sentinel_count_{};
  std::array<bool, kSentinels.size()> sentinel_is_void_{};
  uint64_t implausible_ = 0;
  float implausible_example_ = 0;
  bool has_height_ = false;  // whether a raw number was a height beyond doubt
};

using ReadRaw = std::function<Status(uint32_t first, uint32_t count, std::span<float> out)>;

// Lets `decoder` observe the whole raster, or only bands spread over a large one, unless these hold nothing but voids;
// then classifies the sentinels.
Status surveyHeights(uint32_t width, uint32_t height, const ReadRaw& read, HeightDecoder& decoder);

}  // namespace foreland::terrain
