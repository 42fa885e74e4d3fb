#include "proto/message/control.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "proto/message/control_buffer.h"

namespace foreland::proto {

namespace {

constexpr size_t kMaxNameBytes = 64;
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

fb::Lens toFb(const Lens& l) { return {l.vertical_fov_rad, l.width_px, l.height_px}; }
fb::CameraPose toFb(const Pose& p) {
  const glm::dquat& q = p.orientation;
  return {fb::Vec3(p.eye.x, p.eye.y, p.eye.z), fb::Quat(q.w, q.x, q.y, q.z)};
}

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
  const Lens shown{out.lens.vertical_fov_rad, std::max(out.lens.width_px, 1u), std::max(out.lens.height_px, 1u)};
  if (!isUsable(shown))
    return malformed("field of view must be 1 to 170 degrees, the viewport at most 16384 pixels a side");
  out.tau_px = m.tau_px();
  if (out.tau_px != 0 && !(out.tau_px >= 0.01 && out.tau_px <= 1000))
    return malformed("the tolerance must be 0.01 to 1000 pixels, or 0 for the server's own");
  if (m.strategy() > 2 || m.predictor() >= std::size(kPredictorNames))
    return malformed("unknown strategy or predictor");
  out.strategy = static_cast<Strategy>(m.strategy());
  out.predictor = static_cast<Predictor>(m.predictor());
  out.keyframe_interval = {m.keyframe_interval_us()};
  out.longest_interval = {m.longest_interval_us()};
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
  if (out.longest_interval != Duration{} &&
      (out.keyframe_interval == Duration{} || out.longest_interval < out.keyframe_interval ||
       out.longest_interval > Duration::milliseconds(10'000)))
    return malformed("the longest keyframe interval must be from the shortest to 10000 ms, or 0 for a fixed one");
  out.order = std::max<uint32_t>(m.order(), 1);
  if (out.order > kMaxOrder) return malformed("the order of the blend must be 1 to 3");
  out.eye_radius_m = m.eye_radius_m();
  if (!(out.eye_radius_m >= 0 && out.eye_radius_m <= kMaxEyeRadius_m))
    return malformed("eyes must be 0 to 100 m from the pose's");
  if (out.order > 1 && out.longest_interval != Duration{})
    return malformed("keyframes that adapt are blended two at a time: an order above 1 needs a fixed interval");
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
    for (size_t i = 0; i < m.positions()->size(); ++i) out.positions.push_back(vectorOf(structAt(*m.positions(), i)));
  }
  return ClientControl(std::move(out));
}

Result<ClientControl> read(const fb::SceneClock& m) {
  const SceneClock clock{Time{m.at_us()}, Time{m.scene_time_us()}, m.rate()};
  const auto isAbsurd = [](Time t) { return t.us < -Epochs::kMaxTime_us || t.us > Epochs::kMaxTime_us; };
  if (isAbsurd(clock.at) || isAbsurd(clock.scene_time) || !(std::abs(clock.rate) <= SceneClock::kMaxRate))
    return malformed("a scene clock's time or rate is absurd");
  return ClientControl(clock);
}

Result<ClientControl> read(const fb::HeldTiles& m) {
  HeldTiles out;
  if (!m.tiles()) return ClientControl(std::move(out));
  if (m.tiles()->size() > kMaxTilesHeld) return malformed("more tiles are held than may be");
  for (const uint64_t key : *m.tiles()) {
    out.tiles.push_back(TileId::of(key));
    if (out.tiles.back().layer >= kMaxTileLayers || out.tiles.back().level >= kMaxTileLevels)
      return malformed("a tile that is held is of no layer or level");
  }
  return ClientControl(std::move(out));
}

template <class Control, class Message>
Result<Control> controlOf(Result<Message> message) {
  if (!message) return message.error();
  return Control(std::move(message).value());
}

Result<ServerControl> read(const fb::TourReply& m) {
  auto poses = posesOf(m.poses());
  if (!poses) return poses.error();
  return ServerControl(TourReply{m.id(), {m.step_us()}, std::move(poses).value()});
}

Result<ServerControl> read(const fb::GroundReply& m) {
  GroundReply out{m.id(), {}, {}};
  if (m.heights_m()) out.heights_m.assign(m.heights_m()->begin(), m.heights_m()->end());
  if (m.undulations_m()) out.undulations_m.assign(m.undulations_m()->begin(), m.undulations_m()->end());
  if (!out.undulations_m.empty() && out.undulations_m.size() != out.heights_m.size())
    return malformed("a reply has not as many undulations as heights");
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
      m.memory_bytes, static_cast<uint8_t>((m.relief ? 1 : 0) | (m.imagery ? 2 : 0)), m.tile_bytes,
      static_cast<uint32_t>(m.longest_interval.us), static_cast<uint8_t>(m.order > 1 ? m.order : 0), m.eye_radius_m);
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
      m.positions.size(), [&](size_t i, fb::Vec2* out) { *out = bufferOf(m.positions[i]); });
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

Bytes encode(const TourReply& m) {
  Builder b;
  const auto poses = putPoses(b, m.poses);
  return finish(b, fb::Body_TourReply, fb::CreateTourReply(b, m.id, static_cast<uint32_t>(m.step.us), poses).Union());
}

Bytes encode(const GroundReply& m) {
  Builder b;
  const auto heights = b.CreateVector(m.heights_m);
  flatbuffers::Offset<flatbuffers::Vector<float>> undulations;
  if (!m.undulations_m.empty()) undulations = b.CreateVector(m.undulations_m);
  return finish(b, fb::Body_GroundReply, fb::CreateGroundReply(b, m.id, heights, undulations).Union());
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
    case fb::Body_SightRequest:
      return controlOf<ClientControl>(readSightRequest(*control->body_as_SightRequest()));
    case fb::Body_ViewshedRequest:
      return controlOf<ClientControl>(readViewshedRequest(*control->body_as_ViewshedRequest()));
    case fb::Body_RequestCancel:
      return ClientControl(RequestCancel{control->body_as_RequestCancel()->id()});
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
      return controlOf<ServerControl>(readWelcome(*control->body_as_Welcome()));
    case fb::Body_TourReply:
      return read(*control->body_as_TourReply());
    case fb::Body_GroundReply:
      return read(*control->body_as_GroundReply());
    case fb::Body_Refusal:
      return ServerControl(Refusal{text(control->body_as_Refusal()->message(), kMaxTextBytes)});
    case fb::Body_SightReply:
      return controlOf<ServerControl>(readSightReply(*control->body_as_SightReply()));
    case fb::Body_ViewshedReply:
      return controlOf<ServerControl>(readViewshedReply(*control->body_as_ViewshedReply()));
    default:
      return malformed("not one that a server sends");
  }
}

}  // namespace foreland::proto
