// What a ray meets first: on a scene at full resolution, with its objects, or on a mesh as a client draws it. It is the
// reference that pictures, error images and judgements of visibility are made with, so it shares no code with the
// refiner, with bounds, or with the server's own visibility queries.
//
// The surface is piecewise linear between the vertices that it is made of; full resolution is every sample, cut into
// the triangles of the finest section (proto/topology/grid.h). Nothing lies beyond the data.
//
// Precision. Embree chooses the triangle in floats, relative to an origin in the middle of the scene (the drawn mesh's
// own origin); the point is then computed on that triangle in doubles. So a hit lies on the surface to 1e-6 m, and
// along the ray to 1e-6 m unless the ray passes within the floats' error of the triangle's border: then another
// triangle may be taken, or a ridge just missed or met. That error is at most 2^-20 of the largest distance from the
// origin: 1 cm for a scene of 20 km, 10 cm for one of 200 km. There the point is the nearest on the triangle chosen. Of
// globes the origin is the eye, so that error is as small on a picture wherever it is.
//
// Immutable after creation; any thread may cast. A full-resolution caster holds about 45 bytes a triangle and reads the
// scene's heights. Building it takes about half a microsecond a triangle on two processors, a ray about a microsecond
// on one (measured on 5.3 million triangles of Mount St. Helens).
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/section/epochs.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

struct Ray {
  glm::dvec3 origin{0};     // scene frame, metres
  glm::dvec3 direction{0};  // unit
  double farthest_m = std::numeric_limits<double>::infinity();
};

struct RayHit {
  static constexpr int32_t kTerrain = -1;

  double distance_m = 0;
  glm::dvec3 position{0};  // scene frame, metres
  glm::dvec3 normal{0};    // unit, of the triangle: upward from the terrain, outward from objects
  int32_t object = kTerrain;
  // The parameter of the point, and of the triangle's corner nearest to it: lattice position on the terrain; on objects
  // texture coordinates in the model's image, all (0, 0) if it has none.
  glm::dvec2 parameter{0}, corner{0};
  double height_m = 0;  // above the zero surface, interpolated between the corners; 0 on objects
};

// A mesh as a client draws it in one frame. Plain data, of whoever holds such meshes.
struct DrawnSurface {
  struct Triangles {
    std::vector<glm::vec3> positions;   // relative to `origin`, metres
    std::vector<float> heights_m;       // above the zero surface, by vertex; empty: all 0
    std::vector<glm::vec2> parameters;  // by vertex, as RayHit::parameter
    std::vector<uint32_t> indices;
  };
  glm::dvec3 origin{0};  // scene frame, metres
  Triangles terrain, objects;
  std::vector<uint32_t> object_begin;  // the first triangle of each object
};

class RayCaster {
 public:
  // All that the scene file holds, at full resolution; in scenes that change in time as it is at `scene_time`, before
  // the first epoch as at it. An Error if its objects are damaged, or if it does not fit into memory (more than 2^28
  // samples are refused at once), or is a globe.
  static Result<RayCaster> ofScene(std::shared_ptr<const Scene> scene, Time scene_time = {-proto::Epochs::kMaxTime_us});
  // Of a globe, for rays from `eye` alone: about it floats are exact enough at any distance, and what the body hides
  // from it is left out. An Error as of ofScene(), and where more than 2^26 triangles of ground may be seen.
  static Result<RayCaster> ofGlobe(std::shared_ptr<const Scene> scene, const glm::dvec3& eye);
  static Result<RayCaster> ofSurface(DrawnSurface surface);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  std::optional<RayHit> hit(const Ray& ray) const;
  // hits[i] of rays[i]; 0 threads: one a processor. The result does not depend on their number.
  void hit(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits, unsigned threads = 0) const;

  uint64_t bytes() const;  // of Embree's

  // What ray_caster.cpp, full_scene.cpp and drawn_surface.cpp share.
  struct Impl;

 private:
  explicit RayCaster(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace foreland::terrain
