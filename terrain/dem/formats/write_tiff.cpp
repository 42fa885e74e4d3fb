// Height maps as GeoTIFF through GDAL: one float band, metres of a local map whose origin is the south-west sample.
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal.h>

#include <array>

#include "base/check.h"
#include "terrain/dem/formats/gdal_files.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/formats/pending_file.h"
#include "terrain/dem/formats/write_formats.h"

namespace foreland::terrain {

namespace {

constexpr const char* kLocalMap = "LOCAL_CS[\"synthetic landscape\",UNIT[\"metre\",1]]";

Error refusal(const PendingFile& file, const GdalMessages& messages) {
  return {ErrorCode::kIo, fmt::format("{}: cannot be written; nothing of it was kept{}", file.destination().string(),
                                      messages.hasErrors() ? " (GDAL says: " + messages.errors() + ")" : "")};
}

class TiffWriter final : public ElevationWriter {
 public:
  explicit TiffWriter(const ElevationFile& file) : pending_(file.path), width_(file.width), height_(file.height) {}
  ~TiffWriter() override {
    const GdalMessages silence;
    if (dataset_ != nullptr) GDALClose(dataset_);
  }

  Status open(double spacing_m) {
    GdalMessages messages;
    const char* const options[] = {"COMPRESS=DEFLATE", "PREDICTOR=3", "ZLEVEL=1", "BIGTIFF=IF_SAFER", nullptr};
    dataset_ = GDALCreate(GDALGetDriverByName("GTiff"), pending_.path().c_str(), static_cast<int>(width_),
                          static_cast<int>(height_), 1, GDT_Float32, options);
    if (dataset_ == nullptr) return refusal(pending_, messages);
    // GDAL's transform refers to pixel corners.
    std::array<double, 6> corner{-0.5 * spacing_m, spacing_m, 0, (height_ - 0.5) * spacing_m, 0, -spacing_m};
    if (GDALSetGeoTransform(dataset_, corner.data()) != CE_None || GDALSetProjection(dataset_, kLocalMap) != CE_None)
      return refusal(pending_, messages);
    return {};
  }

  Status writeRows(uint32_t count, std::span<const float> rows) override {
    CHECK_EQ(rows.size(), size_t{count} * width_);
    CHECK_LE(uint64_t{next_} + count, height_);
    GdalMessages messages;
    const int w = static_cast<int>(width_), n = static_cast<int>(count);
    const CPLErr failed = GDALRasterIO(GDALGetRasterBand(dataset_, 1), GF_Write, 0, static_cast<int>(next_), w, n,
                                       const_cast<float*>(rows.data()), w, n, GDT_Float32, 0, 0);
    if (failed != CE_None || messages.hasErrors()) return refusal(pending_, messages);
    next_ += count;
    return {};
  }

  Status finish() override {
    CHECK_EQ(next_, height_);
    GdalMessages messages;
    GDALClose(dataset_);
    dataset_ = nullptr;
    if (messages.hasErrors()) return refusal(pending_, messages);
    return pending_.commit();
  }

 private:
  PendingFile pending_;
  GdalOutput output_{pending_.path()};
  uint32_t width_, height_, next_ = 0;
  GDALDatasetH dataset_ = nullptr;
};

}  // namespace

Result<std::unique_ptr<ElevationWriter>> createTiff(const ElevationFile& file) {
  registerGdalDrivers();
  auto writer = std::make_unique<TiffWriter>(file);
  if (Status s = writer->open(file.spacing_m); !s.ok()) return s.error();
  return std::unique_ptr<ElevationWriter>(std::move(writer));
}

}  // namespace foreland::terrain
