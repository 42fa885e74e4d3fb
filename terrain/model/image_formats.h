// A decoder for each format of images, each alone with its library. Errors do not name the file. Any thread.
#pragma once

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/image.h"

namespace foreland::terrain {

[[nodiscard]] Result<Image> decodePng(ByteSpan bytes);
[[nodiscard]] Result<Image> decodeJpeg(ByteSpan bytes);
[[nodiscard]] Result<Image> decodeWebp(ByteSpan bytes);

// Error: more than kMaxImagePixels, or none.
[[nodiscard]] Status checkImageSize(uint64_t width, uint64_t height);

}  // namespace foreland::terrain
