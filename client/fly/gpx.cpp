// GPX 1.0 and 1.1, whatever the namespace prefix. A file that is not well-formed XML is an Error that names the line; a
// point that is not what it should be is skipped, with a note that names its line. Time and memory are linear in the
// file's size.
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <pugixml.hpp>

#include "client/fly/track.h"
#include "client/fly/track_builder.h"

namespace foreland::client {

namespace {

std::string_view trimmed(std::string_view s) {
  const size_t first = s.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t\r\n") - first + 1);
}

std::optional<double> decimal(std::string_view text) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

// The unsigned number that `length` characters at `at` spell.
std::optional<unsigned> digitsAt(std::string_view text, size_t at, size_t length) {
  if (text.size() < at + length) return std::nullopt;
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data() + at, text.data() + at + length, value);
  if (error != std::errc{} || end != text.data() + at + length) return std::nullopt;
  return value;
}

// YYYY-MM-DD as days since 1970-01-01.
std::optional<std::chrono::sys_days> dateOf(std::string_view text) {
  const auto year = digitsAt(text, 0, 4), month = digitsAt(text, 5, 2), day = digitsAt(text, 8, 2);
  if (!year || !month || !day || text[4] != '-' || text[7] != '-') return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(*year)), std::chrono::month(*month),
                                         std::chrono::day(*day)};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

// Z, +hh:mm or -hh:mm as what it is ahead of UTC; no zone means UTC.
std::optional<std::chrono::minutes> zoneOf(std::string_view text) {
  if (text.empty() || text == "Z") return std::chrono::minutes(0);
  const auto hours = digitsAt(text, 1, 2), minutes = digitsAt(text, 4, 2);
  if (!hours || !minutes || text.size() != 6 || text[3] != ':' || *hours > 23 || *minutes > 59) return std::nullopt;
  const std::chrono::minutes ahead = std::chrono::hours(*hours) + std::chrono::minutes(*minutes);
  return text[0] == '-' ? -ahead : ahead;
}

// YYYY-MM-DDThh:mm:ss[.fff][Z|+hh:mm|-hh:mm], as seconds since 1970.
std::optional<double> timeOf(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 19 || text[10] != 'T' || text[13] != ':' || text[16] != ':') return std::nullopt;
  const auto date = dateOf(text);
  const auto hour = digitsAt(text, 11, 2), minute = digitsAt(text, 14, 2);
  const size_t zone_at = std::min(text.find_first_of("Z+-", 17), text.size());
  const auto second = decimal(text.substr(17, zone_at - 17));
  const auto zone = zoneOf(text.substr(zone_at));
  if (!date || !hour || !minute || !second || !zone || *hour > 24 || *minute > 59 || *second < 0 || *second >= 61)
    return std::nullopt;
  const std::chrono::sys_seconds time = *date + std::chrono::hours(*hour) + std::chrono::minutes(*minute) - *zone;
  return static_cast<double>(time.time_since_epoch().count()) + *second;
}

// An element's name without its namespace prefix.
std::string_view localName(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// The line that an offset is on. Offsets ascend from call to call, so all calls together read the text once.
class LineCounter {
 public:
  explicit LineCounter(std::string_view text) : text_(text) {}
  size_t at(ptrdiff_t offset) {
    const size_t end = std::clamp<size_t>(offset < 0 ? 0 : static_cast<size_t>(offset), at_, text_.size());
    line_ += static_cast<size_t>(
        std::count(text_.begin() + static_cast<ptrdiff_t>(at_), text_.begin() + static_cast<ptrdiff_t>(end), '\n'));
    at_ = end;
    return line_;
  }

 private:
  std::string_view text_;
  size_t at_ = 0, line_ = 1;
};

// Adds all elements with one name to a builder, in document order. pugixml walks without recursion, so depth is no
// danger.
class PointReader final : public pugi::xml_tree_walker {
 public:
  PointReader(std::string_view text, std::string_view point_tag, TrackBuilder& builder)
      : lines_(text), point_tag_(point_tag), builder_(builder) {}

  bool for_each(pugi::xml_node& node) override {
    if (localName(node) == point_tag_) add(node);
    return !builder_.isFull();
  }
  size_t points() const { return points_; }

 private:
  void add(const pugi::xml_node& node) {
    ++points_;
    const size_t line = lines_.at(node.offset_debug());
    const auto latitude = decimal(node.attribute("lat").value()), longitude = decimal(node.attribute("lon").value());
    if (!latitude || !longitude) return builder_.skip(line, "point without latitude and longitude");
    RawFix fix{.latitude_deg = *latitude, .longitude_deg = *longitude};
    for (const pugi::xml_node& child : node.children()) {
      const std::string_view name = localName(child);
      if (name == "ele" && !(fix.height_m = decimal(child.child_value())))
        return builder_.skip(line, "height is not a number");
      if (name == "time" && !(fix.time_s = timeOf(child.child_value())))
        return builder_.skip(line, "time is not a date and time");
    }
    builder_.add(line, fix);
  }

  LineCounter lines_;
  std::string_view point_tag_;
  TrackBuilder& builder_;
  size_t points_ = 0;
};

}  // namespace

Result<Track> parseGpx(std::string_view text, const std::string& name) {
  pugi::xml_document document;
  if (const auto parsed = document.load_buffer(text.data(), text.size()); !parsed)
    return Error{ErrorCode::kMalformed, name + ":" + std::to_string(LineCounter(text).at(parsed.offset)) +
                                            ": is no well-formed XML: " + parsed.description()};
  TrackBuilder builder(name);
  PointReader track(text, "trkpt", builder), route(text, "rtept", builder);
  document.traverse(track);
  if (track.points() == 0) document.traverse(route);
  return std::move(builder).finish("a GPX");
}

}  // namespace foreland::client
