// A path through a town of objects: along its streets, from one side to the other, as far from all objects as may be.
// Pure. Cost: some milliseconds for a thousand objects.
#pragma once

#include "base/result.h"
#include "proto/space/path.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct StreetOptions {
  double height_m = 2;  // of the eye above the ground
  double speed_mps = 15;
  double seconds = 60;  // at most; the path ends at the town's other side
};

// Level views along the way. An Error if the scene has no objects, or no way leads between them.
Result<proto::Path> streetPath(const server::Hierarchy& hierarchy, const StreetOptions& options);

}  // namespace foreland::lab
