// What a page is told of the sea of a globe, in a file beside the scene (sea.bin): whether it is drawn, and how far the
// geoid, which it lies on, is above the ellipsoid. docs/PROTOCOL.md, section 20, has the bytes. Pure; any
// thread.
#pragma once

#include <string>

#include "proto/space/vertical.h"

namespace foreland::server {

// Undulations are rounded to multiples of this, which moves them by at most half of it.
inline constexpr double kSeaStep_m = 0.05;

// Of a scene without a sea the undulations are thinned: colours need no more. O(values).
std::string seaFile(bool has_sea, const proto::UndulationGrid& undulations);

}  // namespace foreland::server
