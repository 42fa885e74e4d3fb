// What a server has counted, from its /metrics.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"

namespace foreland::lab {

struct ServerCounts {
  double keyframes = 0, late_keyframes = 0, cpu_s = 0;
};

// Of the page's text. An Error names a figure that is missing.
Result<ServerCounts> parseCounts(const std::string& page);
// Asks the server at this port of 127.0.0.1. Blocks.
Result<ServerCounts> readCounts(uint16_t port);

}  // namespace foreland::lab
