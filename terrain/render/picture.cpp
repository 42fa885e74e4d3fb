#include "terrain/render/picture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "terrain/parallel.h"
#include "terrain/render/projector.h"

namespace foreland::terrain {

namespace {

constexpr double kRounding_px = 1e-3;

// visit(pixel, ray) for all pixels, on several threads.
template <class Visit>
void forEachPixel(const Camera& camera, const Projector& projector, const Visit& visit) {
  const uint32_t width = camera.lens.width_px;
  parallelFor(
      camera.lens.height_px, camera.threads,
      [&](uint64_t row, unsigned) {
        for (uint32_t column = 0; column < width; ++column)
          visit(row * width + column, projector.through(column, static_cast<uint32_t>(row)));
      },
      [](uint64_t) { return true; });
}

uint32_t nodeAt(const proto::GridTopology& grid, const RayHit& hit) {
  const auto x = static_cast<uint32_t>(hit.corner.x), y = static_cast<uint32_t>(hit.corner.y);
  const proto::NodeId n = proto::NodeId::at(x, y);
  const bool is_vertex = x == hit.corner.x && y == hit.corner.y;
  return hit.object == RayHit::kTerrain && is_vertex && !grid.isBase(n) ? static_cast<uint32_t>(grid.slot(n))
                                                                        : kNothing;
}

// As Picture::object.
uint32_t numberOf(int32_t object) { return static_cast<uint32_t>(object + 1); }

Picture blankPicture(const proto::Lens& lens) {
  const size_t pixels = size_t{lens.width_px} * lens.height_px;
  return {.width = lens.width_px,
          .height = lens.height_px,
          .depth_m = std::vector<float>(pixels, std::numeric_limits<float>::infinity()),
          .normal = std::vector<glm::vec3>(pixels, glm::vec3(0)),
          .node = std::vector<uint32_t>(pixels, kNothing),
          .object = std::vector<uint32_t>(pixels, kNothing),
          .colour = std::vector<glm::vec3>(pixels),
          .error_px = {}};
}

}  // namespace

Picture takePicture(const RayCaster& surface, const proto::GridTopology& grid, const Shading& shading,
                    const Camera& camera) {
  const Projector projector(camera);
  Picture picture = blankPicture(camera.lens);
  forEachPixel(camera, projector, [&](size_t pixel, const Ray& ray) {
    const std::optional<RayHit> hit = surface.hit(ray);
    picture.colour[pixel] = hit ? shading.surface(ray, *hit) : shading.sky(ray);
    if (!hit) return;
    picture.depth_m[pixel] = static_cast<float>(projector.depth(hit->position));
    picture.normal[pixel] = glm::vec3(hit->normal);
    picture.node[pixel] = nodeAt(grid, *hit);
    picture.object[pixel] = numberOf(hit->object);
  });
  return picture;
}

PixelErrors measureErrors(const RayCaster& truth, const ParameterLookup& drawn, const Camera& camera) {
  const Projector projector(camera);
  const size_t pixels = size_t{camera.lens.width_px} * camera.lens.height_px;
  PixelErrors errors{std::vector<float>(pixels, std::numeric_limits<float>::quiet_NaN()),
                     std::vector<uint32_t>(pixels, kNothing)};
  forEachPixel(camera, projector, [&](size_t pixel, const Ray& ray) {
    const std::optional<RayHit> hit = truth.hit(ray);
    if (!hit) return;
    errors.object[pixel] = numberOf(hit->object);
    if (hit->object != RayHit::kTerrain && hit->parameter == glm::dvec2(0)) return;
    const std::optional<glm::dvec3> counterpart = drawn.at(*hit);
    errors.px[pixel] = counterpart && projector.depth(*counterpart) > 0
                           ? static_cast<float>(projector.screenDistance(hit->position, *counterpart))
                           : std::numeric_limits<float>::infinity();
  });
  return errors;
}

ErrorSummary summarise(const PixelErrors& errors, double tau_px) {
  ErrorSummary summary;
  for (size_t i = 0; i < errors.px.size(); ++i) {
    if (std::isnan(errors.px[i])) continue;
    const bool is_terrain = errors.object[i] == numberOf(RayHit::kTerrain);
    double& max_px = is_terrain ? summary.terrain_max_px : summary.objects_max_px;
    max_px = std::max<double>(max_px, errors.px[i]);
    summary.terrain_pixels += is_terrain;
    summary.terrain_over_tau += is_terrain && errors.px[i] > tau_px + kRounding_px;
  }
  return summary;
}

}  // namespace foreland::terrain
