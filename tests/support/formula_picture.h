// A picture from a formula of lattice positions.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>

#include "terrain/picture_source.h"

namespace foreland::test {

class FormulaPicture final : public terrain::PictureSource {
 public:
  using Formula = std::function<terrain::Rgba(double x, double y)>;
  FormulaPicture(uint32_t samples_x, uint32_t samples_y, double texel, Formula formula) : formula_(std::move(formula)) {
    info_.texel = texel;
    info_.origin = {-0.5, -0.5};
    info_.width = static_cast<uint32_t>(std::ceil(samples_x / texel));
    info_.height = static_cast<uint32_t>(std::ceil(samples_y / texel));
  }
  const terrain::PictureInfo& info() const override { return info_; }
  Status read(const terrain::PictureWindow& w, std::span<terrain::Rgba> out) override {
    EXPECT_LE(w.x + w.width, info_.width);
    EXPECT_LE(w.y + w.height, info_.height);
    size_t i = 0;
    for (uint32_t y = w.y; y < w.y + w.height; ++y)
      for (uint32_t x = w.x; x < w.x + w.width; ++x)
        out[i++] = formula_(info_.origin.x + (x + 0.5) * info_.texel, info_.origin.y + (y + 0.5) * info_.texel);
    return {};
  }

 private:
  terrain::PictureInfo info_;
  Formula formula_;
};

}  // namespace foreland::test
