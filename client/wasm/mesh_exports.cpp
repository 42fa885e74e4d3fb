// The module's exports about meshes: what is drawn in a frame, and what has changed in its arrays.
#include "client/wasm/conversions.h"
#include "client/wasm/host.h"
#include "client/wasm/record_layout.h"

namespace foreland::client {
namespace {

void fillMesh(const KeyframeMesh& mesh, FrameRecord& out) {
  out.origin[0] = mesh.origin.x;
  out.origin[1] = mesh.origin.y;
  out.origin[2] = mesh.origin.z;
  out.from_time_ms = millisecondsOf(mesh.from.time);
  out.to_time_ms = millisecondsOf(mesh.to.time);
  out.scene_time_ms =
      millisecondsOf(mesh.from.scene_time) + out.weight * (mesh.to.scene_time - mesh.from.scene_time).toMilliseconds();
  out.to_pose = recordOf(mesh.to.pose);
  out.vertex_count = static_cast<uint32_t>(mesh.to_positions.size());
  out.index_count = static_cast<uint32_t>(mesh.indices.size());
  out.from_positions = addressOf(mesh.from_positions.data());
  out.to_positions = addressOf(mesh.to_positions.data());
  out.from_normals = addressOf(mesh.from_normals.data());
  out.to_normals = addressOf(mesh.to_normals.data());
  out.indices = addressOf(mesh.indices.data());
  out.lattice_positions = addressOf(mesh.parameters.data());
  out.from_moved = mesh.from_moved.empty() ? 0 : addressOf(mesh.from_moved.data());
  out.to_moved = mesh.to_moved.empty() ? 0 : addressOf(mesh.to_moved.data());
  out.from_bends = mesh.from_bends.empty() ? 0 : addressOf(mesh.from_bends.data());
  out.to_bends = mesh.to_bends.empty() ? 0 : addressOf(mesh.to_bends.data());
  out.to_region_radius_m = mesh.to.region_radius_m;
  out.to_region_angle_rad = mesh.to.region_angle_rad;
  out.to_nodes = mesh.to_nodes;
  out.object_vertex_count = static_cast<uint32_t>(mesh.objects.to_positions.size());
  out.object_index_count = static_cast<uint32_t>(mesh.objects.indices.size());
  out.object_from_positions = addressOf(mesh.objects.from_positions.data());
  out.object_to_positions = addressOf(mesh.objects.to_positions.data());
  out.object_from_normals = addressOf(mesh.objects.from_normals.data());
  out.object_to_normals = addressOf(mesh.objects.to_normals.data());
  out.object_texture_coordinates = addressOf(mesh.objects.parameters.data());
  out.object_indices = addressOf(mesh.objects.indices.data());
  out.object_parts = addressOf(mesh.object_parts.data());
  out.object_part_count = static_cast<uint32_t>(mesh.object_parts.size());
}

}  // namespace

FORELAND_EXPORT(foreland_frame)
const FrameRecord* frame(Host* host, double now_ms, double x, double y, double z, double qx, double qy, double qz,
                         double qw) {
  const proto::Pose pose{.eye = {x, y, z}, .orientation = glm::dquat(qw, qx, qy, qz)};
  const FrameView view = host->viewer.frame(timeOf(now_ms), pose);
  FrameRecord& out = host->frame_record;
  out = {};
  out.pose = recordOf(view.pose);
  out.shown_time_ms = millisecondsOf(view.shown_time);
  out.weight = view.weight;
  if (view.mesh == nullptr) return &out;
  out.mesh_version = view.mesh_version;
  out.tau_px = view.tolerance_px;
  fillMesh(*view.mesh, out);
  return &out;
}

// From now on meshes are taken by foreland_take_newest, as soon as they are made, instead of when they are shown.
FORELAND_EXPORT(foreland_draw_ahead) void drawAhead(Host* host) { host->viewer.drawAhead(); }

// The newest mesh, whose interval foreland_interval gives; null if it has been taken already. For viewers that draw
// ahead.
FORELAND_EXPORT(foreland_take_newest) const FrameRecord* takeNewest(Host* host) {
  const Interval* newest = host->newest.take();
  if (newest == nullptr) return nullptr;
  FrameRecord& out = host->frame_record;
  out = {};
  out.mesh_version = newest->version;
  out.oldest_version = host->viewer.timeline().oldestVersion();
  fillMesh(host->viewer.drawn().mesh(), out);
  return &out;
}

// The newest mesh's Interval, for foreland_screen_add of another instance of this module.
FORELAND_EXPORT(foreland_interval) const TextRecord* interval(Host* host) {
  host->text_record = {addressOf(host->viewer.timeline().newest()), sizeof(Interval)};
  return &host->text_record;
}

// What has changed in the terrain's arrays (`part` 0) or the objects' (1) of the last mesh since the last call for it.
// Null if there was no mesh.
FORELAND_EXPORT(foreland_take_changes) const ChangesRecord* takeChanges(Host* host, uint32_t part) {
  if (host->frame_record.mesh_version == 0 || part > 1) return nullptr;
  PatchedMesh& mesh = part == 0 ? host->viewer.drawn().terrain() : host->viewer.drawn().objects();
  ChangedRanges& changes = host->changes[part];
  mesh.collectChanges(kUploadGap, changes);
  ChangesRecord& out = host->changes_records[part];
  out = {};
  out.base_version = mesh.isAllChanged() ? 0 : host->taken_versions[part];
  mesh.clearChanges();
  host->taken_versions[part] = host->frame_record.mesh_version;
  const auto tell = [](const std::vector<Range>& ranges, Address& address, uint32_t& count) {
    address = addressOf(ranges.data());
    count = static_cast<uint32_t>(ranges.size());
  };
  tell(changes.from_positions, out.from_positions, out.from_position_ranges);
  tell(changes.to_positions, out.to_positions, out.to_position_ranges);
  tell(changes.from_normals, out.from_normals, out.from_normal_ranges);
  tell(changes.to_normals, out.to_normals, out.to_normal_ranges);
  tell(changes.bends, out.bends, out.bend_ranges);
  tell(changes.parameters, out.texture_coordinates, out.texture_coordinate_ranges);
  tell(changes.triangles, out.triangles, out.triangle_ranges);
  return &out;
}

}  // namespace foreland::client
