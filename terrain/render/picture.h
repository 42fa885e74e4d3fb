// Reference pictures: what a camera sees, pixel by pixel, by rays through the pixels' middles, and how far what is
// drawn is from it. Pure functions; any thread; they use threads of their own while they run, and the result does not
// depend on how many. About 1 microsecond a pixel and processor.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "proto/space/pose.h"
#include "proto/topology/grid.h"
#include "terrain/render/parameter_lookup.h"
#include "terrain/render/ray_caster.h"
#include "terrain/render/shading.h"

namespace foreland::terrain {

struct Camera {
  proto::Pose pose;
  proto::Lens lens;
  unsigned threads = 0;  // 0: one a processor
};

// What pixels say that show no node, or no object.
inline constexpr uint32_t kNothing = 0xffffffffu;

// Row by row from the top. `error_px` is empty until somebody measures it.
struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<float> depth_m;     // along the direction of view; infinite in the sky
  std::vector<glm::vec3> normal;  // RayHit's, scene frame; zero in the sky
  // The lower 32 bits of the slot of the terrain's node at the corner of the triangle that is nearest to the point;
  // kNothing in the sky, on
  // objects, at base vertices, and where a drawn triangle was cut at the border of the data.
  std::vector<uint32_t> node;
  std::vector<uint32_t> object;   // 0 the terrain, 1 + i object i, kNothing the sky
  std::vector<glm::vec3> colour;  // linear
  std::vector<float> error_px;    // see measureErrors
};

Picture takePicture(const RayCaster& surface, const proto::GridTopology& grid, const Shading& shading,
                    const Camera& camera);

// Row by row from the top.
struct PixelErrors {
  std::vector<float> px;
  std::vector<uint32_t> object;  // as Picture's, of the true surface
};

// At every pixel: the true point of the surface that it shows, and the point with the same parameter on the drawn mesh;
// how far apart they lie on the screen, in pixels. Not a number where nothing is seen, or an object without an image,
// which has no parameters; infinite where the point is not drawn at all, or behind the eye.
PixelErrors measureErrors(const RayCaster& truth, const ParameterLookup& drawn, const Camera& camera);

// Of the pixels of a picture where there is an error. Sections keep the tolerance on the terrain; on objects at
// silhouettes, and seven times as much elsewhere (proto/refine/surface/surface_domain.h), so those are apart.
struct ErrorSummary {
  double terrain_max_px = 0, objects_max_px = 0;
  uint64_t terrain_pixels = 0, terrain_over_tau = 0;

  void add(const ErrorSummary& other) {
    terrain_max_px = std::max(terrain_max_px, other.terrain_max_px);
    objects_max_px = std::max(objects_max_px, other.objects_max_px);
    terrain_pixels += other.terrain_pixels;
    terrain_over_tau += other.terrain_over_tau;
  }
};
// Errors over `tau_px` by less than a thousandth of a pixel, which floats may make, are not counted as over.
ErrorSummary summarise(const PixelErrors& errors, double tau_px);

}  // namespace foreland::terrain
