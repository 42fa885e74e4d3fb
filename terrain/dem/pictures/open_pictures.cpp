#include "terrain/dem/pictures/open_pictures.h"

#include <fmt/format.h>
#include <gdal.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/pictures/picture_file.h"

namespace foreland::terrain {

namespace {

constexpr int kFinest = 10, kCoarsest = -10;  // texels are 2^-10 to 2^10 sample intervals
constexpr double kSlack = 1.01;
constexpr double kMaxTexels = 0x1p26;  // a side

// The largest power of two that is not above a resolution but by the slack.
double texelFor(double resolution) {
  const int halvings = static_cast<int>(std::ceil(-std::log2(resolution * kSlack)));
  return std::exp2(-std::clamp(halvings, kCoarsest, kFinest));
}

class WarpedPictures final : public PictureSource {
 public:
  WarpedPictures(LatticeMap map, std::vector<PictureFile> files, PictureInfo info)
      : map_(std::move(map)), files_(std::move(files)), info_(std::move(info)) {}
  const PictureInfo& info() const override { return info_; }

  Status read(const PictureWindow& w, std::span<Rgba> out) override {
    CHECK_EQ(out.size(), size_t{w.width} * w.height);
    CHECK_TRUE(uint64_t{w.x} + w.width <= info_.width && uint64_t{w.y} + w.height <= info_.height);
    const glm::dvec2 low = info_.origin + glm::dvec2(w.x, w.y) * info_.texel,
                     high = low + glm::dvec2(w.width, w.height) * info_.texel;
    GdalMessages messages;
    const GdalDataset target = latticeDataset(map_, {low.x, high.y}, info_.texel, {w.width, w.height}, 4);
    std::string names;
    std::vector<void*> sources;
    for (const PictureFile& file : files_)
      if (file.low.x <= high.x && file.low.y <= high.y && file.high.x >= low.x && file.high.y >= low.y) {
        sources.push_back(file.colours.get());
        names += (names.empty() ? "" : ", ") + file.name;
      }
    if (!target || (!sources.empty() && !warp(sources, target.get())) || messages.hasErrors() ||
        !copy(w, target.get(), out))
      return Error{ErrorCode::kMalformed,
                   fmt::format("{}: cannot be read; the file is damaged or cut short, get it anew (GDAL says: {})",
                               names, messages.hasErrors() ? messages.errors() : "no reason")};
    return {};
  }

 private:
  // Bilinear; where pixels are finer than texels, the weights reach over all of them.
  static bool warp(std::vector<void*>& sources, GDALDatasetH target) {
    GDALWarpAppOptions* options =
        GDALWarpAppOptionsNew(gdalWords({"-r", "bilinear", "-wo", "NUM_THREADS=ALL_CPUS"}).get(), nullptr);
    const bool done =
        GDALWarp(nullptr, target, static_cast<int>(sources.size()), sources.data(), options, nullptr) != nullptr;
    GDALWarpAppOptionsFree(options);
    return done;
  }
  // GDAL's first row is the northern one.
  static bool copy(const PictureWindow& w, GDALDatasetH target, std::span<Rgba> out) {
    for (uint32_t y = 0; y < w.height; ++y) {
      Rgba* row = &out[size_t{w.height - 1 - y} * w.width];
      if (GDALDatasetRasterIO(target, GF_Read, 0, static_cast<int>(y), static_cast<int>(w.width), 1, row,
                              static_cast<int>(w.width), 1, GDT_Byte, 4, nullptr, 4, 0, 1) != CE_None)
        return false;
    }
    return true;
  }

  LatticeMap map_;
  std::vector<PictureFile> files_;  // those drawn first come first
  PictureInfo info_;
};

}  // namespace

Result<std::unique_ptr<PictureSource>> openPictures(const std::vector<std::filesystem::path>& files,
                                                    const PictureLattice& lattice) {
  if (files.empty()) return Error{ErrorCode::kInvalidArgument, "no picture was named"};
  registerGdalDrivers();
  auto map = LatticeMap::of(lattice);
  if (!map) return map.error();
  std::vector<PictureFile> pictures;
  PictureInfo info{.origin = {-0.5, -0.5}, .notes = {}};
  for (const std::filesystem::path& path : files) {
    auto opened = openPicture(path, lattice, *map);
    if (!opened) return opened.error();
    for (PictureFile& picture : *opened) {
      for (const std::string& note : picture.notes) info.notes.push_back(path.filename().string() + ": " + note);
      // The finest, and of equals the first named, is drawn last.
      const auto at =
          std::ranges::lower_bound(pictures, picture.resolution, std::ranges::greater{}, &PictureFile::resolution);
      pictures.insert(at, std::move(picture));
    }
  }
  const double finest = pictures.back().resolution, most = std::max(lattice.samples_x, lattice.samples_y);
  info.texel = texelFor(finest);
  while (most / info.texel > kMaxTexels) info.texel *= 2;
  if (info.texel > finest * kSlack)
    info.notes.push_back(
        fmt::format("{}: its pixels are finer than the finest texels, {:g} of the distance between "
                    "samples",
                    pictures.back().name, info.texel));
  info.width = static_cast<uint32_t>(std::ceil(lattice.samples_x / info.texel));
  info.height = static_cast<uint32_t>(std::ceil(lattice.samples_y / info.texel));
  return std::unique_ptr<PictureSource>(
      std::make_unique<WarpedPictures>(std::move(map).value(), std::move(pictures), std::move(info)));
}

}  // namespace foreland::terrain
