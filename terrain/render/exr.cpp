#include "terrain/render/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>

#include <algorithm>
#include <array>
#include <exception>
#include <type_traits>

#include "base/check.h"

namespace foreland::terrain {

namespace {

class MemoryStream final : public Imf::OStream {
 public:
  explicit MemoryStream(Bytes& bytes) : OStream("picture.exr"), bytes_(bytes) {}
  void write(const char bytes[], int count) override {
    const auto size = static_cast<size_t>(count);
    bytes_.resize(std::max(bytes_.size(), at_ + size));
    std::copy_n(bytes, size, bytes_.begin() + static_cast<ptrdiff_t>(at_));
    at_ += size;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t to) override { at_ = to; }

 private:
  Bytes& bytes_;
  size_t at_ = 0;
};

// Both kinds of value have four bytes.
Imf::Slice sliceOf(const ExrChannel& channel, uint32_t width) {
  return std::visit(
      [&](const auto& values) {
        using Value = typename std::decay_t<decltype(values)>::value_type;
        static_assert(sizeof(Value) == 4);
        const char* first = reinterpret_cast<const char*>(values.data());
        return Imf::Slice(std::is_same_v<Value, float> ? Imf::FLOAT : Imf::UINT, const_cast<char*>(first),
                          sizeof(Value), sizeof(Value) * width);
      },
      channel.values);
}

void write(Imf::OStream& stream, uint32_t width, uint32_t height, const std::vector<ExrChannel>& channels) {
  Imf::Header header(static_cast<int>(width), static_cast<int>(height));
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  for (const ExrChannel& channel : channels) {
    const Imf::Slice slice = sliceOf(channel, width);
    header.channels().insert(channel.name, Imf::Channel(slice.type));
    buffer.insert(channel.name, slice);
  }
  Imf::OutputFile file(stream, header);
  file.setFrameBuffer(buffer);
  file.writePixels(static_cast<int>(height));
}

}  // namespace

std::vector<ExrChannel> channelsOf(const Picture& picture) {
  std::vector<ExrChannel> channels;
  const auto addVector = [&](const std::vector<glm::vec3>& values, const std::array<const char*, 3>& names) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<float> one;
      one.reserve(values.size());
      for (const glm::vec3& v : values) one.push_back(v[axis]);
      channels.push_back({names[static_cast<size_t>(axis)], std::move(one)});
    }
  };
  addVector(picture.colour, {"R", "G", "B"});
  channels.push_back({"depth.Z", picture.depth_m});
  addVector(picture.normal, {"normal.X", "normal.Y", "normal.Z"});
  channels.push_back({"id.node", picture.node});
  channels.push_back({"id.object", picture.object});
  if (!picture.error_px.empty()) channels.push_back({"error.px", picture.error_px});
  return channels;
}

Result<Bytes> encodeExr(uint32_t width, uint32_t height, const std::vector<ExrChannel>& channels) {
  for (const ExrChannel& channel : channels)
    CHECK_EQ(std::visit([](const auto& values) { return values.size(); }, channel.values), size_t{width} * height);
  try {
    Bytes bytes;
    MemoryStream stream(bytes);
    write(stream, width, height, channels);
    return bytes;
  } catch (const std::exception& e) {
    return Error{ErrorCode::kUnsupported, std::string("OpenEXR cannot hold the picture: ") + e.what()};
  }
}

}  // namespace foreland::terrain
