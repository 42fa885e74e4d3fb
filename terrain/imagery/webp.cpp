#include "terrain/imagery/webp.h"

#include <webp/decode.h>
#include <webp/encode.h>

#include <string>

#include "base/check.h"

namespace foreland::terrain {

namespace {

constexpr int kTexels = static_cast<int>(proto::kTileSide);
constexpr size_t kPixels = size_t{proto::kTileSide} * proto::kTileSide;

}  // namespace

Result<Bytes> encodeTile(std::span<const Rgb> pixels, int quality) {
  CHECK_EQ(pixels.size(), kPixels);
  uint8_t* file = nullptr;
  const size_t size =
      WebPEncodeRGB(pixels.front().data(), kTexels, kTexels, kTexels * 3, static_cast<float>(quality), &file);
  const Bytes bytes(file, file + size);
  WebPFree(file);
  if (size == 0) return Error{ErrorCode::kLimit, "libwebp could not encode a tile; is memory short?"};
  return bytes;
}

Status decodeTile(ByteSpan bytes, std::span<Rgb> pixels) {
  CHECK_EQ(pixels.size(), kPixels);
  int width = 0, height = 0;
  const Error damaged{ErrorCode::kMalformed, "the picture of a tile is damaged"};
  if (!WebPGetInfo(bytes.data(), bytes.size(), &width, &height) || width != kTexels || height != kTexels)
    return damaged;
  if (WebPDecodeRGBInto(bytes.data(), bytes.size(), pixels.front().data(), pixels.size_bytes(), kTexels * 3) == nullptr)
    return damaged;
  return {};
}

}  // namespace foreland::terrain
