#include "server/net/http/compression.h"

#include <brotli/encode.h>
#include <zlib.h>

#include <cstdint>
#include <utility>

namespace foreland::server {
namespace {

// Null unless compression succeeded and is worth it.
std::shared_ptr<const std::string> ifSmaller(std::string compressed, size_t size, bool is_done, size_t original) {
  if (!is_done || 10 * size > 9 * original) return nullptr;
  compressed.resize(size);
  return std::make_shared<const std::string>(std::move(compressed));
}

}  // namespace

std::shared_ptr<const std::string> compressBrotli(const std::string& text) {
  constexpr int kQuality = 9;  // the best is ten times slower and a thirtieth smaller
  std::string out(BrotliEncoderMaxCompressedSize(text.size()), '\0');
  size_t size = out.size();
  const bool is_done = BrotliEncoderCompress(kQuality, BROTLI_DEFAULT_WINDOW, BROTLI_DEFAULT_MODE, text.size(),
                                             reinterpret_cast<const uint8_t*>(text.data()), &size,
                                             reinterpret_cast<uint8_t*>(out.data())) == BROTLI_TRUE;
  return ifSmaller(std::move(out), size, is_done, text.size());
}

std::shared_ptr<const std::string> compressGzip(const std::string& text) {
  constexpr int kGzip = 16;  // zlib: a gzip header instead of its own
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, MAX_WBITS + kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    return nullptr;
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // NOLINT: zlib does not write there
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const bool is_done = deflate(&stream, Z_FINISH) == Z_STREAM_END;
  const size_t size = stream.total_out;
  deflateEnd(&stream);
  return ifSmaller(std::move(out), size, is_done, text.size());
}

}  // namespace foreland::server
