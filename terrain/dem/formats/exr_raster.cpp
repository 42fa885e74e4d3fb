#include "terrain/dem/formats/exr_raster.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <optional>

#include "terrain/dem/raster/height_decoder.h"

namespace foreland::terrain {

namespace {

constexpr int64_t kMaxExrSide = int64_t{1} << 20;

class ExrRaster final : public Raster {
 public:
  ExrRaster(const std::string& path, std::string channel)
      : info_{.name = path}, file_(path.c_str()), channel_(std::move(channel)) {}

  Status init(const OpenOptions& options);

  const RasterInfo& info() const override { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    if (Status s = readRaw(first, count, out); !s.ok()) return s;
    decoder_->decode(out);
    return {};
  }

 private:
  Status pickChannel();
  void readSpacing();
  Status readRaw(uint32_t first, uint32_t count, std::span<float> out);

  RasterInfo info_;
  Imf::InputFile file_;
  std::string channel_;  // empty until picked
  Imath::Box2i window_;
  std::optional<HeightDecoder> decoder_;
};

Status ExrRaster::pickChannel() {
  const Imf::ChannelList& channels = file_.header().channels();
  std::string known;
  int count = 0;
  for (auto c = channels.begin(); c != channels.end(); ++c, ++count)
    known += std::string(count == 0 ? "" : ", ") + c.name();
  if (channel_.empty() && count == 1) channel_ = channels.begin().name();
  for (const char* usual : {"height", "Height", "Y", "Z", "R"})
    if (channel_.empty() && channels.findChannel(usual) != nullptr) channel_ = usual;
  const Imf::Channel* channel = channel_.empty() ? nullptr : channels.findChannel(channel_.c_str());
  if (channel == nullptr)
    return Error{ErrorCode::kInvalidArgument, fmt::format("{}: {}; choose one with --channel: {}", info_.name,
                                                          channel_.empty() ? "no channel that looks like heights"
                                                                           : "has no channel '" + channel_ + "'",
                                                          known)};
  if (channel->xSampling != 1 || channel->ySampling != 1)
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{}: channel '{}' is subsampled; store it at full resolution", info_.name, channel_)};
  if (count > 1) info_.notes.push_back(fmt::format("heights are taken from channel '{}' of {}", channel_, known));
  return {};
}

void ExrRaster::readSpacing() {
  double spacing = 0;
  if (const auto* d = file_.header().findTypedAttribute<Imf::DoubleAttribute>(kExrSpacingAttribute))
    spacing = d->value();
  else if (const auto* f = file_.header().findTypedAttribute<Imf::FloatAttribute>(kExrSpacingAttribute))
    spacing = f->value();
  if (!(spacing > 0) || !(spacing < 1e9)) return;
  info_.georeference.has_transform = true;
  info_.georeference.kind = MapKind::kProjected;  // metres, though of no named map
  info_.georeference.transform = {0, spacing, 0, 0, 0, -spacing};
}

Status ExrRaster::init(const OpenOptions& options) {
  window_ = file_.header().dataWindow();
  const int64_t w = int64_t{window_.max.x} - window_.min.x + 1, h = int64_t{window_.max.y} - window_.min.y + 1;
  if (w < 2 || h < 2 || w > kMaxExrSide || h > kMaxExrSide)
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{}: {} x {} samples; a terrain has 2 to {} a side", info_.name, w, h, kMaxExrSide)};
  info_.width = static_cast<uint32_t>(w);
  info_.height = static_cast<uint32_t>(h);
  if (Status s = pickChannel(); !s.ok()) return s;
  readSpacing();
  decoder_.emplace(options.nodata, HeightDecoder::Units{});
  const ReadRaw read = [this](uint32_t first, uint32_t count, std::span<float> out) {
    return readRaw(first, count, out);
  };
  if (Status s = surveyHeights(info_.width, info_.height, read, *decoder_); !s.ok()) return s;
  info_.survey = decoder_->survey();
  for (std::string& note : decoder_->notes()) info_.notes.push_back(std::move(note));
  if (info_.survey.voids == info_.survey.samples)
    return Error{ErrorCode::kMalformed,
                 fmt::format("{}: holds no heights, all {} samples are voids", info_.name, info_.survey.samples)};
  return {};
}

Status ExrRaster::readRaw(uint32_t first, uint32_t count, std::span<float> out) {
  try {
    const int top = window_.min.y + static_cast<int>(first);
    // OpenEXR addresses by absolute pixel; the pointer arithmetic is done on integers, as the origin lies outside
    // `out`.
    const size_t row = size_t{info_.width} * sizeof(float);
    const intptr_t base = reinterpret_cast<intptr_t>(out.data()) -
                          intptr_t{window_.min.x} * static_cast<intptr_t>(sizeof(float)) -
                          intptr_t{top} * static_cast<intptr_t>(row);
    Imf::FrameBuffer buffer;
    buffer.insert(channel_, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(base), sizeof(float), row));
    file_.setFrameBuffer(buffer);
    file_.readPixels(top, top + static_cast<int>(count) - 1);
    return {};
  } catch (const std::exception& e) {
    return Error{
        ErrorCode::kMalformed,
        fmt::format(
            "{}: rows {} to {} cannot be read; the file is damaged or cut short, get it anew (OpenEXR says: {})",
            info_.name, first, first + count - 1, e.what())};
  }
}

}  // namespace

bool isExrFile(const std::filesystem::path& path) {
  std::array<char, 4> magic{};
  std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
  return magic == std::array{'\x76', '\x2f', '\x31', '\x01'};
}

Result<std::unique_ptr<Raster>> openExrRaster(const std::filesystem::path& path, const OpenOptions& options) {
  try {
    auto raster = std::make_unique<ExrRaster>(path.string(), options.channel.value_or(""));
    if (Status s = raster->init(options); !s.ok()) return s.error();
    return std::unique_ptr<Raster>(std::move(raster));
  } catch (const std::exception& e) {
    return Error{ErrorCode::kMalformed,
                 fmt::format("{}: not an OpenEXR image that can be read, or a damaged one (OpenEXR says: {})",
                             path.string(), e.what())};
  }
}

}  // namespace foreland::terrain
