#include <webp/decode.h>

#include "terrain/model/image_formats.h"

namespace foreland::terrain {

Result<Image> decodeWebp(ByteSpan bytes) {
  const Error damaged{ErrorCode::kMalformed, "not a readable WebP image; convert it again"};
  WebPBitstreamFeatures about;
  if (WebPGetFeatures(bytes.data(), bytes.size(), &about) != VP8_STATUS_OK || about.width < 0 || about.height < 0)
    return damaged;
  if (about.has_animation != 0) return Error{ErrorCode::kUnsupported, "a moving WebP image; convert it to one picture"};
  const auto width = static_cast<uint32_t>(about.width), height = static_cast<uint32_t>(about.height);
  if (Status status = checkImageSize(width, height); !status.ok()) return status.error();
  Image image{width, height, std::vector<Colour>(uint64_t{width} * height)};
  const size_t size = image.pixels.size() * sizeof(Colour);
  const int stride = about.width * static_cast<int>(sizeof(Colour));
  auto* out = reinterpret_cast<uint8_t*>(image.pixels.data());
  if (WebPDecodeRGBAInto(bytes.data(), bytes.size(), out, size, stride) == nullptr) return damaged;
  return image;
}

}  // namespace foreland::terrain
