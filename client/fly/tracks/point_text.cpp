#include "client/fly/tracks/point_text.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

namespace foreland::client {

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

namespace {

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

}  // namespace

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

}  // namespace foreland::client
