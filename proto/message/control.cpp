#include "proto/message/control.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/printable.h"
#include "message_generated.h"
#include "proto/message/kind.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

namespace {

constexpr size_t kMaxNameBytes = 64;
constexpr size_t kMaxTextBytes = 64 << 10;
constexpr size_t kMaxNesting = 16, kMaxTables = ObjectSet::kMaxModels + 16;  // of a FlatBuffer

// ---- names

constexpr const char* kStrategyNames[] = {"delay", "current", "predict"};
constexpr const char* kPredictorNames[] = {"hold", "velocity", "acceleration", "path", "double-exponential", "kalman"};

template <class E, size_t N>
std::optional<E> named(const char* const (&names)[N], std::string_view wanted) {
  for (size_t i = 0; i < N; ++i)
    if (wanted == names[i]) return static_cast<E>(i);
  return std::nullopt;
}

// ---- FlatBuffers values

using Builder = flatbuffers::FlatBufferBuilder;

fb::Vec2 toFb(const glm::dvec2& v) { return {v.x, v.y}; }
fb::Lens toFb(const Lens& l) { return {l.vertical_fov_rad, l.width_px, l.height_px}; }
fb::Geodetic toFb(const Geodetic& g) { return {g.latitude_rad, g.longitude_rad, g.height_m}; }
fb::CameraPose toFb(const Pose& p) {
  const glm::dquat& q = p.orientation;
  return {fb::Vec3(p.eye.x, p.eye.y, p.eye.z), fb::Quat(q.w, q.x, q.y, q.z)};
}

glm::dvec2 fromFb(const fb::Vec2& v) { return {v.x(), v.y()}; }
Lens fromFb(const fb::Lens& l) { return {l.vertical_fov_rad(), l.width_px(), l.height_px()}; }
Pose fromFb(const fb::CameraPose& p) {
  const fb::Vec3& eye = p.eye();
  const auto& q = p.orientation();
  return {{eye.x(), eye.y(), eye.z()}, glm::dquat(q.w(), q.x(), q.y(), q.z())};
}

flatbuffers::Offset<flatbuffers::Vector<const fb::CameraPose*>> putPoses(Builder& b, const std::vector<Pose>& poses) {
  return b.CreateVectorOfStructs<fb::CameraPose>(poses.size(),
                                                 [&](size_t i, fb::CameraPose* out) { *out = toFb(poses[i]); });
}

flatbuffers::Offset<fb::Frame> putFrame(Builder& b, const Frame& f) {
  const fb::Vec2 anchor = toFb(f.anchor), axis_x = toFb(f.axis_x_m), axis_y = toFb(f.axis_y_m),
                 map = toFb(f.map_origin_m);
  const fb::Geodetic origin = toFb(f.origin);
  return fb::CreateFrame(b, static_cast<uint8_t>(f.kind), f.height_quantum_m, &anchor, &axis_x, &axis_y, &map,
                         f.latitude0_rad, f.longitude0_rad, f.latitude_step_rad, f.longitude_step_rad, f.semi_major_m,
                         f.flattening, &origin);
}

Bytes finish(Builder& b, fb::Body type, flatbuffers::Offset<void> body) {
  b.Finish(fb::CreateControl(b, type, body));
  Bytes out;
  out.reserve(b.GetSize() + 1);
  out.push_back(static_cast<uint8_t>(MessageKind::kControl));
  out.insert(out.end(), b.GetBufferPointer(), b.GetBufferPointer() + b.GetSize());
  return out;
}

// The verified control message, or nullptr. The bytes are copied so that they are aligned.
const fb::Control* verified(ByteSpan bytes, std::vector<uint64_t>& aligned) {
  if (bytes.size() < 2) return nullptr;
  const ByteSpan body = bytes.subspan(1);
  aligned.resize((body.size() + 7) / 8);
  std::memcpy(aligned.data(), body.data(), body.size());
  flatbuffers::Verifier verifier(reinterpret_cast<const uint8_t*>(aligned.data()), body.size(), kMaxNesting,
                                 kMaxTables);
  if (!fb::VerifyControlBuffer(verifier)) return nullptr;
  const fb::Control* control = fb::GetControl(aligned.data());
  return control->body() ? control : nullptr;  // the verifier lets a typed union without a table pass
}

std::string text(const flatbuffers::String* s, size_t limit) {
  return s ? std::string(cutText(s->str(), limit)) : std::string();
}

// FlatBuffers' verifier does not see to the alignment of a vector's structs, so they are read bytewise.
template <class T>
T structAt(const flatbuffers::Vector<const T*>& in, size_t i) {
  T out;
  std::memcpy(static_cast<void*>(&out), in.Data() + i * sizeof(T), sizeof(T));
  return out;
}

Result<std::vector<Pose>> posesOf(const flatbuffers::Vector<const fb::CameraPose*>* in) {
  if (!in || in->size() < 2 || in->size() > Path::kMaxPoses) return malformed("a path has 2 to 100000 poses");
  std::vector<Pose> poses;
  poses.reserve(in->size());
  for (size_t i = 0; i < in->size(); ++i) {
    poses.push_back(fromFb(structAt(*in, i)));
    if (!isUsable(poses.back())) return malformed("a pose is not finite, too far away or not a rotation");
  }
  return poses;
}

// ---- control bodies

Result<ClientControl> read(const fb::ViewRequest& m) {
  if (m.protocol() != kProtocolVersion)
    return malformed("the client speaks protocol " + std::to_string(m.protocol()) + ", this server " +
                     std::to_string(kProtocolVersion) + "; use matching versions");
  if (!m.lens()) return malformed("a view request lacks its lens");
  ViewRequest out;
  out.lens = fromFb(*m.lens());
  if (!isUsable(out.lens))
    return malformed("field of view must be 1 to 170 degrees, the viewport 1 to 16384 pixels a side");
  out.tau_px = m.tau_px();
  if (out.tau_px != 0 && !(out.tau_px >= 0.01 && out.tau_px <= 1000))
    return malformed("the tolerance must be 0.01 to 1000 pixels, or 0 for the server's own");
  if (m.strategy() > 2 || m.predictor() >= std::size(kPredictorNames))
    return malformed("unknown strategy or predictor");
  out.strategy = static_cast<Strategy>(m.strategy());
  out.predictor = static_cast<Predictor>(m.predictor());
  out.keyframe_interval = {m.keyframe_interval_us()};
  out.max_triangles = m.max_triangles();
  out.max_bytes_per_second = m.max_bytes_per_second();
  out.occlusion = m.occlusion();
  out.memory_bytes = m.memory_bytes();
  if (m.tile_contents() > 3) return malformed("a view request wants an unknown layer of tiles");
  out.relief = (m.tile_contents() & 1) != 0;
  out.imagery = (m.tile_contents() & 2) != 0;
  out.tile_bytes = m.tile_bytes();
  if (out.keyframe_interval != Duration{} &&
      (out.keyframe_interval < Duration::milliseconds(20) || out.keyframe_interval > Duration::milliseconds(10'000)))
    return malformed("the keyframe interval must be 20 to 10000 ms, or 0 for the server's own");
  return ClientControl(out);
}

Result<ClientControl> read(const fb::PathUpload& m) {
  auto poses = posesOf(m.poses());
  if (!poses) return poses.error();
  Path path{Time{m.start_us()}, Duration{m.step_us()}, std::move(poses).value()};
  constexpr int64_t kLatest_us = int64_t{1} << 60;
  if (m.start_us() < -kLatest_us || m.start_us() > kLatest_us) return malformed("a path starts at an absurd time");
  if (Status s = path.validate(); !s.ok()) return s.error();
  return ClientControl(std::move(path));
}

Result<ClientControl> read(const fb::TourRequest& m) {
  if (!(m.seconds() >= 1 && m.seconds() <= 3600)) return malformed("a tour lasts 1 to 3600 seconds");
  return ClientControl(TourRequest{m.id(), text(m.name(), kMaxNameBytes), m.seconds()});
}

Result<ClientControl> read(const fb::GroundRequest& m) {
  GroundRequest out{m.id(), {}};
  if (m.positions()) {
    if (m.positions()->size() > kMaxGroundPoints) return malformed("more than 65536 positions in one ground request");
    for (size_t i = 0; i < m.positions()->size(); ++i) out.positions.push_back(fromFb(structAt(*m.positions(), i)));
  }
  return ClientControl(std::move(out));
}

Result<ClientControl> read(const fb::SceneClock& m) {
  const SceneClock clock{Time{m.at_us()}, Time{m.scene_time_us()}, m.rate()};
  const auto isAbsurd = [](Time t) { return t.us < -Epochs::kMostTime_us || t.us > Epochs::kMostTime_us; };
  if (isAbsurd(clock.at) || isAbsurd(clock.scene_time) || !(std::abs(clock.rate) <= SceneClock::kMostRate))
    return malformed("a scene clock's time or rate is absurd");
  return ClientControl(clock);
}

Result<ClientControl> read(const fb::HeldTiles& m) {
  HeldTiles out;
  if (!m.tiles()) return ClientControl(std::move(out));
  if (m.tiles()->size() > kMostTilesHeld) return malformed("more tiles are held than may be");
  for (const uint64_t key : *m.tiles()) {
    out.tiles.push_back(TileId::of(key));
    if (out.tiles.back().layer >= kMaxTileLayers || out.tiles.back().level >= kMaxTileLevels)
      return malformed("a tile that is held is of no layer or level");
  }
  return ClientControl(std::move(out));
}

Result<TileLayer> layerOf(const fb::TileLayer& m) {
  TileLayer layer;
  layer.content = static_cast<TileContent>(m.content());
  layer.coding = static_cast<TileCoding>(m.coding());
  layer.width = m.width();
  layer.height = m.height();
  if (m.origin()) layer.origin = fromFb(*m.origin());
  layer.texel = m.texel();
  layer.step_m = m.step_m();
  layer.attribution = text(m.attribution(), kMaxTextBytes);
  if (Status s = layer.validate(); !s.ok()) return malformed(s.error().message);
  return layer;
}

Status readTiles(const fb::Welcome& m, Welcome& out) {
  out.tile_bytes = m.tile_bytes();
  if (!m.tile_layers()) return {};
  if (m.tile_layers()->size() > kMaxTileLayers) return malformed("too many layers of tiles");
  for (const fb::TileLayer* each : *m.tile_layers()) {
    auto layer = layerOf(*each);
    if (!layer) return layer.error();
    if (!out.tile_layers.empty() && out.tile_layers.front().content == layer->content)
      return malformed("two layers of tiles have the same content");
    out.tile_layers.push_back(std::move(*layer));
  }
  return {};
}

Result<Frame> frameOf(const fb::Frame* m, const GridShape& shape) {
  if (!m || !m->anchor() || !m->axis_x_m() || !m->axis_y_m() || !m->map_origin_m() || !m->origin())
    return malformed("the welcome lacks its frame");
  Frame f;
  f.kind = static_cast<FrameKind>(m->kind());
  f.height_quantum_m = m->height_quantum_m();
  f.anchor = fromFb(*m->anchor());
  f.axis_x_m = fromFb(*m->axis_x_m());
  f.axis_y_m = fromFb(*m->axis_y_m());
  f.map_origin_m = fromFb(*m->map_origin_m());
  f.latitude0_rad = m->latitude0_rad();
  f.longitude0_rad = m->longitude0_rad();
  f.latitude_step_rad = m->latitude_step_rad();
  f.longitude_step_rad = m->longitude_step_rad();
  f.semi_major_m = m->semi_major_m();
  f.flattening = m->flattening();
  f.origin = {m->origin()->latitude_rad(), m->origin()->longitude_rad(), m->origin()->height_m()};
  const double max_x = std::ldexp(shape.roots_x, static_cast<int>(shape.root_log2));
  const double max_y = std::ldexp(shape.roots_y, static_cast<int>(shape.root_log2));
  if (Status s = f.validate(max_x, max_y); !s.ok()) return s.error();
  return f;
}

bool readHeights(const flatbuffers::Vector<int32_t>* in, uint64_t expected, std::vector<int32_t>& out) {
  if (!in || in->size() != expected) return false;
  out.assign(in->begin(), in->end());
  return std::all_of(out.begin(), out.end(), [](int32_t h) { return h >= -kMaxHeight && h <= kMaxHeight; });
}

Result<ObjectModel> modelOf(const fb::Model& m) {
  ObjectModel model;
  if (!m.faces() || m.faces()->size() % 3 != 0 || m.faces()->size() / 3 > BaseMesh::kMaxFaces || !m.base() ||
      m.base()->size() % 3 != 0)
    return malformed("a model's faces or vertices are not in threes, or too many");
  model.shape.rule = static_cast<MeshRule>(m.rule());
  model.shape.halvings = m.halvings();
  model.shape.vertex_count = m.vertices();
  for (uint32_t i = 0; i < m.faces()->size(); i += 3)
    model.shape.faces.push_back({m.faces()->Get(i), m.faces()->Get(i + 1), m.faces()->Get(i + 2)});
  for (uint32_t i = 0; i < m.base()->size(); i += 3)
    model.base.emplace_back(m.base()->Get(i), m.base()->Get(i + 1), m.base()->Get(i + 2));
  model.quantum_m = m.quantum_m();
  model.atlas_side = m.atlas_side();
  return model;
}

Status readObjects(const fb::Welcome& m, Welcome& out) {
  if (m.models()) {
    if (m.models()->size() > ObjectSet::kMaxModels) return malformed("too many models");
    for (uint32_t i = 0; i < m.models()->size(); ++i) {
      auto model = modelOf(*m.models()->Get(i));
      if (!model) return model.error();
      out.models.push_back(std::move(*model));
    }
  }
  if (m.objects()) {
    if (m.objects()->size() > ObjectSet::kMaxObjects) return malformed("too many objects");
    for (size_t i = 0; i < m.objects()->size(); ++i) {
      const fb::Placement p = structAt(*m.objects(), i);
      const auto& q = p.orientation();
      out.objects.push_back({p.model(),
                             {p.position().x(), p.position().y(), p.position().z()},
                             glm::dquat(q.w(), q.x(), q.y(), q.z()),
                             p.scale()});
    }
  }
  if (auto set = ObjectSet::create(out.models, out.objects); !set) return set.error();
  return {};
}

Status readEpochs(const fb::Welcome& m, Welcome& out) {
  if (m.epochs()) {
    if (m.epochs()->size() > Epochs::kMost) return malformed("too many epochs");
    for (size_t i = 0; i < m.epochs()->size(); ++i) {
      const fb::Epoch e = structAt(*m.epochs(), i);
      out.epochs.push_back({Time{e.time_us()}, {e.x(), e.y(), e.width(), e.height()}});
    }
  }
  if (auto epochs = Epochs::create(out.shape, out.epochs); !epochs) return epochs.error();
  if (!m.base_offsets()) return {};
  const size_t vertices = out.corner_heights.size() + out.centre_heights.size();
  if (m.base_offsets()->size() > vertices * out.epochs.size()) return malformed("too many offsets of base vertices");
  for (size_t i = 0; i < m.base_offsets()->size(); ++i) {
    const fb::BaseOffset o = structAt(*m.base_offsets(), i);
    if (o.epoch() >= out.epochs.size() || o.vertex() >= vertices || std::abs(int64_t{o.quanta()}) > kMaxOffset)
      return malformed("an offset of a base vertex is of no epoch or no vertex, or absurd");
    out.base_offsets.push_back({o.epoch(), o.vertex(), o.quanta()});
  }
  return {};
}

Result<ServerControl> read(const fb::Welcome& m) {
  if (m.protocol() != kProtocolVersion)
    return malformed("the server speaks another protocol version; reload or update");
  if (!m.shape()) return malformed("the welcome lacks its shape");
  Welcome out;
  out.scene_id = m.scene_id();
  out.title = text(m.title(), kMaxTextBytes);
  out.crs = text(m.crs(), kMaxTextBytes);
  const fb::Shape& s = *m.shape();
  out.shape = {s.roots_x(), s.roots_y(), s.root_log2(), s.samples_x(), s.samples_y()};
  if (auto grid = GridTopology::create(out.shape); !grid) return grid.error();
  auto frame = frameOf(m.frame(), out.shape);
  if (!frame) return frame.error();
  out.frame = *frame;
  const uint64_t rx = out.shape.roots_x, ry = out.shape.roots_y;
  if (!readHeights(m.corner_heights(), (rx + 1) * (ry + 1), out.corner_heights) ||
      !readHeights(m.centre_heights(), rx * ry, out.centre_heights))
    return malformed("the base heights do not fit the shape");
  out.lowest = m.lowest();
  out.highest = m.highest();
  out.tau_px = m.tau_px();
  out.keyframe_interval = {m.keyframe_interval_us()};
  out.occlusion = m.occlusion();
  out.memory_bytes = m.memory_bytes();
  if (!(out.tau_px > 0) || out.keyframe_interval.us <= 0)
    return malformed("the welcome's tolerance or interval is not positive");
  if (Status objects = readObjects(m, out); !objects.ok()) return objects.error();
  if (Status epochs = readEpochs(m, out); !epochs.ok()) return epochs.error();
  if (Status tiles = readTiles(m, out); !tiles.ok()) return tiles.error();
  return ServerControl(std::move(out));
}

Result<ServerControl> read(const fb::TourReply& m) {
  auto poses = posesOf(m.poses());
  if (!poses) return poses.error();
  return ServerControl(TourReply{m.id(), {m.step_us()}, std::move(poses).value()});
}

Result<ServerControl> read(const fb::GroundReply& m) {
  GroundReply out{m.id(), {}};
  if (m.heights_m()) out.heights_m.assign(m.heights_m()->begin(), m.heights_m()->end());
  return ServerControl(std::move(out));
}

}  // namespace

const char* name(Strategy strategy) { return kStrategyNames[static_cast<size_t>(strategy)]; }
const char* name(Predictor predictor) { return kPredictorNames[static_cast<size_t>(predictor)]; }
std::string predictorNames() {
  std::string all;
  for (const char* each : kPredictorNames) all += (all.empty() ? "" : ", ") + std::string(each);
  return all;
}
std::optional<Strategy> strategyNamed(std::string_view wanted) { return named<Strategy>(kStrategyNames, wanted); }
std::optional<Predictor> predictorNamed(std::string_view wanted) { return named<Predictor>(kPredictorNames, wanted); }

Bytes encode(const ViewRequest& m) {
  Builder b;
  const fb::Lens lens = toFb(m.lens);
  const auto body = fb::CreateViewRequest(
      b, kProtocolVersion, &lens, m.tau_px, static_cast<uint8_t>(m.strategy), static_cast<uint8_t>(m.predictor),
      static_cast<uint32_t>(m.keyframe_interval.us), m.max_triangles, m.max_bytes_per_second, m.occlusion,
      m.memory_bytes, static_cast<uint8_t>((m.relief ? 1 : 0) | (m.imagery ? 2 : 0)), m.tile_bytes);
  return finish(b, fb::Body_ViewRequest, body.Union());
}

Bytes encode(const Path& m) {
  Builder b;
  const auto poses = putPoses(b, m.poses);
  return finish(b, fb::Body_PathUpload,
                fb::CreatePathUpload(b, m.start.us, static_cast<uint32_t>(m.step.us), poses).Union());
}

Bytes encode(const TourRequest& m) {
  Builder b;
  const auto tour = b.CreateString(m.name);
  return finish(b, fb::Body_TourRequest, fb::CreateTourRequest(b, m.id, tour, m.seconds).Union());
}

Bytes encode(const GroundRequest& m) {
  Builder b;
  const auto positions = b.CreateVectorOfStructs<fb::Vec2>(
      m.positions.size(), [&](size_t i, fb::Vec2* out) { *out = toFb(m.positions[i]); });
  return finish(b, fb::Body_GroundRequest, fb::CreateGroundRequest(b, m.id, positions).Union());
}

Bytes encode(const SceneClock& m) {
  Builder b;
  return finish(b, fb::Body_SceneClock, fb::CreateSceneClock(b, m.at.us, m.scene_time.us, m.rate).Union());
}

Bytes encode(const HeldTiles& m) {
  Builder b;
  std::vector<uint64_t> keys;
  for (const TileId& tile : m.tiles) keys.push_back(tile.key());
  const auto tiles = b.CreateVector(keys);
  return finish(b, fb::Body_HeldTiles, fb::CreateHeldTiles(b, tiles).Union());
}

namespace {

flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<fb::TileLayer>>> putLayers(
    Builder& b, const std::vector<TileLayer>& layers) {
  if (layers.empty()) return {};
  std::vector<flatbuffers::Offset<fb::TileLayer>> each;
  for (const TileLayer& m : layers) {
    const auto attribution = b.CreateString(m.attribution);
    const fb::Vec2 origin = toFb(m.origin);
    each.push_back(fb::CreateTileLayer(b, static_cast<uint8_t>(m.content), static_cast<uint8_t>(m.coding), m.width,
                                       m.height, &origin, m.texel, m.step_m, attribution));
  }
  return b.CreateVector(each);
}

flatbuffers::Offset<fb::Model> putModel(Builder& b, const ObjectModel& m) {
  std::vector<uint32_t> faces;
  std::vector<int32_t> base;
  for (const BaseFace& f : m.shape.faces) faces.insert(faces.end(), f.begin(), f.end());
  for (const glm::ivec3& p : m.base) base.insert(base.end(), {p.x, p.y, p.z});
  const auto faces_at = b.CreateVector(faces);
  const auto base_at = b.CreateVector(base);
  return fb::CreateModel(b, static_cast<uint8_t>(m.shape.rule), m.shape.halvings, m.shape.vertex_count, faces_at,
                         base_at, m.quantum_m, m.atlas_side);
}

fb::Placement toFb(const ObjectPlacement& p) {
  const glm::dquat& q = p.orientation;
  return {fb::Vec3(p.position.x, p.position.y, p.position.z), fb::Quat(q.w, q.x, q.y, q.z), p.scale, p.model};
}

}  // namespace

Bytes encode(const Welcome& m) {
  Builder b;
  flatbuffers::Offset<flatbuffers::Vector<flatbuffers::Offset<fb::Model>>> models;
  flatbuffers::Offset<flatbuffers::Vector<const fb::Placement*>> objects;
  if (!m.objects.empty()) {
    std::vector<flatbuffers::Offset<fb::Model>> each;
    for (const ObjectModel& model : m.models) each.push_back(putModel(b, model));
    models = b.CreateVector(each);
    objects = b.CreateVectorOfStructs<fb::Placement>(m.objects.size(),
                                                     [&](size_t i, fb::Placement* out) { *out = toFb(m.objects[i]); });
  }
  flatbuffers::Offset<flatbuffers::Vector<const fb::Epoch*>> epochs;
  flatbuffers::Offset<flatbuffers::Vector<const fb::BaseOffset*>> base_offsets;
  if (!m.epochs.empty()) {
    epochs = b.CreateVectorOfStructs<fb::Epoch>(m.epochs.size(), [&](size_t i, fb::Epoch* out) {
      const LatticeWindow& w = m.epochs[i].moved;
      *out = {m.epochs[i].time.us, w.x, w.y, w.width, w.height};
    });
    base_offsets = b.CreateVectorOfStructs<fb::BaseOffset>(m.base_offsets.size(), [&](size_t i, fb::BaseOffset* out) {
      *out = {m.base_offsets[i].epoch, m.base_offsets[i].vertex, m.base_offsets[i].quanta};
    });
  }
  const auto layers = putLayers(b, m.tile_layers);
  const auto title = b.CreateString(m.title), crs = b.CreateString(m.crs);
  const auto frame = putFrame(b, m.frame);
  const auto shape =
      fb::CreateShape(b, m.shape.roots_x, m.shape.roots_y, m.shape.root_log2, m.shape.samples_x, m.shape.samples_y);
  const auto corners = b.CreateVector(m.corner_heights), centres = b.CreateVector(m.centre_heights);
  const auto body = fb::CreateWelcome(b, kProtocolVersion, m.scene_id, title, crs, frame, shape, m.lowest, m.highest,
                                      corners, centres, m.tau_px, static_cast<uint32_t>(m.keyframe_interval.us), models,
                                      objects, m.occlusion, m.memory_bytes, epochs, base_offsets, layers, m.tile_bytes);
  return finish(b, fb::Body_Welcome, body.Union());
}

Bytes encode(const TourReply& m) {
  Builder b;
  const auto poses = putPoses(b, m.poses);
  return finish(b, fb::Body_TourReply, fb::CreateTourReply(b, m.id, static_cast<uint32_t>(m.step.us), poses).Union());
}

Bytes encode(const GroundReply& m) {
  Builder b;
  const auto heights = b.CreateVector(m.heights_m);
  return finish(b, fb::Body_GroundReply, fb::CreateGroundReply(b, m.id, heights).Union());
}

Bytes encode(const Refusal& m) {
  Builder b;
  const auto message = b.CreateString(m.message);
  return finish(b, fb::Body_Refusal, fb::CreateRefusal(b, message).Union());
}

Result<ClientControl> decodeClientControl(ByteSpan bytes) {
  std::vector<uint64_t> aligned;
  const fb::Control* control = verified(bytes, aligned);
  if (!control) return malformed("not a message of this protocol");
  switch (control->body_type()) {
    case fb::Body_ViewRequest:
      return read(*control->body_as_ViewRequest());
    case fb::Body_PathUpload:
      return read(*control->body_as_PathUpload());
    case fb::Body_TourRequest:
      return read(*control->body_as_TourRequest());
    case fb::Body_GroundRequest:
      return read(*control->body_as_GroundRequest());
    case fb::Body_SceneClock:
      return read(*control->body_as_SceneClock());
    case fb::Body_HeldTiles:
      return read(*control->body_as_HeldTiles());
    default:
      return malformed("not one that a client sends");
  }
}

Result<ServerControl> decodeServerControl(ByteSpan bytes) {
  std::vector<uint64_t> aligned;
  const fb::Control* control = verified(bytes, aligned);
  if (!control) return malformed("not a message of this protocol");
  switch (control->body_type()) {
    case fb::Body_Welcome:
      return read(*control->body_as_Welcome());
    case fb::Body_TourReply:
      return read(*control->body_as_TourReply());
    case fb::Body_GroundReply:
      return read(*control->body_as_GroundReply());
    case fb::Body_Refusal:
      return ServerControl(Refusal{text(control->body_as_Refusal()->message(), kMaxTextBytes)});
    default:
      return malformed("not one that a server sends");
  }
}

}  // namespace foreland::proto
