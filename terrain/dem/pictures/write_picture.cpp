#include "terrain/dem/pictures/write_picture.h"

#include <fmt/format.h>
#include <gdal.h>

#include <limits>
#include <system_error>

#include "base/check.h"
#include "terrain/dem/formats/gdal_files.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/formats/pending_file.h"
#include "terrain/dem/pictures/lattice_map.h"
#include "terrain/dem/pictures/picture_file.h"

namespace foreland::terrain {

namespace {

Error refusal(const std::filesystem::path& path, const GdalMessages& messages) {
  return {ErrorCode::kIo, fmt::format("{}: cannot be written; nothing of it was kept{}", path.string(),
                                      messages.hasErrors() ? " (GDAL says: " + messages.errors() + ")" : "")};
}

class TiffPicture final : public PictureWriter {
 public:
  TiffPicture(const std::filesystem::path& path, uint32_t width, uint32_t height)
      : pending_(path), width_(width), height_(height) {}

  Status open(const LatticeMap& map, const PictureLattice& lattice, double texel) {
    GdalMessages messages;
    const char* const options[] = {"COMPRESS=JPEG", "JPEG_QUALITY=95",  "PHOTOMETRIC=YCBCR",
                                   "TILED=YES",     "BIGTIFF=IF_SAFER", nullptr};
    dataset_.reset(GDALCreate(GDALGetDriverByName("GTiff"), pending_.path().c_str(), static_cast<int>(width_),
                              static_cast<int>(height_), 3, GDT_Byte, options));
    if (!dataset_) return refusal(pending_.destination(), messages);
    if (map.referenceSystem() == nullptr) return {};  // it lies over the whole scene
    auto transform = map.transform({-0.5, lattice.samples_y - 0.5}, glm::dvec2(texel));
    if (GDALSetGeoTransform(dataset_.get(), transform.data()) != CE_None ||
        GDALSetSpatialRef(dataset_.get(), map.referenceSystem()) != CE_None)
      return refusal(pending_.destination(), messages);
    return {};
  }

  Status writeRows(uint32_t count, std::span<const std::array<uint8_t, 3>> rows) override {
    CHECK_EQ(rows.size(), size_t{count} * width_);
    CHECK_LE(uint64_t{next_} + count, height_);
    GdalMessages messages;
    const int w = static_cast<int>(width_), n = static_cast<int>(count);
    const CPLErr failed =
        GDALDatasetRasterIO(dataset_.get(), GF_Write, 0, static_cast<int>(next_), w, n,
                            const_cast<uint8_t*>(rows.front().data()), w, n, GDT_Byte, 3, nullptr, 3, 3 * w, 1);
    if (failed != CE_None || messages.hasErrors()) return refusal(pending_.destination(), messages);
    next_ += count;
    return {};
  }

  Status finish() override {
    CHECK_EQ(next_, height_);
    GdalMessages messages;
    GDALClose(dataset_.release());
    if (messages.hasErrors()) return refusal(pending_.destination(), messages);
    return pending_.commit();
  }

 private:
  PendingFile pending_;
  GdalOutput output_{pending_.path()};
  uint32_t width_, height_, next_ = 0;
  GdalDataset dataset_;
};

}  // namespace

Result<std::unique_ptr<PictureWriter>> createPicture(const std::filesystem::path& path, const PictureLattice& lattice,
                                                     uint32_t texels_a_sample) {
  registerGdalDrivers();
  const std::string suffix = path.extension().string();
  if (suffix != ".tif" && suffix != ".tiff")
    return Error{ErrorCode::kUnsupported, path.string() + ": the name of a picture must end in .tif"};
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  std::error_code failed;
  if (!std::filesystem::is_directory(folder, failed))
    return Error{ErrorCode::kNotFound, path.string() + ": there is no directory " + folder.string()};
  const uint64_t width = uint64_t{lattice.samples_x} * texels_a_sample,
                 height = uint64_t{lattice.samples_y} * texels_a_sample;
  if (std::max(width, height) > uint64_t{std::numeric_limits<int>::max()} / 4)
    return Error{ErrorCode::kLimit, path.string() + ": " + std::to_string(width) + " x " + std::to_string(height) +
                                        " texels are too many; take a smaller --imagery-detail"};
  auto map = LatticeMap::of(lattice);
  if (!map) return map.error();
  auto writer = std::make_unique<TiffPicture>(path, static_cast<uint32_t>(width), static_cast<uint32_t>(height));
  if (Status s = writer->open(*map, lattice, 1.0 / texels_a_sample); !s.ok()) return s.error();
  return std::unique_ptr<PictureWriter>(std::move(writer));
}

}  // namespace foreland::terrain
