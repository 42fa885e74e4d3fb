#include "terrain/model/png.h"

#include <png.h>

#include "base/check.h"

namespace foreland::terrain {

Result<Image> readPng(const std::filesystem::path& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto fail = [&](ErrorCode code, const std::string& what) {
    png_image_free(&png);
    return Error{code, path.string() + ": " + what};
  };
  if (!png_image_begin_read_from_file(&png, path.c_str()))
    return fail(ErrorCode::kMalformed, std::string("not a readable PNG image (") + png.message + ")");
  if (uint64_t{png.width} * png.height > kMaxImagePixels)
    return fail(ErrorCode::kLimit, "more than 268435456 pixels; scale the image down");
  png.format = PNG_FORMAT_RGBA;
  Image image{png.width, png.height, std::vector<Colour>(uint64_t{png.width} * png.height)};
  if (!png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr))
    return fail(ErrorCode::kMalformed, std::string("a damaged PNG image (") + png.message + ")");
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
