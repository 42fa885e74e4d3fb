// KML 2.2 and Google's extensions (gx:Track), whatever the namespace prefix. Time and memory are linear in the file's
// size.
#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "client/fly/tracks/point_text.h"
#include "client/fly/tracks/track.h"
#include "client/fly/tracks/track_builder.h"
#include "client/fly/tracks/xml_text.h"

namespace foreland::client {

namespace {

constexpr std::string_view kBlanks = " \t\r\n";

pugi::xml_node childNamed(const pugi::xml_node& node, std::string_view name) {
  return node.find_child([&](const pugi::xml_node& child) { return localName(child) == name; });
}

enum class Wanted : uint8_t { kLines, kPoints };

// Adds the coordinates of all lines, or of all points, in document order.
class PlaceReader final : public pugi::xml_tree_walker {
 public:
  PlaceReader(std::string_view text, Wanted wanted, TrackBuilder& builder)
      : lines_(text), wanted_(wanted), builder_(builder) {}

  bool for_each(pugi::xml_node& node) override {
    const std::string_view name = localName(node);
    const bool is_wanted = wanted_ == Wanted::kPoints ? name == "Point" : name == "LineString";
    if (is_wanted) addGeometry(node);
    if (wanted_ == Wanted::kLines && name == "Track") addTrack(node);
    return !builder_.isFull();
  }
  size_t geometries() const { return geometries_; }
  size_t aboveGround() const { return above_ground_; }

 private:
  struct Place {
    size_t line = 0;
    std::optional<RawFix> fix;
  };

  void addGeometry(const pugi::xml_node& node) {
    ++geometries_;
    const pugi::xml_node coordinates = childNamed(node, "coordinates");
    std::optional<double> time_s;
    if (wanted_ == Wanted::kPoints)
      time_s = timeOf(childNamed(childNamed(node.parent(), "TimeStamp"), "when").child_value());
    std::string_view text = coordinates.child_value();
    size_t line = lines_.at(coordinates.first_child().offset_debug());
    std::vector<Place> places;
    while (!text.empty()) {
      const size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
      line += static_cast<size_t>(std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(begin), '\n'));
      text.remove_prefix(begin);
      const size_t end = std::min(text.find_first_of(kBlanks), text.size());
      if (end > 0) places.push_back({line, fixOf(text.substr(0, end), ",")});
      text.remove_prefix(end);
      if (!places.empty() && places.back().fix) places.back().fix->time_s = time_s;
    }
    addPlaces(places, node);
  }
  // Times and places stand in lists of their own.
  void addTrack(const pugi::xml_node& node) {
    ++geometries_;
    std::vector<std::optional<double>> times;
    std::vector<Place> places;
    for (const pugi::xml_node& child : node.children()) {
      if (localName(child) == "when") times.push_back(timeOf(child.child_value()));
      if (localName(child) == "coord")
        places.push_back({lines_.at(child.offset_debug()), fixOf(trimmed(child.child_value()), kBlanks)});
    }
    for (size_t i = 0; i < places.size() && i < times.size(); ++i)
      if (places[i].fix) places[i].fix->time_s = times[i];
    addPlaces(places, node);
  }

  // Longitude, latitude and perhaps altitude.
  static std::optional<RawFix> fixOf(std::string_view text, std::string_view separators) {
    std::optional<double> numbers[3];
    for (std::optional<double>& number : numbers) {
      const size_t end = std::min(text.find_first_of(separators), text.size());
      number = decimal(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (!numbers[0] || !numbers[1]) return std::nullopt;
    return RawFix{.latitude_deg = *numbers[1], .longitude_deg = *numbers[0], .height_m = numbers[2]};
  }
  // Without a mode altitudes have no meaning, but programs that export recorded ones forget it; those who draw lines
  // write 0.
  void addPlaces(std::vector<Place>& places, const pugi::xml_node& node) {
    const std::string_view mode = trimmed(childNamed(node, "altitudeMode").child_value());
    const bool is_level =
        std::ranges::all_of(places, [](const Place& p) { return !p.fix || p.fix->height_m.value_or(0) == 0; });
    const bool is_used = mode == "absolute" || (mode.empty() && !is_level);
    if (mode == "relativeToGround") ++above_ground_;
    for (Place& place : places) {
      if (!place.fix) {
        builder_.skip(place.line, "point without longitude and latitude");
        continue;
      }
      if (!is_used) place.fix->height_m = std::nullopt;
      builder_.add(place.line, *place.fix);
    }
  }

  LineCounter lines_;
  Wanted wanted_;
  TrackBuilder& builder_;
  size_t geometries_ = 0, above_ground_ = 0;
};

}  // namespace

Result<Track> parseKml(std::string_view text, const std::string& name) {
  pugi::xml_document document;
  if (Status status = loadXml(text, name, document); !status.ok()) return status.error();
  TrackBuilder builder(name);
  PlaceReader lines(text, Wanted::kLines, builder), points(text, Wanted::kPoints, builder);
  document.traverse(lines);
  if (lines.geometries() == 0) document.traverse(points);
  if (points.geometries() > 0)
    builder.note("has no line; its " + std::to_string(points.geometries()) +
                 " points are flown in the order of the file");
  if (lines.geometries() > 1)
    builder.note(std::to_string(lines.geometries()) + " lines flown one after another, in the order of the file");
  if (lines.aboveGround() + points.aboveGround() > 0)
    builder.note("heights above the ground left out; --agl M flies above the ground");
  return std::move(builder).finish("a KML");
}

}  // namespace foreland::client
