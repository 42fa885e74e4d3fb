#include "client/c/terrain.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <variant>

#include "client/c/structs.h"

namespace foreland::client {
namespace {

constexpr double kGroundFrames = 8;  // so many frames ahead the ground is known
constexpr double kMaxReach = 4096;   // samples
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double toMilliseconds(Time time) { return static_cast<double>(time.us) / 1000; }

SessionOptions sessionOptions(const std::string& url, WebSocketClient::Options connection, const Choice& choice) {
  const ForelandOptions& o = choice.options;
  return {.url = url,
          .connection = std::move(connection),
          .request = requestOf(choice).value(),
          .blend = blendOf(o).value(),
          .has_meshes = o.meshes != FORELAND_OFF};
}

ForelandSight sightOf(const proto::SightReply& reply, size_t i) {
  const proto::SightHit& hit = reply.hits[i];
  ForelandSight out{};
  out.what = hit.what;
  put(reply.ends[2 * i], out.from);
  put(reply.ends[2 * i + 1], out.to);
  const bool hides = hit.what >= proto::SightHit::kGround;
  put(hides ? hit.position : glm::dvec3(std::numeric_limits<double>::quiet_NaN()), out.hit);
  return out;
}

}  // namespace

Terrain::Terrain(const std::string& url, WebSocketClient::Options connection, Choice choice)
    : choice_(choice),
      requested_(requestOf(choice).value()),
      has_meshes_(choice.options.meshes != FORELAND_OFF),
      session_(sessionOptions(url, std::move(connection), choice)) {}

// ---- what comes

void Terrain::receive() {
  session_.take(incoming_);
  for (FromSession& message : incoming_) std::visit([this](auto& m) { on(std::move(m)); }, message);
}

bool Terrain::wait(double milliseconds) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::microseconds(std::llround(milliseconds * 1000));
  for (;;) {
    receive();
    if (!happenings_.empty() || !updates_.empty()) return true;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    if (left.count() <= 0) return false;
    session_.wait(left);
  }
}

const ForelandEvent* Terrain::nextEvent() {
  if (happenings_.empty()) receive();
  if (happenings_.empty()) return nullptr;
  happening_ = std::move(happenings_.front());
  happenings_.pop_front();
  ForelandEvent& out = happening_.event;
  out.message = happening_.message.c_str();
  if (out.kind == FORELAND_EVENT_HEIGHTS) out.heights = happening_.heights.data();
  if (!happening_.undulations.empty()) out.undulations = happening_.undulations.data();
  if (out.kind == FORELAND_EVENT_SIGHTS) out.sights = happening_.sights.data();
  if (out.kind == FORELAND_EVENT_VIEWSHED) {
    static_assert(sizeof(proto::ViewshedCell) == sizeof(uint8_t));
    happening_.viewshed.cells = reinterpret_cast<const uint8_t*>(happening_.viewshed_reply.cells.data());
    out.viewshed = &happening_.viewshed;
  }
  return &out;
}

// Of what is no answer the newest is enough: a host that does not look is not told ever more.
void Terrain::happen(uint32_t kind, double value, std::string message) {
  const bool is_answer = kind >= FORELAND_EVENT_HEIGHTS;
  if (!is_answer) std::erase_if(happenings_, [&](const Happening& h) { return h.event.kind == kind; });
  Happening& happening = happenings_.emplace_back();
  happening.event.size = sizeof(ForelandEvent);
  happening.event.kind = kind;
  happening.event.value = value;
  happening.message = std::move(message);
}

Happening& Terrain::answer(uint32_t kind, uint64_t question) {
  happen(kind);
  happenings_.back().event.question = question;
  return happenings_.back();
}

void Terrain::on(from::Welcome message) {
  screen_.enter(std::move(message.welcome));
  state_.is_connected = true;
  tellScene();
  happen(FORELAND_EVENT_SCENE);
}

void Terrain::on(from::Mesh message) {
  if (message.redraws != redraws_) return;
  screen_.add(message.interval, message.oldest_version);
  if (!has_meshes_) taken_ = message.interval.version;
  if (message.update) updates_.push_back(std::move(message.update));
}

void Terrain::on(from::State message) {
  if (!message.ground.empty()) screen_.takeGround(message.ground);
  state_ = std::move(message);
}

void Terrain::on(from::Stall message) {
  state_.is_connected = false;
  happen(FORELAND_EVENT_STALL, message.wait.toMilliseconds(), std::move(message.reason));
}

void Terrain::on(from::Migrate) { happen(FORELAND_EVENT_MIGRATE); }

void Terrain::on(from::Refused message) {
  state_.is_connected = false;
  happen(FORELAND_EVENT_REFUSED, 0, std::move(message.reason));
}

void Terrain::on(from::Failed message) {
  state_.is_connected = false;
  happen(FORELAND_EVENT_FAILED, 0, std::move(message.reason));
}

void Terrain::on(from::Heights message) {
  Happening& told = answer(FORELAND_EVENT_HEIGHTS, message.question);
  told.heights.assign(message.heights_m.begin(), message.heights_m.end());
  told.undulations.assign(message.undulations_m.begin(), message.undulations_m.end());
  told.event.count = static_cast<uint32_t>(told.heights.size());
}

void Terrain::on(from::Sights message) {
  Happening& told = answer(FORELAND_EVENT_SIGHTS, message.question);
  for (size_t i = 0; i < message.reply.hits.size(); ++i) told.sights.push_back(sightOf(message.reply, i));
  told.event.count = static_cast<uint32_t>(told.sights.size());
}

void Terrain::on(from::Viewshed message) {
  Happening& told = answer(FORELAND_EVENT_VIEWSHED, message.question);
  const proto::ViewshedReply& v = told.viewshed_reply = std::move(message.reply);
  told.viewshed = {.first = {v.first.x, v.first.y},
                   .step = {v.step.x, v.step.y},
                   .columns = v.columns,
                   .rows = v.rows,
                   .begin = v.begin,
                   .count = static_cast<uint32_t>(v.cells.size()),
                   .cells = nullptr};
  told.event.value = told.viewshed.begin + told.viewshed.count == v.columns * v.rows ? 1 : 0;
}

void Terrain::on(from::Unanswered message) {
  answer(FORELAND_EVENT_UNANSWERED, message.question).message = std::move(message.reason);
}

void Terrain::cancel(uint64_t question) {
  tell(told::Cancel{question});
  std::erase_if(happenings_, [&](const Happening& h) { return h.event.question == question; });
}

// ---- what it is

void Terrain::tellScene() {
  const proto::Welcome& w = *screen_.welcome;
  const proto::FrameTransform& transform = *screen_.transform;
  const bool is_geographic = w.frame.kind == proto::FrameKind::kGeographic;
  epochs_.clear(), landmarks_.clear();
  for (const proto::Epoch& epoch : w.epochs) epochs_.push_back(toMilliseconds(epoch.time));
  for (const glm::dvec3& p : landmarksOf(w, transform)) landmarks_.insert(landmarks_.end(), {p.x, p.y, p.z});
  scene_ = {.size = sizeof(ForelandScene),
            .is_geographic = is_geographic ? 1u : 0u,
            .id = w.scene_id,
            .title = w.title.c_str(),
            .crs = w.crs.c_str(),
            .low = {},
            .high = {},
            .lowest = w.lowest * w.frame.height_quantum_m,
            .highest = w.highest * w.frame.height_quantum_m,
            .samples = {w.shape.samples_x, w.shape.samples_y},
            .to_ecef = {},
            .epochs = epochs_.data(),
            .epoch_count = static_cast<uint32_t>(epochs_.size()),
            .landmark_count = static_cast<uint32_t>(landmarks_.size() / 3),
            .landmarks = landmarks_.data(),
            .max_moved = w.max_offset * w.frame.height_quantum_m,
            .has_relief = 0,
            .has_imagery = 0,
            .relief_attribution = "",
            .imagery_attribution = "",
            .zero_surface = static_cast<uint32_t>(w.vertical.zero_surface),
            .reserved = 0,
            .datum = w.vertical.name.c_str(),
            .geoid = w.vertical.geoid.c_str(),
            .undulation_error = w.vertical.undulations.max_error_m};
  put(screen_.box.low, scene_.low), put(screen_.box.high, scene_.high);
  if (is_geographic) std::ranges::copy(ecefOf(transform), scene_.to_ecef);
  for (const proto::TileLayer& layer : w.tile_layers) {
    const bool is_relief = layer.content == proto::TileContent::kRelief;
    (is_relief ? scene_.has_relief : scene_.has_imagery) = 1;
    (is_relief ? scene_.relief_attribution : scene_.imagery_attribution) = layer.attribution.c_str();
  }
}

ForelandStats Terrain::stats() const {
  const ViewerStatistics& s = state_.statistics;
  return {.size = sizeof(ForelandStats),
          .is_connected = state_.is_connected ? 1u : 0u,
          .bytes_down = s.bytes_down,
          .bytes_up = s.bytes_up,
          .nodes_added = s.nodes_added,
          .nodes_removed = s.nodes_removed,
          .keyframes = s.keyframes,
          .late_keyframes = s.late_keyframes,
          .last_lateness = s.last_lateness.toMilliseconds(),
          .worst_lateness = s.worst_lateness.toMilliseconds(),
          .tiles_received = s.tiles,
          .tile_bytes = state_.tile_bytes};
}

// ---- what is wanted

Status Terrain::request(const Choice& choice) {
  Result<proto::ViewRequest> wanted = requestOf(choice);
  const Result<Blend> blend = blendOf(choice.options);
  if (!wanted.ok()) return wanted.error();
  if (!blend.ok()) return blend.error();
  if (*blend != *blendOf(choice_.options)) tell(told::SetBlend{*blend});
  choice_ = choice;
  requested_ = *wanted;
  tell(told::Request{std::move(*wanted)});
  return {};
}

Status Terrain::setLens(const ForelandLens& lens) {
  Choice choice = choice_;
  choice.lens = lens;
  return request(choice);
}

Status Terrain::setOptions(const ForelandOptions& changes) {
  Choice choice = choice_;
  change(choice.options, changes);
  return request(choice);
}

Status Terrain::setSceneClock(const proto::SceneClock& clock) {
  if (Status s = isTaken(clock); !s.ok()) return s;
  tell(told::Clock{clock});
  return {};
}

Status Terrain::announcePath(proto::Path path) {
  Choice choice = choice_;
  choice.has_path = !path.poses.empty();
  if (Status s = choice.has_path ? path.validate() : Status{}; !s.ok()) return s;
  tell(told::Path{std::move(path)});
  return request(choice);
}

void Terrain::jump() {
  screen_.camera.jump();
  tell(told::Jump{});
}

// ---- a frame

ForelandFrame Terrain::frame(Time now, const proto::Pose& pose) {
  receive();
  now = last_frame_ = std::max(now, last_frame_);
  const ScreenFrame shown = screen_.frame(now, {pose, requested_.lens}, requested_.strategy, ready_, coming_);
  const proto::Pose& camera = shown.pose;
  const glm::dquat& q = camera.orientation;
  ForelandFrame out{.size = sizeof(ForelandFrame),
                    .version = shown.interval ? shown.interval->version : 0,
                    .weight = shown.weight,
                    .pose = {{camera.eye.x, camera.eye.y, camera.eye.z}, {q.x, q.y, q.z, q.w}},
                    .guaranteed_px = shown.interval ? shown.tolerance_px : kInfinity,
                    .shown_time = toMilliseconds(shown.interval ? shown.shown_time : now),
                    .end_time = shown.interval ? toMilliseconds(shown.interval->end) : 0,
                    .scene_time = shown.scene_time_us / 1000,
                    .next_version = shown.next_version,
                    .reserved = 0};
  tellGuarantee(out.guaranteed_px);
  tell(told::Frame{now, pose, groundReach(pose.eye), taken_});
  return out;
}

void Terrain::tellGuarantee(double guaranteed_px) {
  if (guaranteed_px == guaranteed_px_) return;
  guaranteed_px_ = guaranteed_px;
  happen(FORELAND_EVENT_GUARANTEE, guaranteed_px);
}

// How far about the eye, in samples, the ground is needed before the session tells it again.
double Terrain::groundReach(const glm::dvec3& eye) {
  const double step_m = glm::distance(eye, std::exchange(last_eye_, eye));
  if (!hasScene()) return 1;
  const double across_m = std::hypot(scene_.high[0] - scene_.low[0], scene_.high[1] - scene_.low[1]);
  const double spacing_m = across_m / std::hypot(scene_.samples[0], scene_.samples[1]);
  return std::clamp(kGroundFrames * step_m / spacing_m, 1.0, kMaxReach);
}

const MeshUpdate* Terrain::nextUpdate() {
  if (updates_.empty()) receive();
  if (updates_.empty()) return nullptr;
  update_ = std::move(updates_.front());
  updates_.pop_front();
  taken_ = update_->interval.version;
  return update_.get();
}

void Terrain::redraw() {
  screen_.schedule.clear();
  updates_.clear();
  taken_ = 0;
  tell(told::Redraw{++redraws_});
}

// ---- where things are

glm::dvec3 Terrain::pointOf(const ForelandMapPoint& place) const {
  return scenePointOf(*screen_.transform, {place.y, place.x}, place.height);
}

glm::dvec2 Terrain::latticeOf(const ForelandMapPoint& place) const {
  return mapPositionOf(*screen_.transform, pointOf(place)).lattice;
}

ForelandPlace Terrain::placeOf(const glm::dvec3& point) const {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const ScreenPlace place = screen_.placeAt(point);
  ForelandPlace out{.size = sizeof(ForelandPlace),
                    .reserved = 0,
                    .at = {place.at.across.y, place.at.across.x, place.at.height_m},
                    .ground = place.ground_m.value_or(kUnknown),
                    .slope = place.slope_rad.value_or(kUnknown),
                    .up = {},
                    .lattice = {place.at.lattice.x, place.at.lattice.y},
                    .undulation = place.undulation_m.value_or(kUnknown)};
  put(place.at.up, out.up);
  return out;
}

}  // namespace foreland::client
