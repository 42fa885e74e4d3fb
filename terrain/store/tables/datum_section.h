// The section of the vertical datum as it lies in a scene file: what heights count from, undulations, and the inputs
// that were brought to it. Change docs/SCENE_FORMAT.md with it. Pure; any thread.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/section/epochs.h"
#include "proto/space/vertical.h"

namespace foreland::terrain {

// An input of a scene. Where several have a sample in their windows, the first that has data there counts.
struct SceneInput {
  std::string name;
  std::string vertical;         // what its heights counted from; empty if that is not stated
  proto::LatticeWindow window;  // samples
  bool may_have_voids = false;
  // By how much the scene differs from it at most, at its own samples; not a number if that is not known.
  double residual_m = std::numeric_limits<double>::quiet_NaN();
  // How far from its edges it is mixed with what lies below, metres: there and under inputs that come before it, the
  // residual does not hold.
  double feather_m = 0;
};

struct SceneDatum {
  proto::VerticalDatum vertical;
  std::vector<SceneInput> inputs;
};

inline constexpr uint64_t kMaxDatumBytes = 1u << 25;

Bytes encodeDatum(const SceneDatum& datum);
// An Error: bytes that are none, or an input beyond the scene's samples.
Result<SceneDatum> decodeDatum(ByteSpan bytes, uint32_t samples_x, uint32_t samples_y);

// What the text of a reference system (WKT) says of heights: the name of its vertical part, or its ellipsoid; unstated
// if nothing. For scenes that do not state their datum themselves.
proto::VerticalDatum datumOfReferenceSystem(const std::string& wkt);

}  // namespace foreland::terrain
