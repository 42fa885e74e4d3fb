#include "terrain/build/fill.h"

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

Status fill(std::span<float> metres, const ElevationInfo& info, SceneOrigin& origin) {
  const auto voids = static_cast<uint64_t>(std::count_if(metres.begin(), metres.end(), [](float m) { return std::isnan(m); }));
  if (voids == metres.size())
    return Error{ErrorCode::kMalformed, info.title + ": holds no data, only voids; check --nodata"};
  origin.voids_filled = voids;
  if (voids == 0) return {};
  float last = *std::find_if(metres.begin(), metres.end(), [](float m) { return !std::isnan(m); });
  for (float& m : metres) m = std::isnan(m) ? last : (last = m);
  origin.notes.push_back(std::to_string(voids) + " samples without data took the height west of them");
  return {};
}

}  // namespace foreland::terrain
