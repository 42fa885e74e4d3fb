#include "tests/support/exr_channel.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>

namespace foreland::test {

std::vector<float> readChannel(const std::filesystem::path& path, const char* name) {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i window = file.header().dataWindow();
  const int width = window.max.x + 1, height = window.max.y + 1;
  const Imf::Channel* channel = file.header().channels().findChannel(name);
  EXPECT_TRUE(channel != nullptr) << name;
  if (channel == nullptr) return {};
  std::vector<float> values(static_cast<size_t>(width) * static_cast<size_t>(height));
  Imf::FrameBuffer buffer;
  buffer.insert(name,
                Imf::Slice(channel->type, reinterpret_cast<char*>(values.data()), 4, 4 * static_cast<size_t>(width)));
  file.setFrameBuffer(buffer);
  file.readPixels(0, height - 1);
  return values;
}

}  // namespace foreland::test
