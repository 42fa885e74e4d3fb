#include "server/net/http/png.h"

#include <zlib.h>

#include <string_view>

#include "base/check.h"

namespace foreland::server {
namespace {

std::string bigEndian(uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift & 0xff));
  return bytes;
}

const Bytef* bytesOf(std::string_view text) { return reinterpret_cast<const Bytef*>(text.data()); }

std::string chunk(std::string_view kind, std::string_view body) {
  std::string whole(kind);
  whole.append(body);
  const auto sum = static_cast<uint32_t>(crc32(0, bytesOf(whole), static_cast<uInt>(whole.size())));
  return bigEndian(static_cast<uint32_t>(body.size())) + whole + bigEndian(sum);
}

// Each row as its differences from the pixel before (filter 1).
std::string filtered(const Picture& picture) {
  std::string rows;
  rows.reserve((3 * size_t{picture.width} + 1) * picture.height);
  for (uint32_t y = 0; y < picture.height; ++y) {
    rows.push_back(1);
    std::array<uint8_t, 3> before{};
    for (uint32_t x = 0; x < picture.width; ++x) {
      const std::array<uint8_t, 3>& pixel = picture.pixels[size_t{y} * picture.width + x];
      for (size_t c = 0; c < 3; ++c) rows.push_back(static_cast<char>(pixel[c] - before[c]));
      before = pixel;
    }
  }
  return rows;
}

std::string deflated(std::string_view body) {
  uLongf size = compressBound(static_cast<uLong>(body.size()));
  std::string packed(size, '\0');
  const int result = compress2(reinterpret_cast<Bytef*>(packed.data()), &size, bytesOf(body),
                               static_cast<uLong>(body.size()), Z_BEST_COMPRESSION);
  CHECK_EQ(result, Z_OK);
  packed.resize(size);
  return packed;
}

}  // namespace

std::string encodePng(const Picture& picture) {
  CHECK_EQ(picture.pixels.size(), size_t{picture.width} * picture.height);
  CHECK_TRUE(!picture.pixels.empty());
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n", kTrueColour("\x08\x02\0\0\0", 5);
  return std::string(kSignature) +
         chunk("IHDR", bigEndian(picture.width) + bigEndian(picture.height) + std::string(kTrueColour)) +
         chunk("IDAT", deflated(filtered(picture))) + chunk("IEND", "");
}

}  // namespace foreland::server
