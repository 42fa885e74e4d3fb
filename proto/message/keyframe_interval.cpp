#include "proto/message/keyframe_interval.h"

#include <charconv>
#include <optional>

namespace foreland::proto {

namespace {

// Whole milliseconds within the bounds.
std::optional<Duration> millisecondsFrom(std::string_view text) {
  int64_t ms = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ms);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (ms < KeyframeInterval::kMin.us / 1000 || ms > KeyframeInterval::kMax.us / 1000) return std::nullopt;
  return Duration::milliseconds(ms);
}

}  // namespace

Result<KeyframeInterval> keyframeIntervalFrom(std::string_view text) {
  if (text == "adaptive") return kAdaptiveInterval;
  const size_t dash = text.find('-');
  const auto shortest = millisecondsFrom(text.substr(0, dash));
  if (shortest && dash == std::string_view::npos) return KeyframeInterval{*shortest, {}};
  const auto longest = dash == std::string_view::npos ? std::nullopt : millisecondsFrom(text.substr(dash + 1));
  if (shortest && longest && *longest > *shortest) return KeyframeInterval{*shortest, *longest};
  return Error{ErrorCode::kInvalidArgument,
               "a keyframe interval is 20 to 10000 ms, two of them with a dash between "
               "(100-500), or adaptive; not " +
                   std::string(text.substr(0, 40))};
}

std::string textOf(const KeyframeInterval& interval) {
  if (interval == kAdaptiveInterval) return "adaptive";
  const std::string shortest = std::to_string(interval.shortest.us / 1000);
  return interval.isAdaptive() ? shortest + "-" + std::to_string(interval.longest.us / 1000) : shortest;
}

}  // namespace foreland::proto
