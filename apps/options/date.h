// Dates and speeds of scene time on command lines and in reports. Dates are days of the Gregorian calendar, UTC. Pure;
// any thread.
#pragma once

#include <optional>
#include <string>

#include "base/result.h"
#include "base/time.h"
#include "proto/section/epochs.h"

namespace foreland::apps {

// Midnight of YYYY-MM-DD, since 1970; nothing if the text is no date.
std::optional<Time> parseDate(const std::string& text);
std::string dateText(Time time);
// What --date asks for in a scene of such a name and epochs. An Error if it is no date, or the scene does not change.
Result<Time> parseDateOption(const std::string& text, const std::string& scene, const proto::Epochs& epochs);

// Scene seconds a second, of a text like 90d/s; units are s, h, d and y (of 365.25 days).
std::optional<double> parseSceneSpeed(const std::string& text);

// What --scene-from and --scene-speed ask for, at the flight's own time 0: without the first from before all dates,
// without the second at rest. Nothing if neither is given; an Error that names the option.
Result<std::optional<proto::SceneClock>> parseSceneClock(const std::optional<std::string>& from,
                                                         const std::optional<std::string>& speed);

}  // namespace foreland::apps
