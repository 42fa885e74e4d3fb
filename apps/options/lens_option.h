// --viewport and --fov, which several programs have. Header only; main thread.
#pragma once

#include <charconv>
#include <string>

#include "base/result.h"
#include "proto/space/pose.h"

namespace foreland::apps {

// `viewport` is WIDTHxHEIGHT.
inline Result<proto::Lens> parseLens(const std::string& viewport, double fov_deg) {
  const auto refuse = [](std::string message) { return Error{ErrorCode::kInvalidArgument, std::move(message)}; };
  proto::Lens lens{.vertical_fov_rad = fov_deg * 0.017453292519943295};
  const char *begin = viewport.data(), *end = begin + viewport.size();
  const auto [cross, width_error] = std::from_chars(begin, end, lens.width_px);
  if (width_error != std::errc{} || cross == end || *cross != 'x')
    return refuse("--viewport '" + viewport + "': write WIDTHxHEIGHT in pixels");
  const auto [last, height_error] = std::from_chars(cross + 1, end, lens.height_px);
  if (height_error != std::errc{} || last != end)
    return refuse("--viewport '" + viewport + "': write WIDTHxHEIGHT in pixels");
  if (!proto::isUsable(lens)) return refuse("--fov must be 1 to 170 degrees, --viewport 1x1 to 16384x16384 pixels");
  return lens;
}

}  // namespace foreland::apps
