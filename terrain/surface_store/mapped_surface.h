// A surface's file mapped into memory. Immutable after open; any thread. Opening checks magic, version, sizes, the base
// mesh and the header's checksum; block checksums are checked by verifySurface, so opening costs the same for any
// depth.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/topology/mesh_topology.h"
#include "terrain/store/file/mapped_file.h"
#include "terrain/store/scene.h"
#include "terrain/store/verify.h"
#include "terrain/surface/surface.h"
#include "terrain/surface_store/surface_format.h"

namespace foreland::terrain {

class MappedSurface {
 public:
  static Result<std::shared_ptr<const MappedSurface>> open(const std::filesystem::path& path);
  // The same for the bytes of a file in memory, kept alive by `owner` and aligned to a page. Errors call the file
  // `name`.
  static Result<std::shared_ptr<const MappedSurface>> of(ByteSpan bytes, const std::string& name,
                                                         std::shared_ptr<const void> owner);

  const proto::MeshTopology& topology() const { return topology_; }
  const SurfaceHeader& header() const { return header_; }
  ByteSpan file() const { return bytes_; }
  uint64_t id() const { return header_.scene_id; }  // identifies the content
  const SceneOrigin& about() const { return about_; }

  double quantumMetres() const { return header_.quantum_m; }
  // Where the model's file has this surface's (0, 0, 0), in its units; for models in the coordinates of a map.
  glm::dvec3 origin() const { return {header_.origin[0], header_.origin[1], header_.origin[2]}; }
  // Solids inside of whatever is drawn of the surface; none if it is not closed, or moves, or holds none.
  const InnerSolids& innerSolids() const { return inner_solids_; }
  // A bound of how far a point of the surface may be drawn from where it truly is, in metres of the object's frame
  // (terrain/surface/inner_solids.h).
  double largestError() const { return terrain::largestError(topology_, nodes()); }
  bool isClosed() const { return topology_.base().isClosed(); }
  proto::ErrorShape errorShape() const { return static_cast<proto::ErrorShape>(header_.error_shape); }
  // Positions in quanta, by base vertex (under bisection, centres of faces after them), and nodes by slot with zeros as
  // padding.
  std::span<const glm::ivec3> basePositions() const {
    return section<glm::ivec3>(kSurfaceVertices).first(storedVertices(header_));
  }
  std::span<const proto::SurfaceRecord> nodes() const {
    return section<proto::SurfaceRecord>(kSurfaceNodes).first(header_.slot_count);
  }
  // Of the poses, ascending; none if there is one.
  const std::vector<Time>& poseTimes() const { return pose_times_; }
  size_t movesEach() const { return terrain::movesEach(header_); }
  // In each pose but the first: of a vertex one after another.
  std::span<const glm::ivec3> baseMoves() const {
    return movesAfter<glm::ivec3>(kSurfaceVertices, storedVertices(header_));
  }
  std::span<const glm::ivec3> nodeMoves() const {
    return movesAfter<proto::SurfaceRecord>(kSurfaceNodes, header_.slot_count);
  }
  const glm::ivec3& quanta(proto::NodeId v) const {
    return topology_.isBase(v) ? basePositions()[proto::baseVertexOf(v)] : nodes()[topology_.slot(v)].position;
  }

  proto::AtlasLayout atlas() const { return {header_.base_faces, header_.atlas_side, header_.atlas_columns}; }
  std::span<const Texel> texels() const { return section<Texel>(kSurfaceTexels); }

 private:
  MappedSurface(ByteSpan bytes, std::shared_ptr<const void> owner, const SurfaceHeader& header,
                proto::MeshTopology topology)
      : bytes_(bytes), owner_(std::move(owner)), header_(header), topology_(std::move(topology)) {}
  template <class T>
  std::span<const T> section(SurfaceSection kind) const {
    return sectionOf<T>(bytes_, header_.sections[kind]);
  }

  // The moves that follow `count` things in a section.
  template <class T>
  std::span<const glm::ivec3> movesAfter(SurfaceSection kind, uint64_t count) const {
    const uint8_t* begin = bytes_.data() + header_.sections[kind].offset + sizeof(T) * count;
    return {reinterpret_cast<const glm::ivec3*>(begin), count * movesEach()};
  }
  Status readPoseTimes();

  ByteSpan bytes_;
  std::shared_ptr<const void> owner_;  // of the bytes
  SurfaceHeader header_;
  proto::MeshTopology topology_;
  SceneOrigin about_;
  std::vector<Time> pose_times_;
  InnerSolids inner_solids_;
};

// A copy of all positions, in all poses.
[[nodiscard]] TrueSurface positionsOf(const MappedSurface& surface);

// Whether the file begins like a surface file. False if it cannot be read.
[[nodiscard]] bool isSurfaceFile(const std::filesystem::path& path);

// Checks every block's checksum and the invariants of the nodes and of the image, reading the whole file once. Error if
// the file could not be opened as a surface. Uses threads of its own while it runs.
[[nodiscard]] Result<VerifyReport> verifySurface(const std::filesystem::path& path, unsigned threads = 0);
// The same for a surface that is open already.
[[nodiscard]] VerifyReport verifySurface(const MappedSurface& surface, unsigned threads = 0);

}  // namespace foreland::terrain
