// Reads and writes PNG images by libpng, which no other file uses. Any bytes end in an Image or an Error that names the
// file. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

// Pixels row by row from the top.
struct Image {
  uint32_t width = 0, height = 0;
  std::vector<Colour> pixels;

  const Colour& at(uint32_t x, uint32_t y) const { return pixels[uint64_t{y} * width + x]; }
};

inline constexpr uint64_t kMaxImagePixels = 1u << 28;  // a gigabyte

// Reads a file of any bit depth and colour type; the image has 8 bits a channel, sRGB.
[[nodiscard]] Result<Image> readPng(const std::filesystem::path& path);
// The bytes of a file with 8 bits a channel: red, green, blue, alpha; lossless. An Error only if memory does not
// suffice.
[[nodiscard]] Result<Bytes> encodePng(const Image& image);

}  // namespace foreland::terrain
