#include "terrain/dem/pictures/picture_file.h"

#include <fmt/format.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <system_error>

#include "terrain/dem/formats/gdal_files.h"
#include "terrain/dem/formats/gdal_messages.h"

namespace foreland::terrain {

namespace {

constexpr int kGrid = 21;  // points along each side that a picture's position is found out from

Error refusal(const std::string& name, const std::string& why) { return {ErrorCode::kUnsupported, name + ": " + why}; }

// Whether a band is as alpha is: opaque where it is not transparent, but at edges. Judged by some samples.
bool isLikeAlpha(GDALRasterBandH band) {
  constexpr int kMost = 64;  // a side
  constexpr double kLeastOpaque = 0.9;
  const int width = std::min(GDALGetRasterBandXSize(band), kMost),
            height = std::min(GDALGetRasterBandYSize(band), kMost);
  std::vector<uint8_t> samples(static_cast<size_t>(width) * static_cast<size_t>(height));
  const GdalMessages silence;  // what cannot be read is refused where it is read for good
  if (GDALRasterIO(band, GF_Read, 0, 0, GDALGetRasterBandXSize(band), GDALGetRasterBandYSize(band), samples.data(),
                   width, height, GDT_Byte, 0, 0) != CE_None)
    return true;
  const auto opaque = static_cast<double>(std::ranges::count(samples, 255));
  const auto shown = static_cast<double>(samples.size()) - static_cast<double>(std::ranges::count(samples, 0));
  return opaque >= kLeastOpaque * shown;
}

// Whether the last of `count` bands is taken as alpha; a note where that is not what it is tagged as.
bool takesAlpha(GDALDatasetH dataset, int count, AlphaChoice choice, PictureFile& picture) {
  GDALRasterBandH band = GDALGetRasterBand(dataset, count);
  if (count % 2 != 0 || GDALGetRasterColorInterpretation(band) != GCI_AlphaBand) {
    if (count % 2 == 0) picture.notes.push_back(fmt::format("its band {} is not alpha and was left out", count));
    return false;
  }
  if (choice == AlphaChoice::kAuto && !isLikeAlpha(band)) {
    picture.notes.push_back(fmt::format(
        "its band {} is tagged as alpha, but is hardly anywhere opaque, as infrared is not; it was left out "
        "(--imagery-alpha use takes it as alpha)",
        count));
    return false;
  }
  return choice != AlphaChoice::kIgnore;
}

// The options of gdal_translate that make red, green, blue and perhaps alpha of a dataset's bands.
Result<std::vector<std::string>> bandOptions(GDALDatasetH dataset, AlphaChoice alpha, PictureFile& picture) {
  const int count = GDALGetRasterCount(dataset);
  if (count == 0 || count > 4)
    return refusal(picture.name, fmt::format("it has {} bands; a picture has 1 to 4. Choose three with gdal_translate "
                                             "-b RED -b GREEN -b BLUE",
                                             count));
  for (int i = 1; i <= count; ++i)
    if (GDALGetRasterDataType(GDALGetRasterBand(dataset, i)) != GDT_Byte)
      return refusal(picture.name,
                     fmt::format("its samples are {}, not 8 bits; convert them with gdal_translate -ot "
                                 "Byte -scale",
                                 GDALGetDataTypeName(GDALGetRasterDataType(GDALGetRasterBand(dataset, i)))));
  if (count == 1 && GDALGetRasterColorTable(GDALGetRasterBand(dataset, 1)) != nullptr)
    return std::vector<std::string>{"-expand", "rgba"};
  std::vector<std::string> options;
  for (int i = 1; i <= 3; ++i) options.insert(options.end(), {"-b", std::to_string(count < 3 ? 1 : i)});
  if (takesAlpha(dataset, count, alpha, picture))
    options.insert(options.end(), {"-b", std::to_string(count), "-colorinterp_4", "alpha"});
  return options;
}

GdalDataset translate(GDALDatasetH from, std::vector<std::string> words) {
  words.insert(words.begin(), {"-of", "VRT"});
  GDALTranslateOptions* options = GDALTranslateOptionsNew(gdalWords(words).get(), nullptr);
  GdalDataset out(GDALTranslate("", from, options, nullptr));
  GDALTranslateOptionsFree(options);
  return out;
}

// Gives a picture without georeference the extent of the samples, and one without reference system that of the scene.
Status locate(PictureFile& picture, const PictureLattice& lattice, const LatticeMap& map) {
  std::array<double, 6> own{};
  GDALDatasetH dataset = picture.colours.get();
  const bool has_points = GDALGetGCPCount(picture.file.get()) > 0;
  const bool has_position = has_points || GDALGetGeoTransform(dataset, own.data()) == CE_None;
  if (!has_position) {
    const glm::dvec2 size(GDALGetRasterXSize(dataset), GDALGetRasterYSize(dataset));
    auto over = map.transform({-0.5, lattice.samples_y - 0.5}, glm::dvec2(1));
    for (const size_t i : {1u, 4u}) over[i] *= lattice.samples_x / size.x;
    for (const size_t i : {2u, 5u}) over[i] *= lattice.samples_y / size.y;
    GDALSetGeoTransform(dataset, over.data());
    GDALSetSpatialRef(dataset, map.referenceSystem());
    picture.notes.push_back("it has no georeference and was laid over the whole scene");
    return {};
  }
  const bool has_system =
      GDALGetSpatialRef(dataset) != nullptr || (has_points && GDALGetGCPSpatialRef(dataset) != nullptr);
  if (has_system && map.referenceSystem() == nullptr)
    return refusal(picture.name,
                   "it names a reference system and the elevation has none, so where it lies is unknown; give the "
                   "elevation one with gdal_translate -a_srs");
  if (!has_system && !has_points && map.referenceSystem() != nullptr) {
    GDALSetSpatialRef(dataset, map.referenceSystem());
    picture.notes.push_back("it names no reference system; its coordinates are taken as those of the elevation");
  }
  return {};
}

struct DestroyTransformer {
  void operator()(void* transformer) const { GDALDestroyGenImgProjTransformer(transformer); }
};

// Between the pixels of a picture and the lattice.
class PixelMap {
 public:
  PixelMap(const PictureFile& picture, const PictureLattice& lattice, const LatticeMap& map)
      : lattice_(latticeDataset(map, {-0.5, lattice.samples_y - 0.5}, 1, {lattice.samples_x, lattice.samples_y}, 0)),
        north_(lattice.samples_y - 0.5),
        transformer_(GDALCreateGenImgProjTransformer2(picture.colours.get(), lattice_.get(), nullptr)) {}
  bool isKnown() const { return transformer_ != nullptr; }
  std::optional<glm::dvec2> toLattice(const glm::dvec2& pixel) const {
    const auto at = transformed(pixel, FALSE);
    return at ? std::optional(glm::dvec2(at->x - 0.5, north_ - at->y)) : std::nullopt;
  }
  std::optional<glm::dvec2> toPixel(const glm::dvec2& lattice) const {
    return transformed({lattice.x + 0.5, north_ - lattice.y}, TRUE);
  }

 private:
  std::optional<glm::dvec2> transformed(glm::dvec2 p, int is_inverse) const {
    double z = 0;
    int ok = FALSE;
    const GdalMessages silence;
    if (!GDALGenImgProjTransform(transformer_.get(), is_inverse, 1, &p.x, &p.y, &z, &ok) || !ok) return std::nullopt;
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return std::nullopt;
    return p;
  }
  GdalDataset lattice_;
  double north_;
  std::unique_ptr<void, DestroyTransformer> transformer_;
};

// Calls visit(point) for points in the middles of kGrid x kGrid cells of a rectangle, and at its corners and edges.
template <class Visit>
void forEachPoint(const glm::dvec2& low, const glm::dvec2& high, const Visit& visit) {
  for (int y = 0; y < kGrid; ++y)
    for (int x = 0; x < kGrid; ++x) visit(low + (high - low) * (glm::dvec2(x, y) / (kGrid - 1.0)));
}

bool isWithin(const glm::dvec2& p, const glm::dvec2& low, const glm::dvec2& high) {
  return p.x >= low.x && p.y >= low.y && p.x <= high.x && p.y <= high.y;
}

// Sets extent and resolution; an Error if no part of the picture is over the scene.
Status survey(PictureFile& picture, const PictureLattice& lattice, const LatticeMap& map) {
  const PixelMap pixels(picture, lattice, map);
  if (!pixels.isKnown())
    return refusal(picture.name,
                   "its reference system cannot be related to the elevation's; convert it first with gdalwarp -t_srs");
  const glm::dvec2 size(GDALGetRasterXSize(picture.colours.get()), GDALGetRasterYSize(picture.colours.get()));
  const glm::dvec2 south_west(-0.5), north_east(lattice.samples_x - 0.5, lattice.samples_y - 0.5);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  glm::dvec2 low(kFar), high(-kFar);
  bool all_known = true;
  std::vector<double> sizes;
  const auto measure = [&](const glm::dvec2& pixel) {
    const auto here = pixels.toLattice(pixel), east = pixels.toLattice(pixel + glm::dvec2(1, 0)),
               south = pixels.toLattice(pixel + glm::dvec2(0, 1));
    if (here && east && south) sizes.push_back(std::min(glm::distance(*here, *east), glm::distance(*here, *south)));
  };
  forEachPoint({0, 0}, size, [&](const glm::dvec2& pixel) {
    const auto at = pixels.toLattice(pixel);
    all_known = all_known && at.has_value();
    if (!at) return;
    low = glm::min(low, *at), high = glm::max(high, *at);
    if (isWithin(*at, south_west, north_east)) measure(pixel);
  });
  forEachPoint(south_west, north_east, [&](const glm::dvec2& at) {
    if (const auto pixel = pixels.toPixel(at); pixel && isWithin(*pixel, {0, 0}, size)) measure(*pixel);
  });
  if (sizes.empty()) return refusal(picture.name, "it lies beyond the scene; name pictures of the same place");
  std::ranges::nth_element(sizes, sizes.begin() + static_cast<ptrdiff_t>(sizes.size() / 2));
  picture.resolution = sizes[sizes.size() / 2];
  if (!(picture.resolution > 0))
    return refusal(picture.name, "its georeference is degenerate; correct it with gdal_translate -a_ullr");
  const glm::dvec2 ring = 0.1 * (high - low) + 2.0 + 2 * picture.resolution;
  picture.low = all_known ? low - ring : glm::dvec2(-kFar);
  picture.high = all_known ? high + ring : glm::dvec2(kFar);
  return {};
}

}  // namespace

GdalDataset latticeDataset(const LatticeMap& map, const glm::dvec2& upper_left, double texel, const glm::uvec2& size,
                           int bands) {
  GdalDataset out(GDALCreate(GDALGetDriverByName("MEM"), "", static_cast<int>(size.x), static_cast<int>(size.y), bands,
                             GDT_Byte, nullptr));
  if (!out) return out;
  auto transform = map.transform(upper_left, glm::dvec2(texel));
  GDALSetGeoTransform(out.get(), transform.data());
  if (map.referenceSystem() != nullptr) GDALSetSpatialRef(out.get(), map.referenceSystem());
  constexpr std::array kMeanings{GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
  for (int i = 0; i < bands; ++i)
    GDALSetRasterColorInterpretation(GDALGetRasterBand(out.get(), i + 1), kMeanings[static_cast<size_t>(i)]);
  return out;
}

namespace {

// The picture's position, east by so many turns of the globe. False if it has no longitudes.
bool turn(const PictureFile& picture, int turns) {
  GDALDatasetH dataset = picture.colours.get();
  std::array<double, 6> own{};
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr || !OSRIsGeographic(crs) || GDALGetGeoTransform(picture.file.get(), own.data()) != CE_None)
    return false;
  own[0] += turns * 2 * std::numbers::pi / OSRGetAngularUnits(crs, nullptr);
  return GDALSetGeoTransform(dataset, own.data()) == CE_None;
}

}  // namespace

Result<PictureFile> openColours(const std::filesystem::path& path, const std::shared_ptr<const GdalFence>& fence,
                                AlphaChoice alpha) {
  PictureFile picture;
  picture.fence = fence;
  picture.name = path.string();
  GdalMessages messages;
  Result<GdalDataset> file = openFenced(fence.get(), picture.name, picture.name);
  if (!file.ok()) return file.error();
  picture.file = std::move(*file);
  std::error_code failed;
  if (!picture.file)
    return Error{std::filesystem::exists(path, failed) ? ErrorCode::kMalformed : ErrorCode::kNotFound,
                 fmt::format("{}: not a picture that GDAL reads, or a damaged one (GDAL says: {})", picture.name,
                             messages.errors())};
  const auto options = bandOptions(picture.file.get(), alpha, picture);
  if (!options) return options.error();
  picture.colours = translate(picture.file.get(), *options);
  if (!picture.colours)
    return refusal(picture.name, "its colours cannot be read (GDAL says: " + messages.errors() + ")");
  return picture;
}

namespace {

// The picture at a longitude that is so many turns of the globe further east.
Result<PictureFile> openTurned(const std::filesystem::path& path, const std::shared_ptr<const GdalFence>& fence,
                               const PictureLattice& lattice, const LatticeMap& map, int turns) {
  auto opened = openColours(path, fence, lattice.alpha);
  if (!opened) return opened.error();
  PictureFile picture = std::move(*opened);
  if (Status s = locate(picture, lattice, map); !s.ok()) return s.error();
  if (turns != 0 && !turn(picture, turns)) return refusal(picture.name, "it has no longitudes");
  const Status surveyed = survey(picture, lattice, map);
  if (Status s = checkRefused(fence.get(), picture.name); !s.ok()) return s.error();
  if (!surveyed.ok()) return surveyed.error();
  return picture;
}

}  // namespace

Result<std::vector<PictureFile>> openPicture(const std::filesystem::path& path, const PictureLattice& lattice,
                                             const LatticeMap& map) {
  std::vector<PictureFile> pictures;
  const auto fence = std::make_shared<const GdalFence>(FileFence(std::array{path}, lattice.allowed_folders));
  auto first = openTurned(path, fence, lattice, map, 0);
  const bool may_turn = lattice.frame.kind == proto::FrameKind::kGeographic;
  for (const int turns : {-1, 1}) {
    if (!may_turn) break;
    auto turned = openTurned(path, fence, lattice, map, turns);
    if (!turned) continue;
    if (first) turned->notes.clear();
    pictures.push_back(std::move(turned).value());
  }
  if (!first && pictures.empty()) return first.error();
  if (first) pictures.push_back(std::move(first).value());
  return pictures;
}

}  // namespace foreland::terrain
