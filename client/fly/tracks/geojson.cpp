// GeoJSON (RFC 7946) and sequences of it (RFC 8142): the lines of its geometries, features and collections. Time and
// memory are linear in the file's size.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/fly/tracks/point_text.h"
#include "client/fly/tracks/track.h"
#include "client/fly/tracks/track_builder.h"

namespace foreland::client {

namespace {

using nlohmann::json;

const json& member(const json& object, const char* name) {
  static const json kNone;
  if (!object.is_object()) return kNone;
  const auto found = object.find(name);
  return found == object.end() ? kNone : *found;
}

bool isType(const json& object, const char* type) { return member(object, "type") == type; }

class LineReader {
 public:
  explicit LineReader(TrackBuilder& builder) : builder_(builder) {}

  // Adds the lines of an object and of all that it holds; its points instead, if `wants_points`.
  void add(const json& root, bool wants_points) {
    struct Waiting {
      const json* object;
      const json* times;  // of the feature
    };
    std::vector<Waiting> waiting{{&root, nullptr}};
    while (!waiting.empty() && !builder_.isFull()) {
      const auto [object, times] = waiting.back();
      waiting.pop_back();
      const json& parts = member(*object, isType(*object, "FeatureCollection") ? "features" : "geometries");
      if (parts.is_array())
        for (auto part = parts.rbegin(); part != parts.rend(); ++part) waiting.push_back({&*part, times});
      if (isType(*object, "Feature")) waiting.push_back({&member(*object, "geometry"), &timesOf(*object)});
      addGeometry(*object, times, wants_points);
    }
  }
  size_t lines() const { return lines_; }
  size_t points() const { return points_; }

 private:
  // Where togeojson and its successors write them.
  static const json& timesOf(const json& feature) {
    const json& properties = member(feature, "properties");
    const json& newer = member(member(properties, "coordinateProperties"), "times");
    return newer.is_null() ? member(properties, "coordTimes") : newer;
  }
  void addGeometry(const json& geometry, const json* times, bool wants_points) {
    const json& coordinates = member(geometry, "coordinates");
    const auto timesOfLine = [&](size_t line) -> const json* {
      return times && times->is_array() && line < times->size() ? &(*times)[line] : nullptr;
    };
    if (wants_points) {
      if (isType(geometry, "Point")) ++lines_, addPoint(coordinates, nullptr);
      if (isType(geometry, "MultiPoint")) addLine(coordinates, nullptr);
    } else if (isType(geometry, "LineString")) {
      addLine(coordinates, times);
    } else if (isType(geometry, "MultiLineString") && coordinates.is_array()) {
      for (size_t i = 0; i < coordinates.size(); ++i) addLine(coordinates[i], timesOfLine(i));
    }
  }
  void addLine(const json& coordinates, const json* times) {
    ++lines_;
    if (!coordinates.is_array()) return;
    for (size_t i = 0; i < coordinates.size() && !builder_.isFull(); ++i)
      addPoint(coordinates[i], times && times->is_array() && i < times->size() ? &(*times)[i] : nullptr);
  }
  void addPoint(const json& at, const json* time) {
    ++points_;
    const auto number = [&](size_t i) {
      return at.is_array() && i < at.size() && at[i].is_number() ? std::optional(at[i].get<double>()) : std::nullopt;
    };
    if (!number(0) || !number(1)) return builder_.skip(points_, "no longitude and latitude");
    RawFix fix{.latitude_deg = *number(1), .longitude_deg = *number(0), .height_m = number(2)};
    if (time && time->is_string()) fix.time_s = timeOf(time->get<std::string>());
    if (time && time->is_number()) fix.time_s = time->get<double>() / 1000;
    builder_.add(points_, fix);
  }

  TrackBuilder& builder_;
  size_t lines_ = 0, points_ = 0;
};

// The object that a whole text is; null if it is none.
json objectIn(std::string_view text) {
  constexpr auto kNoCallback = nullptr;
  constexpr bool kThrows = false;
  json object = json::parse(text.begin(), text.end(), kNoCallback, kThrows);
  return object.is_object() ? object : json();
}

// The objects of a sequence as one collection: each behind a mark (RFC 8142), or each on a line of its own. Null if the
// first is no object. What is broken is noted: a sequence may be cut short by what wrote it.
json sequenceIn(std::string_view text, TrackBuilder& builder) {
  constexpr char kMark = '\x1e';
  const size_t first = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  const char separator = text.substr(first).starts_with(kMark) ? kMark : '\n';
  json features = json::array();
  size_t broken = 0;
  for (text.remove_prefix(first); !text.empty();) {
    const size_t end = std::min(text.find(separator), text.size());
    const std::string_view part = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (part.empty()) continue;
    json object = objectIn(part);
    if (object.is_null() && features.empty()) return {};
    if (object.is_null())
      ++broken;
    else
      features.push_back(std::move(object));
  }
  if (features.empty()) return {};
  if (broken > 0) builder.note(std::to_string(broken) + " objects of the sequence are broken; left out");
  return {{"type", "FeatureCollection"}, {"features", std::move(features)}};
}

}  // namespace

Result<Track> parseGeoJson(std::string_view text, const std::string& name) {
  TrackBuilder builder(name);
  builder.callPlaces("point");
  json root = objectIn(text);
  if (root.is_null()) root = sequenceIn(text, builder);
  if (root.is_null()) return Error{ErrorCode::kMalformed, name + ": its JSON is broken; export it again"};
  LineReader lines(builder), points(builder);
  lines.add(root, false);
  if (lines.lines() == 0) points.add(root, true);
  if (points.points() > 0)
    builder.note("has no line; its " + std::to_string(points.points()) + " points are flown in the order of the file");
  if (lines.lines() > 1)
    builder.note(std::to_string(lines.lines()) + " lines flown one after another, in the order of the file");
  return std::move(builder).finish("a GeoJSON");
}

}  // namespace foreland::client
