#include "terrain/surface_store/write_surface.h"

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>

#include "base/check.h"
#include "terrain/store/file/seal.h"
#include "terrain/store/format.h"

namespace foreland::terrain {

namespace {

void measure(const TrueSurface& surface, SurfaceHeader& header) {
  glm::ivec3 low = surface.base.front(), high = low;
  const auto include = [&](const glm::ivec3& p) { low = glm::min(low, p), high = glm::max(high, p); };
  for (const glm::ivec3& p : surface.base) include(p);
  forEachNode(surface.topology, [&](proto::NodeId, proto::Slot slot) { include(surface.nodes[slot]); });
  for (int axis = 0; axis < 3; ++axis) header.low[axis] = low[axis], header.high[axis] = high[axis];
}

SurfaceHeader headerOf(const SurfaceContent& content) {
  const proto::MeshTopology& topology = content.surface.topology;
  SurfaceHeader header;
  header.rule = static_cast<uint32_t>(topology.rule()), header.halvings = topology.halvings();
  header.base_vertices = topology.base().vertexCount(), header.base_faces = topology.base().faceCount();
  header.atlas_side = content.atlas.side, header.atlas_columns = content.atlas.columns;
  header.error_shape = static_cast<uint32_t>(content.error_shape);
  header.poses = static_cast<uint32_t>(content.pose_times.size());
  for (int axis = 0; axis < 3; ++axis) header.origin[axis] = content.origin[axis];
  putSolids(content.inner, header);
  header.version = header.solids > 0                 ? kSurfaceVersion
                   : content.origin != glm::dvec3(0) ? SurfaceHeader::kOriginVersion
                   : header.poses > 0                ? SurfaceHeader::kPosesVersion
                                                     : SurfaceHeader::kOldestVersion;
  header.quantum_m = content.surface.quantum_m;
  header.slot_count = topology.slotCount();
  measure(content.surface, header);
  return header;
}

// Puts the parts one after another; together they are the whole section.
template <class... Parts>
void fill(const NewFile& file, const SectionRange& place, const Parts&... parts) {
  CHECK_EQ(place.bytes, (std::span(parts).size_bytes() + ...));
  uint8_t* to = file.data() + place.offset;
  const auto put = [&](const auto part) {
    if (!part.empty()) std::memcpy(to, part.data(), part.size_bytes());
    to += part.size_bytes();
  };
  (put(std::span(parts)), ...);
}

}  // namespace

Result<uint64_t> writeSurface(const std::filesystem::path& target, const SurfaceContent& content) {
  const TrueSurface& surface = content.surface;
  const Bytes text = encodeText(content.about);
  if (text.size() > kMaxTextBytes)
    return Error{ErrorCode::kLimit, target.string() + ": more than 16 MiB of names and notes"};
  SurfaceHeader header = headerOf(content);
  header.file_bytes = placeSurface(header, text.size());
  auto file = NewFile::create(target, header.file_bytes);
  if (!file.ok()) return file.error();
  std::vector<int64_t> times;
  for (const Time& time : content.pose_times) times.push_back(time.us);
  fill(*file, header.sections[kSurfaceText], text);
  fill(*file, header.sections[kSurfaceFaces], surface.topology.base().faces());
  fill(*file, header.sections[kSurfaceVertices], surface.base, baseMoves(surface), times);
  fill(*file, header.sections[kSurfaceNodes], content.records, nodeMoves(surface));
  fill(*file, header.sections[kSurfaceTexels], content.texels);
  return sealFile(*file, header.sections[kSurfaceChecksums], header);
}

}  // namespace foreland::terrain
