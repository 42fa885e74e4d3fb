#include "terrain/surface_store/surface_format.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "base/check.h"

namespace foreland::terrain {

uint64_t storedVertices(const SurfaceHeader& header) {
  const bool has_centres = header.rule == static_cast<uint32_t>(proto::MeshRule::kBisection);
  return uint64_t{header.base_vertices} + (has_centres ? header.base_faces : 0);
}

uint64_t placeSurface(SurfaceHeader& header, uint64_t text_bytes) {
  const proto::AtlasLayout atlas{header.base_faces, header.atlas_side, header.atlas_columns};
  const std::array<uint64_t, kSurfaceChecksums> bytes{
      text_bytes, sizeof(proto::BaseFace) * uint64_t{header.base_faces},
      sizeof(glm::ivec3) * storedVertices(header) * (1 + movesEach(header)) + sizeof(int64_t) * uint64_t{header.poses},
      (sizeof(proto::SurfaceRecord) + sizeof(glm::ivec3) * movesEach(header)) * header.slot_count,
      sizeof(Texel) * uint64_t{atlas.width()} * atlas.height()};
  return layOutSections(bytes, header.sections);
}

namespace {

constexpr double kUnit = 1e-9;  // what rounding may make of a unit normal's length

Error impossible() { return {ErrorCode::kMalformed, "its inner solids are impossible"}; }

// The planes up to the first of zeros, after which there must be zeros only.
Result<std::vector<SolidPlane>> planesOf(const StoredSolid& stored) {
  std::vector<SolidPlane> planes;
  bool is_over = false;
  for (const auto& [x, y, z, offset] : stored.planes) {
    const SolidPlane plane{{x, y, z}, offset};
    is_over |= plane == SolidPlane{};
    if (is_over && plane != SolidPlane{}) return impossible();
    if (!is_over && !(std::fabs(glm::length(plane.normal) - 1) <= kUnit)) return impossible();
    if (!std::isfinite(offset)) return impossible();
    if (!is_over) planes.push_back(plane);
  }
  return planes;
}

}  // namespace

void putSolids(const InnerSolids& inner, SurfaceHeader& header) {
  CHECK_LE(inner.solids.size(), InnerSolids::kMaxSolids);
  header.solids = static_cast<uint32_t>(inner.solids.size());
  header.solids_share = header.solids == 0 ? 0 : inner.volume_share;
  for (size_t i = 0; i < inner.solids.size(); ++i)
    for (size_t k = 0; k < inner.solids[i].planes().size(); ++k) {
      const SolidPlane& plane = inner.solids[i].planes()[k];
      const double numbers[]{plane.normal.x, plane.normal.y, plane.normal.z, plane.offset};
      std::ranges::copy(numbers, header.stored_solids[i].planes[k]);
    }
}

Result<InnerSolids> solidsOf(const SurfaceHeader& header) {
  if (header.solids > InnerSolids::kMaxSolids || header.reserved != 0) return impossible();
  if (!(header.solids_share >= 0 && header.solids_share <= 1) || (header.solids == 0 && header.solids_share != 0))
    return impossible();
  double reach = 0;
  for (int axis = 0; axis < 3; ++axis)
    reach = std::max({reach, std::fabs(1.0 * header.low[axis]), std::fabs(1.0 * header.high[axis])});
  InnerSolids inner{{}, header.solids_share};
  for (size_t i = 0; i < InnerSolids::kMaxSolids; ++i) {
    const auto planes = planesOf(header.stored_solids[i]);
    if (!planes.ok()) return planes.error();
    if (planes->empty() != (i >= header.solids)) return impossible();
    if (planes->empty()) continue;
    inner.solids.push_back(makeSolid(*planes, reach * header.quantum_m));
    if (inner.solids.back().plane_count != planes->size()) return impossible();
  }
  return inner;
}

}  // namespace foreland::terrain
