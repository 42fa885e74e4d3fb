// Height maps as OpenEXR: one float channel "height", the spacing as an attribute. Written through a stream of our own,
// because OpenEXR's destructor would hide the error of a full disk.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfThreading.h>

#include <cerrno>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "base/check.h"
#include "terrain/dem/formats/exr_raster.h"
#include "terrain/dem/formats/pending_file.h"
#include "terrain/dem/formats/write_formats.h"

namespace foreland::terrain {

namespace {

constexpr const char* kChannel = "height";

class CheckedStream final : public Imf::OStream {
 public:
  explicit CheckedStream(const std::filesystem::path& path)
      : OStream(path.c_str()), file_(std::fopen(path.c_str(), "wb")) {
    if (file_ == nullptr) throw std::system_error(errno, std::generic_category());
  }
  ~CheckedStream() override {
    if (file_ != nullptr) std::fclose(file_);
  }
  void write(const char bytes[], int count) override {
    if (std::fwrite(bytes, 1, static_cast<size_t>(count), file_) != static_cast<size_t>(count)) fail();
  }
  uint64_t tellp() override { return static_cast<uint64_t>(ftello(file_)); }
  void seekp(uint64_t to) override {
    if (fseeko(file_, static_cast<off_t>(to), SEEK_SET) != 0) fail();
  }
  // Closes the file. Returns 0, or the errno of the first failed operation.
  int close() {
    const int failed = std::fclose(file_) == 0 ? 0 : errno;
    file_ = nullptr;
    return error_ != 0 ? error_ : failed;
  }

 private:
  void fail() {
    error_ = errno;
    throw std::system_error(errno, std::generic_category());
  }

  std::FILE* file_;
  int error_ = 0;
};

Imf::Header makeHeader(const ElevationFile& file) {
  Imf::Header header(static_cast<int>(file.width), static_cast<int>(file.height));
  header.channels().insert(kChannel, Imf::Channel(Imf::FLOAT));
  header.compression() = Imf::ZIP_COMPRESSION;
  header.insert(kExrSpacingAttribute, Imf::DoubleAttribute(file.spacing_m));
  return header;
}

class ExrWriter final : public ElevationWriter {
 public:
  explicit ExrWriter(const ElevationFile& file)
      : pending_(file.path),
        width_(file.width),
        height_(file.height),
        stream_(std::make_unique<CheckedStream>(pending_.path())),
        image_(std::make_unique<Imf::OutputFile>(*stream_, makeHeader(file))) {}

  Status writeRows(uint32_t count, std::span<const float> rows) override {
    CHECK_EQ(rows.size(), size_t{count} * width_);
    CHECK_LE(uint64_t{next_} + count, height_);
    try {
      const size_t row = size_t{width_} * sizeof(float);
      const intptr_t base =
          reinterpret_cast<intptr_t>(rows.data()) - static_cast<intptr_t>(next_) * static_cast<intptr_t>(row);
      Imf::FrameBuffer buffer;
      buffer.insert(kChannel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(base), sizeof(float), row));
      image_->setFrameBuffer(buffer);
      image_->writePixels(static_cast<int>(count));
      next_ += count;
      return {};
    } catch (const std::exception& e) { return refusal(e.what()); }
  }

  Status finish() override {
    CHECK_EQ(next_, height_);
    image_.reset();
    if (const int failed = stream_->close(); failed != 0) return refusal(std::generic_category().message(failed));
    return pending_.commit();
  }

 private:
  Error refusal(const std::string& why) const {
    return {ErrorCode::kIo,
            pending_.destination().string() + ": cannot be written: " + why + "; nothing of it was kept"};
  }

  PendingFile pending_;  // outlives the stream, so that the file is closed before it is removed
  uint32_t width_, height_, next_ = 0;
  std::unique_ptr<CheckedStream> stream_;
  std::unique_ptr<Imf::OutputFile> image_;
};

}  // namespace

Result<std::unique_ptr<ElevationWriter>> createExr(const ElevationFile& file) {
  try {
    Imf::setGlobalThreadCount(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
    return std::unique_ptr<ElevationWriter>(std::make_unique<ExrWriter>(file));
  } catch (const std::exception& e) {
    return Error{ErrorCode::kIo, file.path.string() + ": cannot be written: " + e.what()};
  }
}

}  // namespace foreland::terrain
