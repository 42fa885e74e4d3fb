// The images that models wear: PNG, JPEG and WebP, told apart by their first bytes. Any bytes end in an Image or an
// Error that names the file. Any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
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

// The image has 8 bits a channel, sRGB, whatever the file has.
[[nodiscard]] Result<Image> readImage(const std::filesystem::path& path);
[[nodiscard]] Result<Image> decodeImage(ByteSpan bytes, const std::string& name);

}  // namespace foreland::terrain
