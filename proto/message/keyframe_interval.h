// How far apart keyframes fall: always as far, or adaptively between two bounds. As people write it: `200`, in
// milliseconds; `100-500`, adaptive between the two; `adaptive`, between the usual bounds. Value type; any thread.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "base/time.h"

namespace foreland::proto {

struct KeyframeInterval {
  static constexpr Duration kMin = Duration::milliseconds(20), kMax = Duration::milliseconds(10'000);

  Duration shortest = Duration::milliseconds(200);  // and the only one, unless `longest` is larger
  Duration longest{};                               // 0: the interval is fixed

  bool isAdaptive() const { return longest > shortest; }
  // Between two keyframes, unless some are skipped.
  Duration most() const { return isAdaptive() ? longest : shortest; }
  bool operator==(const KeyframeInterval&) const = default;
};

// What `adaptive` means (docs/decisions/0041).
inline constexpr KeyframeInterval kAdaptiveInterval{Duration::milliseconds(100), Duration::milliseconds(1000)};

// Errors name the text and what is expected.
Result<KeyframeInterval> keyframeIntervalFrom(std::string_view text);
// The shortest text that means the same.
std::string textOf(const KeyframeInterval& interval);

}  // namespace foreland::proto
