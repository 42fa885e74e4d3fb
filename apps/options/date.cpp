#include "apps/options/date.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "proto/section/epochs.h"

namespace foreland::apps {

namespace {

using Microseconds = std::chrono::microseconds;

}  // namespace

std::optional<Time> parseDate(const std::string& text) {
  int year = 0, end = 0;
  unsigned month = 0, day = 0;
  if (std::sscanf(text.c_str(), "%4d-%2u-%2u%n", &year, &month, &day, &end) != 3 ||
      static_cast<size_t>(end) != text.size())
    return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month), std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  return Time{std::chrono::duration_cast<Microseconds>(std::chrono::sys_days(date).time_since_epoch()).count()};
}

std::string dateText(Time time) {
  const std::chrono::sys_time<Microseconds> at{Microseconds(time.us)};
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(at));
  char text[32];
  std::snprintf(text, sizeof(text), "%04d-%02u-%02u", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
  return text;
}

Result<Time> parseDateOption(const std::string& text, const std::string& scene, const proto::Epochs& epochs) {
  const auto date = parseDate(text);
  if (!date) return Error{ErrorCode::kInvalidArgument, "--date '" + text + "': write YYYY-MM-DD"};
  if (epochs.empty())
    return Error{ErrorCode::kInvalidArgument, scene + ": does not change in time, so there is no --date"};
  return *date;
}

std::optional<double> parseSceneSpeed(const std::string& text) {
  static const std::map<std::string, double> kUnits{
      {"s/s", 1}, {"h/s", 3600}, {"d/s", 86'400}, {"y/s", 365.25 * 86'400}};
  char* end = nullptr;
  const double count = std::strtod(text.c_str(), &end);
  const auto unit = kUnits.find(end);
  if (end == text.c_str() || unit == kUnits.end()) return std::nullopt;
  const double rate = count * unit->second;
  if (!(std::fabs(rate) <= proto::SceneClock::kMaxRate)) return std::nullopt;
  return rate;
}

Result<std::optional<proto::SceneClock>> parseSceneClock(const std::optional<std::string>& from,
                                                         const std::optional<std::string>& speed) {
  if (!from && !speed) return std::optional<proto::SceneClock>();
  const auto invalid = [](std::string message) { return Error{ErrorCode::kInvalidArgument, std::move(message)}; };
  proto::SceneClock clock{.at = {}, .scene_time = {-proto::Epochs::kMaxTime_us}, .rate = 0};
  if (from) {
    const auto date = parseDate(*from);
    if (!date) return invalid("--scene-from " + *from + ": write a date as YYYY-MM-DD");
    clock.scene_time = *date;
  }
  if (speed) {
    const auto rate = parseSceneSpeed(*speed);
    if (!rate) return invalid("--scene-speed " + *speed + ": write for example 90d/s, -12h/s or 1y/s");
    clock.rate = *rate;
  }
  return std::optional(clock);
}

}  // namespace foreland::apps
