// Reads and writes PNG images by libpng, which no other file uses. Any bytes end in an Image or an Error that names the
// file. Any thread.
#pragma once

#include <filesystem>

#include "base/bytes.h"
#include "base/result.h"
#include "terrain/model/image.h"

namespace foreland::terrain {

// Reads a file of any bit depth and colour type; the image has 8 bits a channel, sRGB.
[[nodiscard]] Result<Image> readPng(const std::filesystem::path& path);
// The bytes of a file with 8 bits a channel: red, green, blue, alpha; lossless. An Error only if memory does not
// suffice.
[[nodiscard]] Result<Bytes> encodePng(const Image& image);

}  // namespace foreland::terrain
