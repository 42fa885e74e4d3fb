// Fills what the source has no data for, and says so in the scene's origin. One owner.
#pragma once

#include <span>

#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

// Leaves no void in `metres`; counts them in origin.voids_filled and notes how. Nothing but voids is an error.
[[nodiscard]] Status fill(std::span<float> metres, const ElevationInfo& info, SceneOrigin& origin);

}  // namespace foreland::terrain
