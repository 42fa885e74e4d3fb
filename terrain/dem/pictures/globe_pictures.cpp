#include "terrain/dem/pictures/globe_pictures.h"

#include <cpl_conv.h>
#include <fmt/format.h>
#include <gdal.h>
#include <gdalwarper.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/pictures/colour_raster.h"
#include "terrain/dem/pictures/picture_file.h"

namespace foreland::terrain {

namespace {

constexpr double kDegreeRad = std::numbers::pi / 180;  // in radians
constexpr uint64_t kMaxPixels = 1u << 28;
constexpr double kWidePatch = 0.5;  // radians: patches that are larger meet every picture

Error refused(const std::string& name, const std::string& why) { return {ErrorCode::kUnsupported, name + ": " + why}; }

glm::dvec2 lonLatOf(const glm::dvec3& unit) {
  return glm::dvec2(std::atan2(unit.y, unit.x), std::asin(std::clamp(unit.z, -1.0, 1.0))) / kDegreeRad;
}

double spacingOf(const ColourRaster& raster) { return std::min(raster.pixel().x, raster.pixel().y) * kDegreeRad; }

class GlobePictures final : public GlobePicture {
 public:
  GlobePictures(std::vector<ColourRaster> rasters, std::vector<std::string> notes)
      : rasters_(std::move(rasters)), notes_(std::move(notes)) {}

  const std::vector<std::string>& notes() const override { return notes_; }
  double finestSpacing() const override { return spacingOf(rasters_.front()); }

  double spacingIn(const GlobePatch& patch) const override {
    for (const ColourRaster& raster : rasters_)
      if (meets(raster, patch)) return spacingOf(raster);
    return std::numeric_limits<double>::infinity();
  }

  Rgba colourAt(const glm::dvec3& direction, double width_rad) const override {
    const glm::dvec3 unit = glm::normalize(direction);
    const glm::dvec2 degrees = lonLatOf(unit);
    const double width = width_rad / kDegreeRad, cosine = std::max(std::hypot(unit.x, unit.y), 1e-3);
    Rgba below;
    for (const ColourRaster& raster : rasters_) {
      const Rgba colour = raster.at(degrees, {std::min(width / cosine, 360.0), width});
      if (colour.alpha >= 128) return colour;
      if (colour.alpha > below.alpha) below = colour;
    }
    return below;
  }

 private:
  static bool meets(const ColourRaster& raster, const GlobePatch& patch) {
    if (raster.goesAround() || patch.angle_rad > kWidePatch) return true;
    glm::dvec2 low(INFINITY), high(-INFINITY);
    for (const glm::dvec3& d : patch.directions) {
      const glm::dvec2 at = raster.pixelsOf(lonLatOf(glm::normalize(d)));
      low = glm::min(low, at), high = glm::max(high, at);
    }
    // Between directions, and over the antimeridian, beyond which a picture begins again.
    const glm::dvec2 ring = 1.0 + 0.5 * (high - low) / std::max(1.0, patch.side - 1.0);
    low -= ring, high += ring;
    return low.x <= raster.width() && low.y <= raster.height() && high.x >= 0 && high.y >= 0;
  }

  std::vector<ColourRaster> rasters_;  // the finest first
  std::vector<std::string> notes_;
};

// A map's picture on its own meridians and parallels.
Status toDegrees(PictureFile& picture, OGRSpatialReferenceH crs) {
  OGRSpatialReferenceH base = OSRCloneGeogCS(crs);
  char* wkt = nullptr;
  if (base != nullptr) OSRExportToWkt(base, &wkt);
  GdalDataset warped(wkt == nullptr
                         ? nullptr
                         : GDALAutoCreateWarpedVRT(picture.colours.get(), nullptr, wkt, GRA_Bilinear, 0.125, nullptr));
  CPLFree(wkt);
  if (base != nullptr) OSRDestroySpatialReference(base);
  if (!warped)
    return refused(picture.name,
                   "it cannot be brought to latitude and longitude; convert it first with gdalwarp -t_srs "
                   "EPSG:4326");
  // The warped one refers to the other, which lives as long as the file.
  picture.sources.push_back(std::move(picture.colours));
  picture.colours = std::move(warped);
  return {};
}

// The corner of the first pixel and the size of one, in degrees.
struct Extent {
  glm::dvec2 corner, pixel;
};
Result<Extent> extentOf(PictureFile& picture) {
  std::array<double, 6> own{};
  const auto size = [&] {
    return glm::dvec2(GDALGetRasterXSize(picture.colours.get()), GDALGetRasterYSize(picture.colours.get()));
  };
  if (GDALGetGCPCount(picture.file.get()) == 0 && GDALGetGeoTransform(picture.colours.get(), own.data()) != CE_None) {
    picture.notes.push_back("it has no georeference and was laid over the whole globe");
    return Extent{{-180, 90}, glm::dvec2(360, 180) / size()};
  }
  OGRSpatialReferenceH crs = GDALGetSpatialRef(picture.colours.get());
  if (crs == nullptr) crs = GDALGetGCPSpatialRef(picture.file.get());
  const bool is_along = crs == nullptr || OSRIsGeographic(crs);
  if (!is_along || GDALGetGCPCount(picture.file.get()) > 0 || own[2] != 0 || own[4] != 0) {
    if (crs == nullptr)
      return refused(picture.name, "it names no reference system; give it one with gdal_translate -a_srs");
    if (Status s = toDegrees(picture, crs); !s.ok()) return s.error();
    if (GDALGetGeoTransform(picture.colours.get(), own.data()) != CE_None)
      return refused(picture.name, "it has no position; give it one with gdal_translate -a_ullr");
  }
  const double unit = crs != nullptr && OSRIsGeographic(crs) ? OSRGetAngularUnits(crs, nullptr) / kDegreeRad : 1;
  const Extent extent{glm::dvec2(own[0], own[3]) * unit, glm::dvec2(own[1], -own[5]) * unit};
  const glm::dvec2 end = extent.corner + extent.pixel * glm::dvec2(1, -1) * size();
  if (!(extent.pixel.x > 0 && extent.pixel.y > 0 && extent.corner.y <= 90.5 && end.y >= -90.5 &&
        end.x - extent.corner.x <= 361))
    return refused(picture.name,
                   "it does not lie between the poles, north up; correct it with gdalwarp -t_srs EPSG:4326");
  return extent;
}

Result<ColourRaster> readColours(PictureFile& picture) {
  const auto extent = extentOf(picture);
  if (!extent) return extent.error();
  GDALDatasetH dataset = picture.colours.get();
  const int width = GDALGetRasterXSize(dataset), height = GDALGetRasterYSize(dataset),
            bands = std::min(GDALGetRasterCount(dataset), 4);
  const uint64_t count = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
  if (count > kMaxPixels)
    return Error{ErrorCode::kLimit,
                 fmt::format("{}: a picture of {} x {} pixels; a globe takes up to 2^28; make it smaller "
                             "with gdal_translate -outsize",
                             picture.name, width, height)};
  std::vector<Rgba> pixels(count, Rgba{0, 0, 0, 255});
  GdalMessages messages;
  for (int row = 0; row < height; ++row)
    if (GDALDatasetRasterIO(dataset, GF_Read, 0, row, width, 1,
                            &pixels[static_cast<size_t>(row) * static_cast<size_t>(width)], width, 1, GDT_Byte, bands,
                            nullptr, 4, 0, 1) != CE_None)
      return Error{ErrorCode::kMalformed,
                   fmt::format("{}: cannot be read; the file is damaged or cut short, get it anew (GDAL says: {})",
                               picture.name, messages.errors())};
  return ColourRaster(std::move(pixels), static_cast<uint32_t>(width), extent->corner, extent->pixel);
}

}  // namespace

Result<std::unique_ptr<GlobePicture>> openGlobePictures(const std::vector<std::filesystem::path>& files,
                                                        const std::vector<std::filesystem::path>& allowed_folders,
                                                        AlphaChoice alpha) {
  if (files.empty()) return Error{ErrorCode::kInvalidArgument, "no picture was named"};
  registerGdalDrivers();
  std::vector<ColourRaster> rasters;
  std::vector<std::string> notes;
  for (const std::filesystem::path& path : files) {
    const auto fence = std::make_shared<const GdalFence>(FileFence(std::array{path}, allowed_folders));
    auto picture = openColours(path, fence, alpha);
    if (!picture) return picture.error();
    auto raster = readColours(*picture);
    if (Status s = checkRefused(fence.get(), picture->name); !s.ok()) return s.error();
    if (!raster) return raster.error();
    for (const std::string& note : picture->notes) notes.push_back(path.filename().string() + ": " + note);
    const auto at = std::ranges::upper_bound(rasters, spacingOf(*raster), std::ranges::less{}, spacingOf);
    rasters.insert(at, std::move(*raster));
  }
  return std::unique_ptr<GlobePicture>(std::make_unique<GlobePictures>(std::move(rasters), std::move(notes)));
}

}  // namespace foreland::terrain
