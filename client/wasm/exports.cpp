// The client core as a WebAssembly module: a Viewer, a planned tour, and records for the page to read. It only
// converts; client/ and the page make the decisions. Times are milliseconds of the page's clock; texts are UTF-8. One
// thread. A viewer's address is its handle; records and arrays stay valid until the next call into the module.
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>

#include "client/ground_supply.h"
#include "client/imagery/drape.h"
#include "client/viewer.h"
#include "client/wasm/conversions.h"
#include "client/wasm/record_layout.h"
#include "client/wasm/records.h"
#include "client/wasm/scene_record.h"

namespace foreland::client {
namespace {

struct Host {
  explicit Host(const proto::ViewRequest& request) : viewer(request) {}

  Viewer viewer;
  Bytes outgoing;
  std::string error;
  proto::Path tour;
  SceneRecord welcome;
  uint32_t taken_mesh = 0;  // the last version that takeNewest() gave
  Drape::Sizes texture_layers;
  std::optional<Drape> drape;
  uint32_t draped_scene = 0;      // TileStore::scene() that it is for
  std::optional<glm::dvec3> sun;  // that casts shadows
  std::vector<uint32_t> arrivals, dropped;

  FrameRecord frame_record{};
  // Of the terrain and the objects.
  std::array<ChangesRecord, 2> changes_records{};
  std::array<uint32_t, 2> taken_versions{};
  std::array<ChangedRanges, 2> changes;
  GroundSupply ground;
  StatisticsRecord statistics_record{};
  TextRecord text_record{};
  TilesRecord tiles_record{};
  ImageRecord image_record{};
};

proto::ViewRequest requestOf(double fov_rad, uint32_t width_px, uint32_t height_px, double tau_px, uint32_t strategy,
                             uint32_t predictor, double keyframe_ms, double longest_keyframe_ms, uint32_t occlusion,
                             uint32_t memory_bytes, uint32_t relief, uint32_t imagery, uint32_t tile_bytes) {
  return {.lens = {.vertical_fov_rad = fov_rad, .width_px = width_px, .height_px = height_px},
          .tau_px = tau_px,
          .strategy = static_cast<proto::Strategy>(strategy),
          .predictor = static_cast<proto::Predictor>(predictor),
          .keyframe_interval = {timeOf(keyframe_ms).us},
          .longest_interval = {timeOf(longest_keyframe_ms).us},
          .occlusion = occlusion != 0,
          .memory_bytes = memory_bytes,
          .relief = relief != 0,
          .imagery = imagery != 0,
          .tile_bytes = tile_bytes};
}

std::array<uint32_t, 2> halvesOf(uint64_t key) {
  return {static_cast<uint32_t>(key), static_cast<uint32_t>(key >> 32)};
}
proto::TileId tileOf(uint32_t low, uint32_t high) { return proto::TileId::of(uint64_t{high} << 32 | low); }

double texelOf(const Host& host, proto::TileContent content) {
  return host.drape ? host.drape->texelPx(content) : std::numeric_limits<double>::infinity();
}

void fillTiles(proto::TileContent content, const Residency& residency, Host& host) {
  TilesRecord& out = host.tiles_record;
  host.arrivals.clear(), host.dropped.clear();
  for (const Residency::Arrival& a : residency.arrivals()) {
    const auto [low, high] = halvesOf(a.tile.key());
    host.arrivals.insert(host.arrivals.end(), {low, high, a.texture_layer, a.parent_layer.value_or(kNoLayer), 0});
  }
  if (content == proto::TileContent::kRelief)
    for (const Residency::Shown& r : host.drape->relit()) {
      const auto [low, high] = halvesOf(r.tile.key());
      host.arrivals.insert(host.arrivals.end(), {low, high, r.texture_layer, kNoLayer, 1});
    }
  for (const proto::TileId& tile : residency.dropped()) {
    const auto [low, high] = halvesOf(tile.key());
    host.dropped.insert(host.dropped.end(), {low, high});
  }
  out.scene = host.draped_scene;
  out.shown = static_cast<uint32_t>(residency.shown().size());
  out.page_table = addressOf(residency.pageTable().data());
  out.page_count = static_cast<uint32_t>(residency.pageTable().size() / 4);
  out.arrivals = addressOf(host.arrivals.data());
  out.arrival_count = static_cast<uint32_t>(host.arrivals.size() / 5);
  out.dropped = addressOf(host.dropped.data());
  out.dropped_count = static_cast<uint32_t>(residency.dropped().size());
}

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
  out.from_nodes = mesh.from_nodes;
  out.to_nodes = mesh.to_nodes;
  out.from_index = mesh.from.index;
  out.to_index = mesh.to.index;
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

Bytes& incoming() {
  static Bytes buffer;
  return buffer;
}

// The layout of the records, for the page's build (recordLayoutText) and for the page to check it.
FORELAND_EXPORT(foreland_record_layout) const TextRecord* recordLayout() {
  static const std::string text = recordLayoutText();
  static TextRecord record;
  record = {addressOf(text.data()), static_cast<uint32_t>(text.size())};
  return &record;
}

// A buffer of `size` bytes, for the page to write what the next call reads.
FORELAND_EXPORT(foreland_buffer) uint8_t* buffer(uint32_t size) {
  incoming().resize(size);
  return incoming().data();
}

FORELAND_EXPORT(foreland_create)
Host* create(double fov_rad, uint32_t width_px, uint32_t height_px, double tau_px, uint32_t strategy,
             uint32_t predictor, double keyframe_ms, double longest_keyframe_ms, uint32_t occlusion,
             uint32_t memory_bytes, uint32_t relief, uint32_t imagery, uint32_t tile_bytes) {
  return new Host(requestOf(fov_rad, width_px, height_px, tau_px, strategy, predictor, keyframe_ms, longest_keyframe_ms,
                            occlusion, memory_bytes, relief, imagery, tile_bytes));
}

// Continues over a new connection after the old one was lost (Viewer::reconnect).
FORELAND_EXPORT(foreland_reconnect) void reconnect(Host* host, double now_ms) {
  host->viewer.reconnect(timeOf(now_ms));
  host->ground.reconnect();
}

FORELAND_EXPORT(foreland_destroy) void destroy(Host* host) { delete host; }

// Handles the server's message in the buffer. 1 on success; 0 if it was refused, and foreland_error says why.
FORELAND_EXPORT(foreland_receive) uint32_t receive(Host* host, double now_ms) {
  const Status status = host->viewer.receive(incoming(), timeOf(now_ms));
  if (!status.ok()) host->error = status.error().message;
  return status.ok() ? 1 : 0;
}

// The next message for the server; null when there is none.
FORELAND_EXPORT(foreland_take_outgoing) const TextRecord* takeOutgoing(Host* host) {
  if (!host->viewer.takeOutgoing(host->outgoing)) return nullptr;
  host->text_record = {addressOf(host->outgoing.data()), static_cast<uint32_t>(host->outgoing.size())};
  return &host->text_record;
}

FORELAND_EXPORT(foreland_error) const TextRecord* error(Host* host) {
  host->text_record = {addressOf(host->error.data()), static_cast<uint32_t>(host->error.size())};
  return &host->text_record;
}

// The camera of the next frame is jumped to (Viewer::jump).
FORELAND_EXPORT(foreland_jump) void jump(Host* host) { host->viewer.jump(); }

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
  const Interval* newest = host->viewer.timeline().newest();
  if (newest == nullptr || newest->version == host->taken_mesh) return nullptr;
  host->taken_mesh = newest->version;
  FrameRecord& out = host->frame_record;
  out = {};
  out.mesh_version = newest->version;
  out.oldest_version = host->viewer.timeline().oldestVersion();
  fillMesh(host->viewer.drawn().mesh(), out);
  if (host->draped_scene != host->viewer.tiles().scene()) {
    host->draped_scene = host->viewer.tiles().scene();
    host->drape.emplace(host->viewer.tiles(), host->texture_layers);
    const proto::Welcome& welcome = *host->viewer.welcome();
    const double quantum_m = welcome.frame.height_quantum_m;
    host->drape->setHeights(host->viewer.frameGrid().transform(), welcome.lowest * quantum_m,
                            welcome.highest * quantum_m);
    host->drape->setSun(host->sun);
  }
  host->drape->advance(host->viewer.frameGrid().transform(), newest->from, newest->to);
  return &out;
}

// How many layers the texture arrays of relief and imagery have. To be called before the first mesh is taken.
FORELAND_EXPORT(foreland_set_texture_layers)
void setTextureLayers(Host* host, uint32_t relief, uint32_t imagery) { host->texture_layers = {relief, imagery}; }

// What the host had taken is lost (its graphics card was reset): the newest mesh is taken again, and all tiles come
// again with it and those that follow.
FORELAND_EXPORT(foreland_redraw) void redraw(Host* host) {
  host->taken_mesh = 0;
  host->draped_scene = 0;
}

// What of the tiles of a proto::TileContent is drawn with the mesh that was taken last. Null if the scene has none.
FORELAND_EXPORT(foreland_tiles) const TilesRecord* tiles(Host* host, uint32_t content) {
  const Residency* residency = nullptr;
  if (host->drape && content < proto::kMaxTileLayers)
    residency = host->drape->residency(static_cast<proto::TileContent>(content));
  if (residency == nullptr) return nullptr;
  fillTiles(static_cast<proto::TileContent>(content), *residency, *host);
  return &host->tiles_record;
}

// Slopes of a tile of relief that arrives (`half` 0), and of its half-size image (`half` 1).
FORELAND_EXPORT(foreland_slopes) const uint32_t* slopes(Host* host, uint32_t low, uint32_t high, uint32_t half) {
  const proto::TileId tile = tileOf(low, high);
  return half == 0 ? host->drape->slopes(tile).data() : host->drape->halfSlopes(tile).data();
}

// Its ground texels likewise (client/imagery/shadows.h), also of tiles that are relit.
FORELAND_EXPORT(foreland_ground_texels)
const uint32_t* groundTexels(Host* host, uint32_t low, uint32_t high, uint32_t half) {
  const proto::TileId tile = tileOf(low, high);
  return half == 0 ? host->drape->ground(tile).data() : host->drape->halfGround(tile).data();
}

// Towards the sun, in the scene's axes, if it casts shadows (`wanted` 1).
FORELAND_EXPORT(foreland_set_sun) void setSun(Host* host, double x, double y, double z, uint32_t wanted) {
  host->sun = wanted == 1 ? std::optional(glm::normalize(glm::dvec3{x, y, z})) : std::nullopt;
  if (host->drape) host->drape->setSun(host->sun);
}

// Decodes a tile of relief, if one is wanted: 1 if so.
FORELAND_EXPORT(foreland_decode_relief) uint32_t decodeRelief(Host* host) {
  return host->drape && host->drape->decodeRelief() ? 1 : 0;
}

// The next image to be decoded, each once; null if there is none.
FORELAND_EXPORT(foreland_next_image) const ImageRecord* nextImage(Host* host) {
  if (!host->drape) return nullptr;
  const auto tile = host->drape->takeWantedImage();
  const HeldTile* held = tile ? host->viewer.tiles().find(*tile) : nullptr;
  if (held == nullptr) return nullptr;
  const auto [low, high] = halvesOf(tile->key());
  host->image_record = {{low, high}, addressOf(held->coded.data()), static_cast<uint32_t>(held->coded.size())};
  return &host->image_record;
}

// The image of a tile has been decoded.
FORELAND_EXPORT(foreland_image_ready) void imageReady(Host* host, uint32_t low, uint32_t high) {
  if (host->drape) host->drape->setImageReady(tileOf(low, high));
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

FORELAND_EXPORT(foreland_set_request)
void setRequest(Host* host, double fov_rad, uint32_t width_px, uint32_t height_px, double tau_px, uint32_t strategy,
                uint32_t predictor, double keyframe_ms, double longest_keyframe_ms, uint32_t occlusion,
                uint32_t memory_bytes, uint32_t relief, uint32_t imagery, uint32_t tile_bytes) {
  host->viewer.setRequest(requestOf(fov_rad, width_px, height_px, tau_px, strategy, predictor, keyframe_ms,
                                    longest_keyframe_ms, occlusion, memory_bytes, relief, imagery, tile_bytes));
}

// From `at_ms` on scene time goes from `scene_ms`, since 1970, at `rate` scene seconds a second.
FORELAND_EXPORT(foreland_set_scene_clock)
void setSceneClock(Host* host, double at_ms, double scene_ms, double rate) {
  host->viewer.setSceneClock({timeOf(at_ms), timeOf(scene_ms), rate});
}

// `blend` is a client::Blend. 1 on success; 0 if there is no such blend.
FORELAND_EXPORT(foreland_set_blend) uint32_t setBlend(Host* host, uint32_t blend) {
  if (blend >= std::size(kBlends)) return 0;
  host->viewer.setBlend(static_cast<Blend>(blend));
  return 1;
}

// Requests the tour whose name is in the buffer.
FORELAND_EXPORT(foreland_request_tour) void requestTour(Host* host, double seconds) {
  host->viewer.requestTour(std::string(incoming().begin(), incoming().end()), seconds);
}

// The number of poses of the tour that has arrived since the last call; 0 if none has.
FORELAND_EXPORT(foreland_take_tour) uint32_t takeTour(Host* host) {
  std::optional<proto::TourReply> reply = host->viewer.takeTour();
  if (!reply) return 0;
  host->tour = {.start = {}, .step = reply->step, .poses = std::move(reply->poses)};
  return static_cast<uint32_t>(host->tour.poses.size());
}

// Begins the tour at a time and announces it to the server.
FORELAND_EXPORT(foreland_start_tour) void startTour(Host* host, double start_ms) {
  host->tour.start = timeOf(start_ms);
  if (host->tour.validate().ok()) host->viewer.announcePath(host->tour);
}

// The server's welcome; null before it has arrived on this connection.
FORELAND_EXPORT(foreland_welcome) const WelcomeRecord* welcome(Host* host) {
  if (!host->viewer.isGreeted()) return nullptr;
  return host->welcome.fill(*host->viewer.welcome(), host->viewer.frameGrid().transform());
}

// What is news about the ground `reach` samples about an eye, for foreland_screen_ground of another instance of this
// module. Null before the welcome.
FORELAND_EXPORT(foreland_ground)
const TextRecord* ground(Host* host, double x, double y, double z, double reach) {
  if (!host->viewer.isGreeted()) return nullptr;
  const Bytes& update = host->ground.update(host->viewer, {x, y, z}, reach);
  host->text_record = {addressOf(update.data()), static_cast<uint32_t>(update.size())};
  return &host->text_record;
}

FORELAND_EXPORT(foreland_statistics) const StatisticsRecord* statistics(Host* host) {
  const ViewerStatistics& from = host->viewer.statistics();
  const TileStore& tiles = host->viewer.tiles();
  host->statistics_record = {.bytes_down = static_cast<double>(from.bytes_down),
                             .bytes_up = static_cast<double>(from.bytes_up),
                             .last_lateness_ms = from.last_lateness.toMilliseconds(),
                             .worst_lateness_ms = from.worst_lateness.toMilliseconds(),
                             .nodes_added = static_cast<double>(from.nodes_added),
                             .nodes_removed = static_cast<double>(from.nodes_removed),
                             .tile_bytes = static_cast<double>(tiles.bytes()),
                             .tiles_received = static_cast<double>(tiles.received()),
                             .relief_texel_px = texelOf(*host, proto::TileContent::kRelief),
                             .imagery_texel_px = texelOf(*host, proto::TileContent::kImagery),
                             .keyframes = from.keyframes,
                             .late_keyframes = from.late_keyframes,
                             .tiles = static_cast<uint32_t>(tiles.count()),
                             .damaged_tiles = host->drape ? host->drape->damaged() : 0};
  return &host->statistics_record;
}

}  // namespace foreland::client
