#include "proto/imagery/tile.h"

#include <cmath>

namespace foreland::proto {

Status TileLayer::validate() const {
  const auto wrong = [](const char* what) {
    return Error{ErrorCode::kMalformed, std::string("a layer of tiles ") + what};
  };
  const bool is_relief = content == TileContent::kRelief && coding == TileCoding::kHeights;
  const bool is_imagery = content == TileContent::kImagery && coding == TileCoding::kWebP;
  if (!is_relief && !is_imagery) return wrong("is of an unknown content or coding");
  if (width == 0 || height == 0 || width > kMaxLayerSide || height > kMaxLayerSide || levels() > kMaxTileLevels)
    return wrong("has no texels or too many");
  const double largest = 1e9;
  if (!(std::abs(origin.x) <= largest && std::abs(origin.y) <= largest)) return wrong("lies nowhere");
  if (!(texel >= 1e-6 && texel <= 1e6)) return wrong("has texels of an absurd size");
  if (is_relief && !(step_m >= 1e-6 && step_m <= 1e4)) return wrong("has an absurd step of height");
  if (isGlobe() && (width != height || width % (1u << faceBits(0)) != 0 || origin != glm::dvec2(0) ||
                    !(std::abs(texel * width - face_steps) <= 1e-6 * face_steps)))
    return wrong("does not fill the faces of the globe");
  return {};
}

}  // namespace foreland::proto
