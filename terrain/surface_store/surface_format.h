// The bytes of a surface's file, as docs/SCENE_FORMAT.md has them; change both, and kSurfaceVersion, together. Pure;
// any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "base/result.h"
#include "proto/section/surface_bounds.h"
#include "proto/topology/atlas_layout.h"
#include "proto/topology/mesh_topology.h"
#include "terrain/store/file/sections.h"
#include "terrain/surface/inner_solids.h"

namespace foreland::terrain {

inline constexpr std::array<char, 8> kSurfaceMagic{'F', 'O', 'R', 'E', 'S', 'U', 'R', 'F'};
inline constexpr uint32_t kSurfaceVersion = 5;

inline constexpr double kMaxSurfaceOrigin = 1e9;  // on each axis

using Texel = uint32_t;  // red, green, blue, alpha, from the lowest byte; sRGB

enum SurfaceSection : uint32_t {
  kSurfaceText,
  kSurfaceFaces,
  kSurfaceVertices,
  kSurfaceNodes,
  kSurfaceTexels,
  kSurfaceChecksums,
  kSurfaceSectionCount
};

// A solid inside the surface (terrain/surface/inner_solids.h): normals and offsets of its planes, then zeros.
struct StoredSolid {
  double planes[ConvexSolid::kMaxPlanes][4];
};

struct SurfaceHeader {
  // The version that is written is the oldest that holds the surface.
  static constexpr uint32_t kOldestVersion = 2;  // no poses, no origin
  static constexpr uint32_t kPosesVersion = 3;   // poses, no origin
  static constexpr uint32_t kOriginVersion = 4;  // an origin; up to here no inner solids

  std::array<char, 8> magic = kSurfaceMagic;
  uint32_t version = kSurfaceVersion;
  uint32_t byte_order = kByteOrderMark;
  uint64_t file_bytes = 0;
  uint64_t scene_id = 0;
  uint64_t header_checksum = 0;
  uint32_t rule = 0, halvings = 0, base_vertices = 0, base_faces = 0;
  uint32_t atlas_side = 0, atlas_columns = 0;
  uint32_t error_shape = 0;
  uint32_t poses = 0;  // of vertices and nodes; 0: one, without a date
  double quantum_m = 0;
  int32_t low[3]{}, high[3]{};  // of all positions, in the first pose
  uint64_t slot_count = 0;
  SectionRange sections[kSurfaceSectionCount];
  double origin[3]{};  // where the model's file has this surface's (0, 0, 0), its z axis upright; in its units
  uint32_t solids = 0, reserved = 0;
  double solids_share = 0;  // of the surface's volume, that the solids hold
  StoredSolid stored_solids[InnerSolids::kMaxSolids]{};
};
static_assert(sizeof(SurfaceHeader) == 1272 && std::is_trivially_copyable_v<SurfaceHeader>);
static_assert(offsetof(SurfaceHeader, quantum_m) == 72 && offsetof(SurfaceHeader, sections) == 112 &&
              offsetof(SurfaceHeader, origin) == 208 && offsetof(SurfaceHeader, stored_solids) == 248);

// Base vertices with a position: those of the base mesh and, by bisection, the faces' centres.
uint64_t storedVertices(const SurfaceHeader& header);
// Moves of each vertex (proto/section/poses.h).
inline uint64_t movesEach(const SurfaceHeader& header) { return header.poses == 0 ? 0 : header.poses - 1; }

// The inner solids of a header, and back. An Error for what are no bounded solids within the surface's box.
void putSolids(const InnerSolids& inner, SurfaceHeader& header);
Result<InnerSolids> solidsOf(const SurfaceHeader& header);

// Writes the sections' positions and the size of the file into the header, from its other numbers and the size of the
// text.
uint64_t placeSurface(SurfaceHeader& header, uint64_t text_bytes);

}  // namespace foreland::terrain
