// <jpeglib.h> needs <cstdio> before it.
#include <csetjmp>
#include <cstdio>
#include <string>
// clang-format off
#include <jpeglib.h>
// clang-format on

#include "terrain/model/image_formats.h"

namespace foreland::terrain {

namespace {

// libjpeg leaves by a jump where something is wrong.
struct JpegErrors {
  jpeg_error_mgr base;  // first, so that a pointer to it is one to the whole
  jmp_buf leave;
  char message[JMSG_LENGTH_MAX];
};

void leaveWithMessage(j_common_ptr jpeg) {
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  errors->base.format_message(jpeg, errors->message);
  longjmp(errors->leave, 1);  // NOLINT: no object with a destructor is alive in the functions that are left
}

void saySilently(j_common_ptr) {}

Status readHeader(jpeg_decompress_struct& jpeg, JpegErrors& errors, ByteSpan bytes) {
  if (setjmp(errors.leave) != 0) return Error{ErrorCode::kMalformed, errors.message};  // NOLINT
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, bytes.data(), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  return {};
}

// `pixels` holds the whole image.
Status readPixels(jpeg_decompress_struct& jpeg, JpegErrors& errors, Colour* pixels) {
  if (setjmp(errors.leave) != 0) return Error{ErrorCode::kMalformed, errors.message};  // NOLINT
  jpeg.out_color_space = JCS_EXT_RGBA;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    auto* row = reinterpret_cast<JSAMPLE*>(pixels + size_t{jpeg.output_scanline} * jpeg.output_width);
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  return {};
}

}  // namespace

Result<Image> decodeJpeg(ByteSpan bytes) {
  JpegErrors errors{};
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = leaveWithMessage;
  errors.base.output_message = saySilently;
  Image image;
  Status status = readHeader(jpeg, errors, bytes);
  if (status.ok()) status = checkImageSize(jpeg.image_width, jpeg.image_height);
  if (status.ok()) {
    image = {jpeg.image_width, jpeg.image_height, std::vector<Colour>(uint64_t{jpeg.image_width} * jpeg.image_height)};
    status = readPixels(jpeg, errors, image.pixels.data());
  }
  jpeg_destroy_decompress(&jpeg);
  if (!status.ok()) return Error{status.error().code, "not a readable JPEG image (" + status.error().message + ")"};
  return image;
}

}  // namespace foreland::terrain
