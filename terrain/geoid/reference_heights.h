// What a reference system says of its heights. Pure; any thread.
#pragma once

#include <string>

namespace foreland::terrain {

enum class StatedHeights { kNone, kEllipsoid, kVerticalSystem };

struct HeightStatement {
  StatedHeights kind = StatedHeights::kNone;
  std::string name;  // of the vertical reference system
};

// Of a reference system as WKT: a compound one names a vertical system, one of three dimensions is above its ellipsoid.
HeightStatement heightsOf(const std::string& wkt);

}  // namespace foreland::terrain
