// Fits error shapes (proto/section/surface_bounds.h) to errors. Of an error vector only the components along and across
// the normal matter. Pure; any thread.
#pragma once

#include <span>
#include <vector>

#include "proto/section/surface_bounds.h"

namespace foreland::terrain {

using proto::ErrorShape;

struct Extent {
  double along = 0, across = 0;  // not negative
};

// The factor by which `shape` must grow until it touches `error`: at most 1 inside. 0 for no error, infinite if no
// growth helps.
double gauge(ErrorShape kind, const Extent& shape, const Extent& error);

// The shape that holds `errors` and is seen smallest on average over all directions. (S equation 3 and Hoppe take the
// ratio of the errors' largest parts and let the shape grow until it holds them all. That makes shapes up to 1.4 and 2
// times as long as a single error, whatever its direction.) Sorts and thins `errors`. Cost: O(n log n).
Extent boundingShape(ErrorShape kind, std::vector<Extent>& errors);
// The same with that ratio, for comparison.
Extent boundingShapeByLargest(ErrorShape kind, std::span<const Extent> errors);

// Root of the mean square, over all directions, of the radius that a shape shows to the eye.
double meanRadius(ErrorShape kind, const Extent& shape);

// Adds points on the outline of `other`, whose normal is at an angle, by their components along and across this normal.
void addOutline(ErrorShape kind, const Extent& other, double cosine, double sine, std::vector<Extent>& points);

// The factor by which `shape` about `normal` must grow until it holds `other` about `other_normal`. Unit normals. At
// least rounding above the least one.
double growthToHold(ErrorShape kind, const Extent& shape, const glm::dvec3& normal, const Extent& other,
                    const glm::dvec3& other_normal);

}  // namespace foreland::terrain
