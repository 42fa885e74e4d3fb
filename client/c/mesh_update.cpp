#include "client/c/mesh_update.h"

#include <cstring>

namespace foreland::client {
namespace {

// `items` elements of `values` make one of the channel.
template <class T>
ChannelUpdate channelOf(const std::vector<T>& values, const std::vector<Range>& ranges, bool is_whole,
                        uint32_t items = 1) {
  const auto count = static_cast<uint32_t>(values.size() / items);
  ChannelUpdate out{.count = count};
  if (!is_whole) out.ranges = ranges;
  if (is_whole && count > 0) out.ranges = {{0, count}};
  size_t bytes = 0, at = 0;
  for (const Range& r : out.ranges) bytes += (r.end - r.begin) * sizeof(T) * items;
  out.data.resize(bytes);
  for (const Range& r : out.ranges) {
    const size_t size = (r.end - r.begin) * sizeof(T) * items;
    std::memcpy(out.data.data() + at, values.data() + size_t{r.begin} * items, size);
    at += size;
  }
  return out;
}

PartUpdate partOf(const BlendMesh& mesh, PatchedMesh& patched, bool is_whole) {
  ChangedRanges changed;
  PartUpdate out{.is_whole = is_whole || patched.isAllChanged(),
                 .triangles = static_cast<uint32_t>(mesh.triangleCount())};
  patched.collectChanges(kUploadGap, changed);
  patched.clearChanges();
  const auto channel = [&](const auto& values, const std::vector<Range>& ranges, uint32_t items = 1) {
    return channelOf(values, ranges, out.is_whole, items);
  };
  out.from_positions = channel(mesh.from_positions, changed.from_positions);
  out.to_positions = channel(mesh.to_positions, changed.to_positions);
  out.from_normals = channel(mesh.from_normals, changed.from_normals);
  out.to_normals = channel(mesh.to_normals, changed.to_normals);
  if (!mesh.to_moved.empty()) {
    out.from_moved = channel(mesh.from_moved, changed.from_positions);
    out.to_moved = channel(mesh.to_moved, changed.to_positions);
  }
  if (!mesh.to_bends.empty()) {
    out.from_bends = channel(mesh.from_bends, changed.bends);
    out.to_bends = channel(mesh.to_bends, changed.bends);
  }
  out.parameters = channel(mesh.parameters, changed.parameters);
  out.indices = channel(mesh.indices, changed.triangles, 3);
  return out;
}

}  // namespace

MeshUpdate takeUpdate(DrawnMesh& drawn, const Interval& interval, uint32_t oldest_version, bool is_whole) {
  const KeyframeMesh& mesh = drawn.mesh();
  MeshUpdate out{.interval = interval,
                 .oldest_version = oldest_version,
                 .origin = mesh.origin,
                 .object_parts = mesh.object_parts,
                 .terrain = partOf(mesh, drawn.terrain(), is_whole),
                 .objects = partOf(mesh.objects, drawn.objects(), is_whole)};
  out.objects.triangles = 0;  // others than those of parts have three times the same corner
  for (const ObjectPart& part : mesh.object_parts) out.objects.triangles += part.index_count / 3;
  return out;
}

}  // namespace foreland::client
