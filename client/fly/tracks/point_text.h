// Numbers and times as text formats of tracks write them. Pure; any thread.
#pragma once

#include <optional>
#include <string_view>

namespace foreland::client {

// Without white space at its ends.
std::string_view trimmed(std::string_view text);

// A finite number, perhaps with white space around it.
std::optional<double> decimal(std::string_view text);

// YYYY-MM-DDThh:mm:ss[.fff][Z|+hh:mm|-hh:mm], as seconds since 1970.
std::optional<double> timeOf(std::string_view text);

}  // namespace foreland::client
