// How much each epoch contributes to the ground at a scene time, by the formulas of THEORY section 2 and decision 0015
// in another form than proto/section/epochs.h has them: Hermite's for Catmull-Rom, Cox's and de Boor's recursion for
// the B-spline. So a mistake there cannot hide itself. Pure; O(epochs).
#pragma once

#include <span>
#include <vector>

#include "base/time.h"
#include "proto/section/epochs.h"

namespace foreland::oracle {

// By epoch; of sum 1. `epochs` ascend; beyond them the ground is as at the nearest.
std::vector<double> epochShares(std::span<const Time> epochs, proto::EpochBlend blend, Time at);

}  // namespace foreland::oracle
