#include "terrain/model/image.h"

#include <algorithm>
#include <string_view>

#include "terrain/model/image_formats.h"
#include "terrain/model/read_file.h"

namespace foreland::terrain {

namespace {

Result<Image> decode(ByteSpan bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<size_t>(bytes.size(), 12));
  if (text.starts_with("\x89PNG")) return decodePng(bytes);
  if (text.starts_with("\xff\xd8\xff")) return decodeJpeg(bytes);
  if (text.starts_with("RIFF") && text.ends_with("WEBP")) return decodeWebp(bytes);
  return Error{ErrorCode::kUnsupported, "neither a PNG, nor a JPEG, nor a WebP image; convert it to one of these"};
}

}  // namespace

Status checkImageSize(uint64_t width, uint64_t height) {
  if (width == 0 || height == 0) return Error{ErrorCode::kMalformed, "an image without pixels; export it again"};
  if (width > kMaxImagePixels / height)
    return Error{ErrorCode::kLimit, "more than 268435456 pixels; scale the image down"};
  return {};
}

Result<Image> decodeImage(ByteSpan bytes, const std::string& name) {
  auto image = decode(bytes);
  if (!image.ok()) return Error{image.error().code, name + ": " + image.error().message};
  return image;
}

Result<Image> readImage(const std::filesystem::path& path) {
  const auto bytes = readFile(path);
  if (!bytes.ok()) return bytes.error();
  return decodeImage(*bytes, path.string());
}

}  // namespace foreland::terrain
