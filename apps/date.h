// Dates and speeds of scene time on command lines and in reports. Dates are days of the Gregorian calendar, UTC. Pure;
// any thread.
#pragma once

#include <optional>
#include <string>

#include "base/time.h"

namespace foreland::apps {

// Midnight of YYYY-MM-DD, since 1970; nothing if the text is no date.
std::optional<Time> parseDate(const std::string& text);
std::string dateText(Time time);

// Scene seconds a second, of a text like 90d/s; units are s, h, d and y (of 365.25 days).
std::optional<double> parseSceneSpeed(const std::string& text);

}  // namespace foreland::apps
