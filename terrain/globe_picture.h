// Pictures of a whole body, or of parts of it, as the builder of globes sees them: a colour wherever there is a
// direction. Implemented by terrain/dem (files) and by tests (formulas).
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "terrain/globe_source.h"
#include "terrain/picture_source.h"

namespace foreland::terrain {

// Directions are normals of the ellipsoid, as GlobeSource has them. Immutable; any thread.
class GlobePicture {
 public:
  virtual ~GlobePicture() = default;
  // What was assumed about the files, a sentence each.
  virtual const std::vector<std::string>& notes() const = 0;
  // Radians between pixels of the finest picture: of all, and of those that may show something in a patch; infinite if
  // there are none.
  virtual double finestSpacing() const = 0;
  virtual double spacingIn(const GlobePatch& patch) const = 0;
  // What a square about a direction (of any length but 0) shows whose sides are so many radians.
  virtual Rgba colourAt(const glm::dvec3& direction, double width_rad) const = 0;
};

}  // namespace foreland::terrain
