// KML 2.2 and Google's extensions (gx:Track), whatever the namespace prefix. Time and memory are linear in the file's
// size.
#include <algorithm>
#include <iterator>
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

struct Place {
  size_t line = 0;
  std::optional<RawFix> fix;
};

// Longitude, latitude and perhaps altitude.
std::optional<RawFix> fixOf(std::string_view text, std::string_view separators) {
  std::optional<double> numbers[3];
  for (std::optional<double>& number : numbers) {
    const size_t end = std::min(text.find_first_of(separators), text.size());
    number = decimal(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (!numbers[0] || !numbers[1]) return std::nullopt;
  return RawFix{.latitude_deg = *numbers[1], .longitude_deg = *numbers[0], .height_m = numbers[2]};
}

enum class Blanks : uint8_t { kSeparate, kJoinAtCommas };

// The length of the place that a text begins with.
size_t placeLength(std::string_view text, Blanks blanks) {
  size_t end = std::min(text.find_first_of(kBlanks), text.size());
  while (blanks == Blanks::kJoinAtCommas && end < text.size()) {
    const size_t next = text.find_first_not_of(kBlanks, end);
    if (next == text.npos || (text[end - 1] != ',' && text[next] != ',')) break;
    end = std::min(text.find_first_of(kBlanks, next), text.size());
  }
  return end;
}

std::vector<Place> placesIn(std::string_view text, size_t line, Blanks blanks) {
  std::vector<Place> places;
  const auto pass = [&](size_t length) {
    line += static_cast<size_t>(std::count(text.begin(), text.begin() + static_cast<ptrdiff_t>(length), '\n'));
    text.remove_prefix(length);
  };
  while (true) {
    pass(std::min(text.find_first_not_of(kBlanks), text.size()));
    if (text.empty()) return places;
    const size_t length = placeLength(text, blanks);
    places.push_back({line, fixOf(text.substr(0, length), ",")});
    pass(length);
  }
}

// Blanks separate places, commas the numbers of one; but people write blanks beside commas, too. So where places make
// no sense otherwise, such blanks do not separate.
std::vector<Place> placesIn(std::string_view text, size_t line) {
  const auto unusable = [](const std::vector<Place>& places) {
    return std::ranges::count_if(places, [](const Place& place) { return !place.fix.has_value(); });
  };
  std::vector<Place> places = placesIn(text, line, Blanks::kSeparate);
  if (unusable(places) == 0) return places;
  std::vector<Place> joined = placesIn(text, line, Blanks::kJoinAtCommas);
  return unusable(joined) < unusable(places) ? joined : places;
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
  void addGeometry(const pugi::xml_node& node) {
    ++geometries_;
    std::optional<double> time_s;
    if (wanted_ == Wanted::kPoints) time_s = timeOfPoint(node.parent());
    std::vector<Place> places;
    // Comments and CDATA cut the text into parts.
    for (const pugi::xml_node& part : childNamed(node, "coordinates").children())
      if (part.type() == pugi::node_pcdata || part.type() == pugi::node_cdata)
        std::ranges::move(placesIn(part.value(), lines_.at(part.offset_debug())), std::back_inserter(places));
    for (Place& place : places)
      if (place.fix) place.fix->time_s = time_s;
    addPlaces(places, node);
  }
  static std::optional<double> timeOfPoint(const pugi::xml_node& placemark) {
    const pugi::xml_node stamp = childNamed(placemark, "TimeStamp");
    return timeOf(stamp ? childNamed(stamp, "when").child_value()
                        : childNamed(childNamed(placemark, "TimeSpan"), "begin").child_value());
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
