// How much a raster counts near its edges, so that what lies below it comes in without a cliff. Pure; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "terrain/dem/insets/samples.h"

namespace foreland::terrain {

// A weight for each sample: 0 where it has no data, and where it is the last before such, voids and the raster's border
// alike; from there smoothstep of the distance over `width_m`, at which it is 1. The distance is Euclid's, of samples
// that lie spacing_m apart along columns and rows. A width of 0: 1 wherever there is data. O(samples).
std::vector<float> featherWeights(const Samples& samples, glm::dvec2 spacing_m, double width_m);

// Of such weights, at a place that has data; bilinear.
double weightAt(const Samples& samples, const std::vector<float>& weights, glm::dvec2 p);

}  // namespace foreland::terrain
