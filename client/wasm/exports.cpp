// The client core as a WebAssembly module: a Viewer, a planned tour, and records for the page to read. It only
// converts; client/ and the page make the decisions. Times are milliseconds of the page's clock; texts are UTF-8. One
// thread. A viewer's address is its handle; records and arrays stay valid until the next call into the module. Exports
// about meshes and tiles have files of their own.
#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include "client/wasm/conversions.h"
#include "client/wasm/host.h"
#include "client/wasm/record_layout.h"

namespace foreland::client {
namespace {

// Of the record that the page wrote for this call (make_records.mjs: writeRequestRecord).
proto::ViewRequest writtenRequest() {
  RequestRecord r{};
  std::memcpy(&r, incoming().data(), std::min(sizeof r, incoming().size()));
  return {.lens = {.vertical_fov_rad = r.fov_rad, .width_px = r.width_px, .height_px = r.height_px},
          .tau_px = r.tau_px,
          .strategy = static_cast<proto::Strategy>(r.strategy),
          .predictor = static_cast<proto::Predictor>(r.predictor),
          .keyframe_interval = {timeOf(r.keyframe_ms).us},
          .longest_interval = {timeOf(r.longest_keyframe_ms).us},
          .max_triangles = r.max_triangles,
          .max_bytes_per_second = r.max_bytes_per_second,
          .occlusion = r.occlusion != 0,
          .memory_bytes = r.memory_bytes,
          .relief = r.relief != 0,
          .imagery = r.imagery != 0,
          .tile_bytes = r.tile_bytes,
          .eye_radius_m = r.eye_radius_m};
}

double texelOf(Host& host, proto::TileContent content) {
  return host.newest.drape() ? host.newest.drape()->texelPx(content) : std::numeric_limits<double>::infinity();
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

// For the request in the buffer.
FORELAND_EXPORT(foreland_create) Host* create() { return new Host(writtenRequest()); }

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

// Asks for what the request in the buffer says from now on.
FORELAND_EXPORT(foreland_set_request) void setRequest(Host* host) { host->viewer.setRequest(writtenRequest()); }

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

// The area of a large scene that the camera is in (Viewer::area), for the address of the next connection; -1 for none.
FORELAND_EXPORT(foreland_area) int32_t area(Host* host) {
  const std::optional<uint32_t> area = host->viewer.area();
  return area ? static_cast<int32_t>(*area) : -1;
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
                             .damaged_tiles = host->newest.drape() ? host->newest.drape()->damaged() : 0};
  return &host->statistics_record;
}

}  // namespace foreland::client
