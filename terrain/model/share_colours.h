// Colours that a file has as real numbers. They are shares of 1, but some programs write 0 to 255, which only the whole
// file tells. One owner.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "terrain/model/model.h"

namespace foreland::terrain {

class ShareColours {
 public:
  bool isEmpty() const { return values_.empty(); }
  // Colour number `index`; those that are passed over are white.
  void add(size_t index, std::array<double, 4> values) {
    values_.resize(index, {1, 1, 1, 1});
    values_.emplace_back();
    for (size_t channel = 0; channel < 4; ++channel) {
      const double value = std::isfinite(values[channel]) ? std::clamp(values[channel], 0.0, 255.0) : 0;
      values_.back()[channel] = static_cast<float>(value);
      is_bytes_ |= channel < 3 && value > kBrightestShare;
    }
  }
  // Makes bytes of them, with a note if they were such. An alpha that was not given is 1.
  std::vector<Colour> finish(std::vector<std::string>& notes) const {
    if (is_bytes_) notes.push_back("colours taken as 0 to 255, because some are far above 1");
    std::vector<Colour> colours;
    colours.reserve(values_.size());
    for (const auto& from : values_) {
      const bool is_white = from == std::array<float, 4>{1, 1, 1, 1};
      colours.push_back({255, 255, 255, 255});
      for (size_t channel = 0; channel < 4 && !is_white; ++channel) {
        const bool is_share = !is_bytes_ || (channel == 3 && from[channel] <= 1);
        const double scaled = is_share ? 255 * std::min(1.0, double{from[channel]}) : double{from[channel]};
        colours.back()[channel] = static_cast<uint8_t>(std::lround(scaled));
      }
    }
    return colours;
  }

 private:
  static constexpr double kBrightestShare = 2;  // no share of light is more, not even a bright one's

  std::vector<std::array<float, 4>> values_;
  bool is_bytes_ = false;
};

}  // namespace foreland::terrain
