// GPX 1.0 and 1.1: a scanner of just as much XML as the format needs. It never backtracks, keeps no tree, knows no
// entities, and reads any bytes in time linear in their number.
#include <charconv>
#include <cmath>
#include <optional>

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

// Days from 1970-01-01 in the Gregorian calendar (Hinnant's formula).
int64_t daysFromCivil(int64_t year, int64_t month, int64_t day) {
  year -= month <= 2;
  const int64_t era = (year >= 0 ? year : year - 399) / 400, yoe = year - era * 400;
  const int64_t doy = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return era * 146'097 + yoe * 365 + yoe / 4 - yoe / 100 + doy - 719'468;
}

// YYYY-MM-DDThh:mm:ss[.fff][Z|+hh:mm|-hh:mm], as seconds since 1970.
std::optional<double> timeOf(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 19 || text[4] != '-' || text[7] != '-' || text[10] != 'T' || text[13] != ':' || text[16] != ':')
    return std::nullopt;
  const auto field = [&](size_t at, size_t length) -> std::optional<int> {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data() + at, text.data() + at + length, value);
    if (error != std::errc{} || end != text.data() + at + length || value < 0) return std::nullopt;
    return value;
  };
  const auto year = field(0, 4), month = field(5, 2), day = field(8, 2), hour = field(11, 2), minute = field(14, 2);
  if (!year || !month || !day || !hour || !minute) return std::nullopt;
  const size_t zone = text.find_first_of("Z+-", 17);
  const auto second = decimal(text.substr(17, zone == std::string_view::npos ? zone : zone - 17));
  if (!second || *second < 0 || *second >= 61 || *month < 1 || *month > 12 || *day < 1 || *day > 31 || *hour > 24 ||
      *minute > 59)
    return std::nullopt;
  double offset_s = 0;
  if (zone != std::string_view::npos && text[zone] != 'Z' && text.size() >= zone + 6) {
    const auto zh = field(zone + 1, 2), zm = field(zone + 4, 2);
    if (!zh || !zm) return std::nullopt;
    offset_s = (text[zone] == '-' ? -1 : 1) * (*zh * 3600.0 + *zm * 60.0);
  }
  return static_cast<double>(daysFromCivil(*year, *month, *day)) * 86'400 + *hour * 3600.0 + *minute * 60.0 + *second -
         offset_s;
}

// The value of ` name="..."` or ` name='...'` in a tag's inside.
std::optional<std::string_view> attribute(std::string_view tag, std::string_view name) {
  for (size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    if (at == 0 || std::string_view(" \t\r\n").find(tag[at - 1]) == std::string_view::npos) continue;
    size_t value = tag.find_first_not_of(" \t\r\n", at + name.size());
    if (value == std::string_view::npos || tag[value] != '=') continue;
    value = tag.find_first_not_of(" \t\r\n", value + 1);
    if (value == std::string_view::npos || (tag[value] != '"' && tag[value] != '\'')) continue;
    const size_t end = tag.find(tag[value], value + 1);
    if (end == std::string_view::npos) return std::nullopt;
    return tag.substr(value + 1, end - value - 1);
  }
  return std::nullopt;
}

// Walks through the markup, tag by tag.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  // The inside of the next tag, without the angle brackets; comments and CDATA are passed over. False at the end.
  bool next(std::string_view& tag, std::string_view& text_before) {
    text_before = {};
    while (true) {
      const size_t open = text_.find('<', at_);
      if (open == std::string_view::npos) return false;
      text_before = text_.substr(at_, open - at_);
      advanceTo(open);
      if (passOver("<!--", "-->") || passOver("<![CDATA[", "]]>")) continue;
      const size_t close = text_.find('>', open);
      if (close == std::string_view::npos) return false;
      tag = text_.substr(open + 1, close - open - 1);
      line_of_tag_ = line_;
      advanceTo(close + 1);
      return true;
    }
  }
  size_t line() const { return line_of_tag_; }

 private:
  bool passOver(std::string_view begin, std::string_view end) {
    if (text_.substr(at_, begin.size()) != begin) return false;
    const size_t close = text_.find(end, at_ + begin.size());
    advanceTo(close == std::string_view::npos ? text_.size() : close + end.size());
    return true;
  }
  void advanceTo(size_t to) {
    for (; at_ < to; ++at_) line_ += text_[at_] == '\n';
  }

  std::string_view text_;
  size_t at_ = 0, line_ = 1, line_of_tag_ = 1;
};

class GpxReader {
 public:
  GpxReader(std::string_view text, TrackBuilder& builder) : scanner_(text), builder_(builder) {}

  void read(std::string_view point_tag) {
    std::string_view tag, text;
    while (!builder_.isFull() && scanner_.next(tag, text)) onTag(tag, text, point_tag);
    if (open_) builder_.skip(open_line_, "point is not closed");
  }
  size_t points() const { return points_; }

 private:
  void onTag(std::string_view tag, std::string_view text, std::string_view point_tag) {
    const bool closes = !tag.empty() && tag.front() == '/';
    if (closes) tag.remove_prefix(1);
    std::string_view name = tag.substr(0, tag.find_first_of(" \t\r\n/"));
    if (const size_t colon = name.find(':'); colon != std::string_view::npos) name.remove_prefix(colon + 1);
    if (name == point_tag) return closes ? close() : open(tag);
    if (!open_ || !closes) return;
    if (name == "ele") {
      open_->height_m = decimal(text);
      if (!open_->height_m) fault_ = "height is not a number";
    }
    if (name == "time") {
      open_->time_s = timeOf(text);
      if (!open_->time_s) fault_ = "time is not a date and time";
    }
  }
  void open(std::string_view tag) {
    if (open_) builder_.skip(open_line_, "point is not closed");
    ++points_;
    open_line_ = scanner_.line();
    fault_ = {};
    open_.reset();
    const auto lat = attribute(tag, "lat"), lon = attribute(tag, "lon");
    const auto latitude = lat ? decimal(*lat) : std::nullopt, longitude = lon ? decimal(*lon) : std::nullopt;
    if (!latitude || !longitude) return builder_.skip(open_line_, "point without latitude and longitude");
    open_ = RawFix{.latitude_deg = *latitude, .longitude_deg = *longitude};
    if (tag.back() == '/') close();
  }
  void close() {
    if (!open_) return;
    if (!fault_.empty())
      builder_.skip(open_line_, fault_);
    else
      builder_.add(open_line_, *open_);
    open_.reset();
  }

  Scanner scanner_;
  TrackBuilder& builder_;
  std::optional<RawFix> open_;
  std::string_view fault_;
  size_t open_line_ = 0;
  size_t points_ = 0;
};

}  // namespace

Result<Track> parseGpx(std::string_view text, const std::string& name) {
  TrackBuilder builder(name);
  GpxReader track(text, builder);
  track.read("trkpt");
  if (track.points() == 0) GpxReader(text, builder).read("rtept");
  return std::move(builder).finish("a GPX");
}

}  // namespace foreland::client
