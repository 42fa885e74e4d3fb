#include "terrain/dem/vertical/shifted_raster.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

namespace foreland::terrain {

namespace {

class ShiftedRaster final : public Raster {
 public:
  ShiftedRaster(std::unique_ptr<Raster> inner, MapPlaces places, HeightReference from, HeightReference to)
      : inner_(std::move(inner)), places_(std::move(places)), from_(std::move(from)), to_(std::move(to)) {}

  const RasterInfo& info() const override { return inner_->info(); }

  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    if (Status s = inner_->readRows(first, count, out); !s.ok()) return s;
    const uint32_t width = info().width;
    for (uint32_t i = 0; i < count; ++i)
      if (Status s = shift(first + i, out.subspan(size_t{i} * width, width)); !s.ok()) return s;
    return {};
  }

 private:
  Status shift(uint32_t row, std::span<float> heights) {
    degrees_.resize(heights.size());
    for (size_t column = 0; column < heights.size(); ++column) degrees_[column] = {static_cast<double>(column), row};
    places_.toDegrees(degrees_);
    shifts_.assign(heights.size(), 0);
    add(from_, 1);
    add(to_, -1);
    for (size_t column = 0; column < heights.size(); ++column) {
      if (std::isnan(heights[column])) continue;
      if (std::isnan(shifts_[column]))
        return Error{ErrorCode::kUnsupported,
                     fmt::format("{}: {} or {} has no undulation at longitude {:.5f}, latitude {:.5f}; its grid does "
                                 "not reach so far",
                                 info().name, from_.name, to_.name, degrees_[column].x, degrees_[column].y)};
      heights[column] = static_cast<float>(heights[column] + shifts_[column]);
    }
    return {};
  }

  void add(const HeightReference& reference, double sign) {
    if (!reference.geoid) return;
    undulations_.resize(degrees_.size());
    reference.geoid->undulations(degrees_, undulations_);
    for (size_t i = 0; i < shifts_.size(); ++i) shifts_[i] += sign * undulations_[i];
  }

  std::unique_ptr<Raster> inner_;
  MapPlaces places_;
  HeightReference from_, to_;
  std::vector<glm::dvec2> degrees_;
  std::vector<double> shifts_, undulations_;
};

}  // namespace

std::unique_ptr<Raster> shiftedRaster(std::unique_ptr<Raster> inner, MapPlaces places, HeightReference from,
                                      HeightReference to) {
  return std::make_unique<ShiftedRaster>(std::move(inner), std::move(places), std::move(from), std::move(to));
}

}  // namespace foreland::terrain
