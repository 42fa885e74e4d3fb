// A ray caster of a mesh as it is drawn: Embree's floats are the mesh's own.
#include <algorithm>

#include "terrain/render/triangle_source.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kTerrainGeometry = 0;

class DrawnTriangles final : public TriangleSource {
 public:
  explicit DrawnTriangles(DrawnSurface surface) : surface_(std::move(surface)) {}

  std::array<TriangleCorner, 3> corners(const EmbreeHit& hit) const override {
    const DrawnSurface::Triangles& part = hit.geometry == kTerrainGeometry ? surface_.terrain : surface_.objects;
    std::array<TriangleCorner, 3> corners;
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t v = part.indices[3 * size_t{hit.primitive} + i];
      corners[i] = {surface_.origin + glm::dvec3(part.positions[v]), glm::dvec2(part.parameters[v]),
                    part.heights_m.empty() ? 0.0 : part.heights_m[v]};
    }
    return corners;
  }

  int32_t object(const EmbreeHit& hit) const override {
    if (hit.geometry == kTerrainGeometry) return RayHit::kTerrain;
    const auto& begin = surface_.object_begin;
    return static_cast<int32_t>(std::upper_bound(begin.begin(), begin.end(), hit.primitive) - begin.begin()) - 1;
  }

 private:
  DrawnSurface surface_;
};

}  // namespace

Result<RayCaster> RayCaster::ofSurface(DrawnSurface surface) {
  auto impl = std::make_unique<Impl>();
  impl->origin = surface.origin;
  impl->embree.addTriangles(surface.terrain.positions, surface.terrain.indices);
  impl->embree.addTriangles(surface.objects.positions, surface.objects.indices);
  if (Status s = impl->embree.commit(); !s.ok()) return s.error();
  impl->triangles = std::make_unique<DrawnTriangles>(std::move(surface));
  return RayCaster(std::move(impl));
}

}  // namespace foreland::terrain
