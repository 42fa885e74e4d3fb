#include "client/fly/flight_digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <bit>
#include <vector>

namespace foreland::client {

namespace {

template <class T>
uint64_t hashOf(const std::vector<T>& values, uint64_t before) {
  return XXH3_64bits_withSeed(values.data(), values.size() * sizeof(T), before);
}

uint64_t hashOf(const BlendMesh& mesh, uint64_t before) {
  before = hashOf(mesh.from_positions, hashOf(mesh.to_positions, before));
  if (!mesh.from_bends.empty()) before = hashOf(mesh.from_bends, hashOf(mesh.to_bends, before));
  before = hashOf(mesh.from_normals, hashOf(mesh.to_normals, before));
  return hashOf(mesh.indices, hashOf(mesh.parameters, before));
}

uint64_t hashOf(const Replica& replica, uint64_t before) {
  const proto::Section section = replica.section();
  std::vector<int32_t> heights;
  heights.reserve(section.slots.size());
  for (proto::Slot slot : section.slots) heights.push_back(replica.nodes().records().at(slot).height());
  return hashOf(heights, hashOf(section.slots, before));
}

uint64_t hashOf(const FrameView& view, uint64_t mesh, uint64_t before) {
  const auto bits = [](auto value) { return std::bit_cast<uint64_t>(static_cast<double>(value)); };
  const glm::dvec3& eye = view.pose.eye;
  const glm::dquat& q = view.pose.orientation;
  const std::array<uint64_t, 11> words{mesh,
                                       bits(view.weight),
                                       bits(view.tolerance_px),
                                       bits(eye.x),
                                       bits(eye.y),
                                       bits(eye.z),
                                       bits(q.x),
                                       bits(q.y),
                                       bits(q.z),
                                       bits(q.w),
                                       static_cast<uint64_t>(view.shown_time.us)};
  return XXH3_64bits_withSeed(words.data(), sizeof(words), before);
}

}  // namespace

void FlightDigest::add(const Viewer& viewer, const FrameView& view) {
  if (!view.mesh) return;
  if (value_.frames == 0 || view.mesh_version != mesh_version_)
    mesh_ = hashOf(view.mesh->objects, hashOf(*view.mesh, 0));
  mesh_version_ = view.mesh_version;
  const uint32_t newest = viewer.replica()->newest().index;
  if (newest != keyframe_) value_.sections = hashOf(*viewer.replica(), value_.sections);
  keyframe_ = newest;
  value_.drawn = hashOf(view, mesh_, value_.drawn);
  ++value_.frames;
}

}  // namespace foreland::client
