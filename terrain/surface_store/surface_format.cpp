#include "terrain/surface_store/surface_format.h"

#include <glm/vec3.hpp>

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

}  // namespace foreland::terrain
