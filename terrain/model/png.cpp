#include "terrain/model/png.h"

#include <png.h>

#include <string>

#include "base/check.h"
#include "terrain/model/image_formats.h"
#include "terrain/model/read_file.h"

namespace foreland::terrain {

Result<Image> decodePng(ByteSpan bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto fail = [&](const std::string& what) {
    const Error error{ErrorCode::kMalformed, what + " (" + png.message + ")"};
    png_image_free(&png);
    return error;
  };
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) return fail("not a readable PNG image");
  if (Status status = checkImageSize(png.width, png.height); !status.ok()) {
    png_image_free(&png);
    return status.error();
  }
  png.format = PNG_FORMAT_RGBA;
  Image image{png.width, png.height, std::vector<Colour>(uint64_t{png.width} * png.height)};
  if (!png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr)) return fail("a damaged PNG image");
  return image;
}

Result<Image> readPng(const std::filesystem::path& path) {
  const auto bytes = readFile(path);
  if (!bytes.ok()) return bytes.error();
  auto image = decodePng(*bytes);
  if (!image.ok()) return Error{image.error().code, path.string() + ": " + image.error().message};
  return image;
}

Result<Bytes> encodePng(const Image& image) {
  CHECK_EQ(image.pixels.size(), uint64_t{image.width} * image.height);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGBA;
  Bytes bytes(PNG_IMAGE_PNG_SIZE_MAX(png));
  png_alloc_size_t size = bytes.size();
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr))
    return Error{ErrorCode::kLimit, std::string("a PNG image cannot be made (") + png.message + ")"};
  bytes.resize(size);
  return bytes;
}

}  // namespace foreland::terrain
