#include "client/fly/options_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

namespace foreland::client {

namespace {

using Json = nlohmann::ordered_json;

Json toJson(const proto::ViewRequest& r) {
  return {{"fov_rad", r.lens.vertical_fov_rad},
          {"width_px", r.lens.width_px},
          {"height_px", r.lens.height_px},
          {"tau_px", r.tau_px},
          {"strategy", proto::name(r.strategy)},
          {"predictor", proto::name(r.predictor)},
          {"keyframe_us", r.keyframe_interval.us},
          {"longest_keyframe_us", r.longest_interval.us},
          {"max_triangles", r.max_triangles},
          {"max_bytes_per_second", r.max_bytes_per_second},
          {"occlusion", r.occlusion},
          {"memory_bytes", r.memory_bytes},
          {"relief", r.relief},
          {"imagery", r.imagery},
          {"tile_bytes", r.tile_bytes}};
}

Json toJson(const ViewChoice& choice) { return {{"request", toJson(choice.request)}, {"blend", name(choice.blend)}}; }

std::string textOf(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json toJson(const Track& track) {
  Json fixes = Json::array();
  for (const Fix& fix : track.fixes) fixes.push_back({fix.time_s, fix.latitude_rad, fix.longitude_rad, fix.height_m});
  Json cameras = Json::array();
  for (const CameraFrame& c : track.cameras)
    cameras.push_back(
        {c.time_s, c.eye.x, c.eye.y, c.eye.z, c.orientation.w, c.orientation.x, c.orientation.y, c.orientation.z});
  return {{"has_heights", track.heights == TrackHeights::kRecorded},
          {"fixes", std::move(fixes)},
          {"cameras", std::move(cameras)}};
}

Json toJson(const TrackOptions& o) {
  Json json = {{"speed", o.speed}, {"from_s", o.from_s}, {"clearance_m", o.clearance_m}};
  if (o.seconds) json["seconds"] = *o.seconds;
  if (o.agl_m) json["agl_m"] = *o.agl_m;
  return json;
}

// Reads members of an object; what is missing, of another type or beyond its range is noted once, by its name.
class Members {
 public:
  explicit Members(const Json& object, std::string& wrong) : object_(object), wrong_(wrong) {}

  double number(const char* key, double least, double most) {
    const Json* value = find(key, &Json::is_number);
    const double number = value ? value->get<double>() : least;
    if (!(number >= least && number <= most)) note(key);
    return std::clamp(std::isnan(number) ? least : number, least, most);
  }
  template <class Integer>
  Integer integer(const char* key, int64_t least, int64_t most) {
    const Json* value = find(key, &Json::is_number_integer);
    const int64_t number = value ? value->get<int64_t>() : least;
    if (number < least || number > most) note(key);
    return static_cast<Integer>(std::clamp(number, least, most));
  }
  bool flag(const char* key) {
    const Json* value = find(key, &Json::is_boolean);
    return value && value->get<bool>();
  }
  std::string text(const char* key) {
    const Json* value = find(key, &Json::is_string);
    return value ? value->get<std::string>() : std::string();
  }
  // By its name.
  template <class Value, class Named>
  Value named(const char* key, const Named& named, Value otherwise) {
    const std::optional<Value> value = named(text(key));
    if (!value) note(key);
    return value.value_or(otherwise);
  }
  Members object(const char* key) {
    static const Json kEmpty = Json::object();
    const Json* value = find(key, &Json::is_object);
    return Members(value ? *value : kEmpty, wrong_);
  }
  bool has(const char* key) const { return object_.contains(key); }
  const Json* array(const char* key) { return find(key, &Json::is_array); }
  void note(const char* key) {
    if (wrong_.empty()) wrong_ = key;
  }

 private:
  const Json* find(const char* key, bool (Json::*is_kind)() const noexcept) {
    const auto at = object_.find(key);
    if (at != object_.end() && (*at.*is_kind)()) return &*at;
    note(key);
    return nullptr;
  }
  const Json& object_;
  std::string& wrong_;
};

constexpr double kMax = 1e9;
constexpr int64_t kMaxWord = std::numeric_limits<uint32_t>::max();

proto::ViewRequest requestFrom(Members json) {
  constexpr int64_t kWidest = 16384;
  proto::ViewRequest r;
  r.lens.vertical_fov_rad = json.number("fov_rad", 0.001, 3.1);
  r.lens.width_px = json.integer<uint32_t>("width_px", 1, kWidest);
  r.lens.height_px = json.integer<uint32_t>("height_px", 1, kWidest);
  r.tau_px = json.number("tau_px", 0, 1000);
  r.strategy = json.named("strategy", proto::strategyNamed, r.strategy);
  r.predictor = json.named("predictor", proto::predictorNamed, r.predictor);
  r.keyframe_interval.us = json.integer<int64_t>("keyframe_us", 0, 10'000'000);
  r.longest_interval.us = json.integer<int64_t>("longest_keyframe_us", 0, 10'000'000);
  r.max_triangles = json.integer<uint32_t>("max_triangles", 0, kMaxWord);
  r.max_bytes_per_second = json.integer<uint32_t>("max_bytes_per_second", 0, kMaxWord);
  r.occlusion = json.flag("occlusion");
  r.memory_bytes = json.integer<uint32_t>("memory_bytes", 0, kMaxWord);
  r.relief = json.flag("relief");
  r.imagery = json.flag("imagery");
  r.tile_bytes = json.integer<uint32_t>("tile_bytes", 0, kMaxWord);
  return r;
}

// The rows of numbers that an array holds, each of `count`; the first that is none ends them.
template <size_t count>
std::vector<std::array<double, count>> rowsFrom(Members& json, const char* key) {
  std::vector<std::array<double, count>> rows;
  const Json* array = json.array(key);
  for (size_t i = 0; array && i < array->size(); ++i) {
    const Json& row = (*array)[i];
    const auto isSound = [](const Json& n) { return n.is_number() && std::abs(n.get<double>()) <= kMax; };
    if (!row.is_array() || row.size() != count || !std::all_of(row.begin(), row.end(), isSound)) {
      json.note(key);
      break;
    }
    rows.emplace_back();
    for (size_t k = 0; k < count; ++k) rows.back()[k] = row[k].get<double>();
  }
  return rows;
}

template <class Point>
bool areInOrder(const std::vector<Point>& points) {
  const auto isLater = [](const Point& a, const Point& b) { return !(a.time_s < b.time_s); };
  return points.size() >= 2 && points.size() <= Track::kMaxFixes &&
         std::adjacent_find(points.begin(), points.end(), isLater) == points.end();
}

std::shared_ptr<const Track> trackFrom(Members json) {
  Track track;
  track.heights = json.flag("has_heights") ? TrackHeights::kRecorded : TrackHeights::kMissing;
  for (const auto& n : rowsFrom<4>(json, "fixes")) track.fixes.push_back({n[0], n[1], n[2], n[3]});
  if (json.has("cameras"))
    for (const auto& n : rowsFrom<8>(json, "cameras"))
      track.cameras.push_back({n[0], {n[1], n[2], n[3]}, {n[4], n[5], n[6], n[7]}});
  const auto isUnit = [](const CameraFrame& c) { return std::fabs(glm::length(c.orientation) - 1) < 1e-3; };
  const bool is_sound = track.cameras.empty() ? areInOrder(track.fixes)
                                              : track.fixes.empty() && areInOrder(track.cameras) &&
                                                    std::all_of(track.cameras.begin(), track.cameras.end(), isUnit);
  if (!is_sound) json.note("fixes");
  return std::make_shared<const Track>(std::move(track));
}

TrackOptions trackOptionsFrom(Members json) {
  TrackOptions o;
  o.speed = json.number("speed", -kMax, kMax);
  o.from_s = json.number("from_s", -kMax, kMax);
  o.clearance_m = json.number("clearance_m", -kMax, kMax);
  if (json.has("seconds")) o.seconds = json.number("seconds", -kMax, kMax);
  if (json.has("agl_m")) o.agl_m = json.number("agl_m", -kMax, kMax);
  return o;
}

ViewChoice choiceFrom(Members json) {
  return {requestFrom(json.object("request")), json.named("blend", blendNamed, Blend::kKeyframe)};
}

Error wrongly(const std::string& member) {
  return {ErrorCode::kMalformed, "what was flown is said wrongly: '" + member + "'"};
}
Error noObject() { return {ErrorCode::kMalformed, "what was flown is no JSON object"}; }

}  // namespace

std::string optionsToJson(const PlayerOptions& o) {
  if (o.is_steered) {
    Json json = toJson(ViewChoice{o.request, o.blend});
    json["steered"] = true;
    return textOf(json);
  }
  Json json = {{"request", toJson(o.request)},
               {"blend", name(o.blend)},
               {"announces_path", o.knowledge == PathKnowledge::kAnnounced},
               {"tour", o.tour},
               {"seconds", o.seconds},
               {"standing_us", o.standing.us},
               {"timeout_us", o.timeout.us},
               {"track_options", toJson(o.track_options)}};
  if (o.track) json["track"] = toJson(*o.track);
  if (o.scene) json["scene"] = {{"from_us", o.scene->scene_time.us}, {"rate", o.scene->rate}};
  return textOf(json);
}

std::string choiceToJson(const ViewChoice& choice) { return textOf(toJson(choice)); }

Result<PlayerOptions> optionsFromJson(const std::string& text) {
  constexpr int64_t kLongest_us = 86'400'000'000;
  const Json parsed = Json::parse(text, nullptr, false);
  if (!parsed.is_object()) return noObject();
  std::string wrong;
  Members json(parsed, wrong);
  PlayerOptions o;
  const ViewChoice choice = choiceFrom(json);
  o.request = choice.request;
  o.blend = choice.blend;
  o.is_steered = json.has("steered") && json.flag("steered");
  if (o.is_steered) {
    if (!wrong.empty()) return wrongly(wrong);
    return o;
  }
  o.knowledge = json.flag("announces_path") ? PathKnowledge::kAnnounced : PathKnowledge::kPrivate;
  o.tour = json.text("tour");
  o.seconds = json.number("seconds", 0, kMax);
  o.standing.us = json.integer<int64_t>("standing_us", 0, kLongest_us);
  o.timeout.us = json.integer<int64_t>("timeout_us", 0, kLongest_us);
  o.track_options = trackOptionsFrom(json.object("track_options"));
  if (json.has("track")) o.track = trackFrom(json.object("track"));
  if (json.has("scene")) {
    Members scene = json.object("scene");
    constexpr int64_t kMax_us = proto::Epochs::kMaxTime_us;
    o.scene = {{},
               Time{scene.integer<int64_t>("from_us", -kMax_us, kMax_us)},
               scene.number("rate", -proto::SceneClock::kMaxRate, proto::SceneClock::kMaxRate)};
  }
  if (!wrong.empty()) return wrongly(wrong);
  return o;
}

Result<ViewChoice> choiceFromJson(const std::string& text) {
  const Json parsed = Json::parse(text, nullptr, false);
  if (!parsed.is_object()) return noObject();
  std::string wrong;
  ViewChoice choice = choiceFrom(Members(parsed, wrong));
  if (!wrong.empty()) return wrongly(wrong);
  return choice;
}

}  // namespace foreland::client
