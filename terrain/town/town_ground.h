// The ground of a synthetic town: a mountain landscape (terrain/synth/landscape.h) that becomes a gently rolling plain
// in the middle. The same arguments give the same heights. One owner.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "terrain/elevation_source.h"

namespace foreland::terrain {

struct TownGroundOptions {
  double plain_radius_m = 500;  // about the middle
  double side_m = 3000;         // of the whole; at least twice the plain's radius
  double spacing_m = 4;
  uint64_t seed = 1;
};

class TownGround final : public ElevationSource {
 public:
  // An Error for sizes and spacings that Landscape refuses.
  static Result<std::unique_ptr<TownGround>> create(const TownGroundOptions& options);

  const ElevationInfo& info() const override { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override;
  // The middle in the map's metres, which the frame's origin is in.
  glm::dvec2 middle() const;

 private:
  void flatten(const TownGroundOptions& options);

  ElevationInfo info_;
  std::vector<float> heights_;
};

}  // namespace foreland::terrain
