// The views of the keyframes of a flight along a path, as a session that knows the path would refine them. Pure.
#pragma once

#include <vector>

#include "proto/space/path.h"
#include "proto/space/view.h"
#include "server/view/region.h"

namespace foreland::lab {

// Where a section keeps tau: at its keyframe's pose alone, or from anywhere between the keyframes before and after it.
enum class Guarantee { kKeyframesOnly, kEveryFrame };

struct FlightOptions {
  proto::Lens lens{1.0471975511965976, 1920, 1080};
  double tau_px = 1;
  Duration keyframe_interval = Duration::milliseconds(200);
  double seconds = 60;
};

inline std::vector<proto::View> keyframeViews(const proto::Path& path, const FlightOptions& options,
                                              Guarantee guarantee) {
  std::vector<proto::View> views;
  const Duration T = options.keyframe_interval;
  for (Time t; t <= Time::seconds(options.seconds); t = t + T) {
    proto::View view{path.at(t), options.lens, options.tau_px};
    if (guarantee == Guarantee::kEveryFrame) {
      const server::Region region = server::regionOf(view.pose, server::ExpectedMotion(path), t - T, t + T);
      view.region_radius_m = region.radius_m;
      view.region_angle_rad = region.angle_rad;
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace foreland::lab
