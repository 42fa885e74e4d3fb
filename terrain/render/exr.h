// Pictures as OpenEXR files, in memory: named channels of floats and whole numbers, lossless. The only place of
// terrain/render that knows OpenEXR. Any thread; OpenEXR compresses on threads of its own.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/render/picture.h"

namespace foreland::terrain {

struct ExrChannel {
  std::string name;                                                // "layer.channel", or only the channel's
  std::variant<std::vector<float>, std::vector<uint32_t>> values;  // row by row from the top, width * height of them
};

// What a picture's file holds: R, G, B (linear); depth.Z (metres); normal.X, normal.Y, normal.Z; id.node, id.object;
// and error.px if it was measured. See Picture.
std::vector<ExrChannel> channelsOf(const Picture& picture);

// ZIP-compressed scan lines. An Error if OpenEXR refuses.
[[nodiscard]] Result<Bytes> encodeExr(uint32_t width, uint32_t height, const std::vector<ExrChannel>& channels);

}  // namespace foreland::terrain
