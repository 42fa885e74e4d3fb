// From a file's raw numbers to heights in metres: which of them mean "no data", which cannot be heights. First `look`
// at (some of) the data, then `settle`, then `decode` rows. One owner.
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

  void look(std::span<const float> raw);
  void settle();
  void decode(std::span<float> values) const;  // after settle

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
  bool seen_ = false;  // some height
};

using ReadRaw = std::function<Status(uint32_t first, uint32_t count, std::span<float> out)>;

// Looks at the whole raster, or at bands spread over a large one; at all of a large one if the bands hold nothing but
// voids.
Status surveyHeights(uint32_t width, uint32_t height, const ReadRaw& read, HeightDecoder& decoder);

}  // namespace foreland::terrain
