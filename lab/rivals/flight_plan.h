// What node needs to fly a rival in a browser as we fly: the ground, the camera's poses by time, and where our programs
// are. Blocks; any thread.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/result.h"
#include "proto/space/path.h"
#include "terrain/store/scene.h"

namespace foreland::lab {

struct RivalsFlight {
  std::shared_ptr<const terrain::Scene> scene;
  std::filesystem::path scene_path;
  proto::Path path;
  double seconds = 10;
  double poses_per_s = 10;
  proto::Lens lens{};
  double tau_px = 1;
};

// Where measure.mjs lies.
std::filesystem::path rivalsSources();

// The ground goes to `folder` as heights.f64: float64 metres, row by row from the south, native byte order. The plan
// that is returned names it, and is to be told to measure.mjs with what else it asks for (lab/README.md). An
// Error if the scene has no longitude and latitude, which tiles are cut by, or moves or has objects, which rivals'
// tiles have not.
Result<nlohmann::ordered_json> writeFlightPlan(const RivalsFlight& flight, const std::filesystem::path& folder);

}  // namespace foreland::lab
