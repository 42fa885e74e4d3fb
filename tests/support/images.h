// Image files made by tests; PNG ones are made by terrain/model/png.h.
#pragma once

// <jpeglib.h> needs <cstdio> before it.
#include <cstdio>
#include <cstdlib>
// clang-format off
#include <jpeglib.h>
// clang-format on
#include <webp/encode.h>

#include "base/bytes.h"
#include "terrain/model/image.h"

namespace foreland::test {

inline Bytes toJpeg(const terrain::Image& image) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* out = nullptr;
  unsigned long size = 0;  // NOLINT: libjpeg's type
  jpeg_mem_dest(&jpeg, &out, &size);
  jpeg.image_width = image.width, jpeg.image_height = image.height;
  jpeg.input_components = 4, jpeg.in_color_space = JCS_EXT_RGBA;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 95, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (uint32_t y = 0; y < image.height; ++y) {
    auto* row = const_cast<JSAMPLE*>(image.at(0, y).data());
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  Bytes bytes(out, out + size);
  jpeg_destroy_compress(&jpeg);
  std::free(out);
  return bytes;
}

inline Bytes toWebp(const terrain::Image& image) {
  uint8_t* out = nullptr;
  const size_t size = WebPEncodeLosslessRGBA(image.pixels[0].data(), static_cast<int>(image.width),
                                             static_cast<int>(image.height), static_cast<int>(4 * image.width), &out);
  Bytes bytes(out, out + size);
  WebPFree(out);
  return bytes;
}

}  // namespace foreland::test
