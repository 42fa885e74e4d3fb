// Pictures for pages: PNG, eight bits a channel. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace foreland::server {

struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<std::array<uint8_t, 3>> pixels{};  // red, green, blue; row by row from above
};

// The file. `picture` has pixels.
std::string encodePng(const Picture& picture);

}  // namespace foreland::server
