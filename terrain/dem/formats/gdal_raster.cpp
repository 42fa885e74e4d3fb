#include "terrain/dem/formats/gdal_raster.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <mutex>
#include <optional>
#include <string>

#include "terrain/dem/formats/gdal_files.h"
#include "terrain/dem/formats/gdal_georeference.h"
#include "terrain/dem/formats/gdal_messages.h"
#include "terrain/dem/raster/height_decoder.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

namespace {

struct CloseRaster {
  void operator()(void* dataset) const {
    const GdalMessages silence;
    GDALClose(dataset);
  }
};
using Dataset = std::unique_ptr<void, CloseRaster>;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// Metres per unit of height; empty if the unit is unknown.
std::optional<double> heightUnit(const std::string& name) {
  const std::string unit = lower(name);
  for (const char* metre : {"", "m", "metre", "metres", "meter", "meters"})
    if (unit == metre) return 1.0;
  for (const char* foot : {"ft", "foot", "feet", "international foot", "international feet"})
    if (unit == foot) return 0.3048;
  for (const char* survey : {"us-ft", "us_ft", "us survey foot", "us survey feet", "ftus", "foot_us", "us foot"})
    if (unit == survey) return 1200.0 / 3937.0;
  if (unit == "km" || unit == "kilometre" || unit == "kilometer") return 1000.0;
  if (unit == "cm" || unit == "centimetre" || unit == "centimeter") return 0.01;
  if (unit == "mm" || unit == "millimetre" || unit == "millimeter") return 0.001;
  return std::nullopt;
}

double heightOf(HeightEncoding encoding, double red, double green, double blue) {
  return encoding == HeightEncoding::kTerrarium ? red * 256 + green + blue / 256 - 32768
                                                : (red * 65536 + green * 256 + blue) * 0.1 - 10000;
}

struct Bands {
  std::vector<GDALRasterBandH> bands;  // one, or red, green and blue
  GDALRasterBandH mask = nullptr;      // 0 where there is no data; null if there is no such band
};

bool isColour(GDALRasterBandH band) {
  const GDALColorInterp meaning = GDALGetRasterColorInterpretation(band);
  return meaning == GCI_PaletteIndex || meaning == GCI_RedBand || meaning == GCI_GreenBand || meaning == GCI_BlueBand;
}

Error pictureError(const std::string& name, int count) {
  return {ErrorCode::kUnsupported, fmt::format("{}: a picture with {} of 8 bits, not heights; if its colours encode "
                                               "heights, say --encoding terrarium or terrain-rgb",
                                               name, count == 1 ? "a palette" : fmt::format("{} bands", count))};
}

class GdalRaster final : public Raster {
 public:
  GdalRaster(Dataset dataset, std::string name, std::shared_ptr<const GdalFence> fence)
      : fence_(std::move(fence)), dataset_(std::move(dataset)) {
    info_.name = std::move(name);
    info_.width = static_cast<uint32_t>(GDALGetRasterXSize(dataset_.get()));
    info_.height = static_cast<uint32_t>(GDALGetRasterYSize(dataset_.get()));
  }

  // `messages` holds what GDAL said while the dataset was opened, and collects what it says from then on.
  Status init(const OpenOptions& options, const GdalMessages& messages);

  // The datasets that the raster's is a view of, and what had to be done to get it.
  void keep(std::vector<Dataset> sources, std::vector<std::string> notes) {
    sources_ = std::move(sources);
    info_.notes.insert(info_.notes.end(), notes.begin(), notes.end());
  }

  const RasterInfo& info() const override { return info_; }
  Status readRows(uint32_t first, uint32_t count, std::span<float> out) override {
    if (Status s = readRaw(first, count, out); !s.ok()) return s;
    decoder_->decode(out);
    return {};
  }

 private:
  void noteFormat();
  Status pickBands(const OpenOptions& options);
  Result<int> bandByName(const std::string& channel) const;
  HeightDecoder makeDecoder(const OpenOptions& options);
  Status readRaw(uint32_t first, uint32_t count, std::span<float> out);
  Status readBand(GDALRasterBandH band, uint32_t first, uint32_t count, std::span<float> out);
  bool isPicture() const;
  void guessEncoding();
  double unitOfHeights(const OpenOptions& options);

  std::shared_ptr<const GdalFence> fence_;  // null without one
  std::vector<Dataset> sources_;            // closed after the dataset
  Dataset dataset_;
  RasterInfo info_;
  Bands bands_;
  HeightEncoding encoding_ = HeightEncoding::kPlain;
  std::optional<HeightDecoder> decoder_;
  std::vector<float> third_, other_;  // scratch: the second and third colour bands, and the mask
};

// Adds a note if the format of the contents differs from what the suffix says.
void GdalRaster::noteFormat() {
  if (!sources_.empty()) return;
  const std::string suffix = lower(std::filesystem::path(info_.name).extension().string());
  const GDALDriverH driver = GDALGetDatasetDriver(dataset_.get());
  const char* usual = GDALGetMetadataItem(driver, GDAL_DMD_EXTENSIONS, nullptr);
  if (suffix.empty() || usual == nullptr || *usual == 0 || suffix == ".gz") return;
  const std::string list = " " + lower(usual) + " ";
  if (list.find(" " + suffix.substr(1) + " ") == std::string::npos)
    info_.notes.push_back(
        fmt::format("by its contents it is {}, whatever its suffix {} says", GDALGetDriverLongName(driver), suffix));
}

Result<int> GdalRaster::bandByName(const std::string& channel) const {
  const int count = GDALGetRasterCount(dataset_.get());
  for (int i = 1; i <= count; ++i)
    if (channel == std::to_string(i) || channel == GDALGetDescription(GDALGetRasterBand(dataset_.get(), i))) return i;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{}: has no band '{}'; it has {} (--channel 1 is the first)", info_.name, channel, count)};
}

bool GdalRaster::isPicture() const {
  GDALRasterBandH first = bands_.bands.front();
  if (GDALGetRasterDataType(first) != GDT_Byte) return false;
  return GDALGetRasterColorInterpretation(first) == GCI_PaletteIndex ||
         (GDALGetRasterCount(dataset_.get()) >= 3 && isColour(first));
}

Status GdalRaster::pickBands(const OpenOptions& options) {
  const int count = GDALGetRasterCount(dataset_.get());
  int first = 1;
  if (options.channel) {
    const Result<int> found = bandByName(*options.channel);
    if (!found.ok()) return found.error();
    first = *found;
  }
  bands_.bands = {GDALGetRasterBand(dataset_.get(), first)};
  const bool has_colours = count >= 3 && GDALGetRasterDataType(bands_.bands[0]) == GDT_Byte;
  encoding_ = options.encoding;
  if (encoding_ == HeightEncoding::kPlain && has_colours && !options.channel) guessEncoding();
  if (encoding_ != HeightEncoding::kPlain) {
    if (!has_colours)
      return Error{
          ErrorCode::kInvalidArgument,
          info_.name + ": --encoding terrarium and terrain-rgb need three bands of 8 bits; leave it out for this file"};
    bands_.bands = {GDALGetRasterBand(dataset_.get(), 1), GDALGetRasterBand(dataset_.get(), 2),
                    GDALGetRasterBand(dataset_.get(), 3)};
  } else if (count > 1 && !options.channel) {
    info_.notes.push_back(
        fmt::format("it has {} bands; the first is taken as heights (--channel N picks another)", count));
  }
  if ((GDALGetMaskFlags(bands_.bands[0]) & (GMF_PER_DATASET | GMF_ALPHA)) != 0)
    bands_.mask = GDALGetMaskBand(bands_.bands[0]);
  if (GDALDataTypeIsComplex(GDALGetRasterDataType(bands_.bands[0])))
    return Error{ErrorCode::kUnsupported, info_.name + ": holds complex numbers, not heights"};
  return {};
}

HeightDecoder GdalRaster::makeDecoder(const OpenOptions& options) {
  GDALRasterBandH band = bands_.bands[0];
  int has = 0;
  std::optional<double> nodata = options.nodata;
  const double tagged = GDALGetRasterNoDataValue(band, &has);
  if (!nodata && has) nodata = tagged;
  if (encoding_ != HeightEncoding::kPlain) return HeightDecoder(options.nodata, {});
  int has_scale = 0, has_offset = 0;
  HeightDecoder::Units units{GDALGetRasterScale(band, &has_scale), GDALGetRasterOffset(band, &has_offset)};
  if (!has_scale || !(std::fabs(units.scale) > 0)) units.scale = 1;
  if (!has_offset) units.offset = 0;
  const double metres = unitOfHeights(options);
  units.scale *= metres;
  units.offset *= metres;
  return HeightDecoder(nodata, units);
}

// Metres a unit of the heights: as the user says; else as the band does, or the vertical part of the reference system.
// A map in feet says nothing of its heights, but makes one doubt.
double GdalRaster::unitOfHeights(const OpenOptions& options) {
  if (options.height_unit) return *options.height_unit;
  const Georeference& map = info_.georeference;
  const std::string unit = GDALGetRasterUnitType(bands_.bands[0]);
  const std::optional<double> metres = heightUnit(unit);
  if (!metres)
    info_.notes.push_back(
        fmt::format("its heights are in '{}', which is unknown; taken as metres (--height-unit)", unit));
  else if (!unit.empty() && *metres != 1)
    info_.notes.push_back(
        fmt::format("its heights are in {}; converted to metres (--height-unit m takes them as they are)", unit));
  if (!unit.empty()) return metres.value_or(1);
  if (map.vertical_unit) {
    if (std::fabs(*map.vertical_unit - 1) > 1e-9)
      info_.notes.push_back(
          fmt::format("its heights are in {}, by its vertical reference system; converted to metres (--height-unit m "
                      "takes them as they are)",
                      map.vertical_unit_name));
    return *map.vertical_unit;
  }
  if (map.kind == MapKind::kProjected && !map.crs_wkt.empty() && std::fabs(map.unit - 1) > 1e-9)
    info_.notes.push_back(
        fmt::format("its map is in units of {:.6g} m, and nothing says what its heights are in; taken as metres "
                    "(--height-unit ft or us-ft)",
                    map.unit));
  return 1;
}

// Which of the two encodings the colours are heights by, if by either: under it, unlike a picture's, they lie on the
// earth and are smooth.
void GdalRaster::guessEncoding() {
  constexpr double kLowest_m = -11100, kHighest_m = 9000, kMaxMeanStep_m = 200;
  const GdalMessages silence;
  std::array<std::vector<float>, 3> colours;
  const int width = static_cast<int>(info_.width), row = static_cast<int>(info_.height / 2);
  for (size_t i = 0; i < 3; ++i) {
    colours[i].resize(info_.width);
    if (GDALRasterIO(GDALGetRasterBand(dataset_.get(), static_cast<int>(i) + 1), GF_Read, 0, row, width, 1,
                     colours[i].data(), width, 1, GDT_Float32, 0, 0) != CE_None)
      return;
  }
  for (const HeightEncoding encoding : {HeightEncoding::kTerrarium, HeightEncoding::kTerrainRgb}) {
    double step_m = 0, before = 0;
    bool is_on_earth = true;
    for (size_t x = 0; x < colours[0].size(); ++x) {
      const double h = heightOf(encoding, colours[0][x], colours[1][x], colours[2][x]);
      is_on_earth = is_on_earth && h >= kLowest_m && h <= kHighest_m;
      if (x > 0) step_m += std::fabs(h - before);
      before = h;
    }
    if (!is_on_earth || step_m > kMaxMeanStep_m * static_cast<double>(colours[0].size())) continue;
    encoding_ = encoding;
    info_.notes.push_back(
        fmt::format("its colours are heights, by their values as {0} has them (--encoding {0}; a picture: --imagery)",
                    encoding == HeightEncoding::kTerrarium ? "terrarium" : "terrain-rgb"));
    return;
  }
}

Status GdalRaster::init(const OpenOptions& options, const GdalMessages& messages) {
  if (info_.width < 2 || info_.height < 2)
    return Error{ErrorCode::kUnsupported, fmt::format("{}: {} x {} samples; a terrain needs at least 2 x 2", info_.name,
                                                      info_.width, info_.height)};
  noteFormat();
  if (Status s = pickBands(options); !s.ok()) return s;
  Result<Georeference> place = readGeoreference(dataset_.get(), info_.name, info_.notes);
  if (!place.ok()) return place.error();
  if (const std::string said = messages.all(); !said.empty())
    info_.notes.push_back("about its header GDAL says: " + said);
  info_.georeference = *place;
  decoder_ = makeDecoder(options);
  const ReadRaw read = [this](uint32_t first, uint32_t count, std::span<float> out) {
    return readRaw(first, count, out);
  };
  // Reading shows whether the file is damaged, which a picture is not, so this comes before the check for pictures.
  if (Status s = surveyHeights(info_.width, info_.height, read, *decoder_); !s.ok()) return s;
  info_.survey = decoder_->survey();
  if (encoding_ == HeightEncoding::kPlain && !options.channel && isPicture())
    return pictureError(info_.name, GDALGetRasterCount(dataset_.get()));
  for (std::string& note : decoder_->notes()) info_.notes.push_back(std::move(note));
  if (info_.survey.voids == info_.survey.samples)
    return Error{
        ErrorCode::kMalformed,
        fmt::format("{}: holds no heights, all {} samples are voids; if its nodata value is wrong, name "
                    "another with --nodata{}",
                    info_.name, info_.survey.samples, info_.notes.empty() ? "" : " (" + info_.notes.back() + ")")};
  return {};
}

Status GdalRaster::readBand(GDALRasterBandH band, uint32_t first, uint32_t count, std::span<float> out) {
  GdalMessages messages;
  const int w = static_cast<int>(info_.width), n = static_cast<int>(count);
  const CPLErr failed =
      GDALRasterIO(band, GF_Read, 0, static_cast<int>(first), w, n, out.data(), w, n, GDT_Float32, 0, 0);
  if (failed == CE_None && !messages.hasErrors()) return {};
  return Error{
      ErrorCode::kMalformed,
      fmt::format("{}: rows {} to {} cannot be read; the file is damaged or cut short, get it anew (GDAL says: {})",
                  info_.name, first, first + count - 1, messages.hasErrors() ? messages.errors() : "no reason")};
}

Status GdalRaster::readRaw(uint32_t first, uint32_t count, std::span<float> out) {
  if (Status s = readBand(bands_.bands[0], first, count, out); !s.ok()) return s;
  other_.resize(bands_.bands.size() > 1 || bands_.mask != nullptr ? out.size() : 0);
  if (bands_.bands.size() == 3) {
    third_.resize(out.size());
    if (Status s = readBand(bands_.bands[1], first, count, other_); !s.ok()) return s;
    if (Status s = readBand(bands_.bands[2], first, count, third_); !s.ok()) return s;
    for (size_t k = 0; k < out.size(); ++k)
      out[k] = static_cast<float>(heightOf(encoding_, out[k], other_[k], third_[k]));
  }
  if (bands_.mask == nullptr) return {};
  if (Status s = readBand(bands_.mask, first, count, other_); !s.ok()) return s;
  for (size_t k = 0; k < out.size(); ++k)
    if (other_[k] == 0) out[k] = kVoid;
  return {};
}

Error openError(const std::string& name, const std::string& said) {
  std::string hint = "not an elevation file that GDAL or OpenEXR recognises, or a damaged one";
  if (lower(name).ends_with(".hgt"))
    hint += "; an .hgt file must be named like N46E008.hgt and be 1201 x 1201 or 3601 x 3601 samples of 2 bytes";
  return {ErrorCode::kMalformed, fmt::format("{}: {}{}", name, hint, said.empty() ? "" : " (GDAL says: " + said + ")")};
}

// The same heights in another map: that of its control points, or latitude and longitude (`to`, a reference system as
// text). A view of `from`, which must outlive it. What is not covered is void.
Dataset warped(GDALDatasetH from, const std::string& to) {
  char** list = nullptr;
  for (const char* option : {"-of", "VRT", "-r", "bilinear", "-ot", "Float32", "-dstnodata", "nan"})
    list = CSLAddString(list, option);
  if (!to.empty()) list = CSLAddString(CSLAddString(list, "-t_srs"), to.c_str());
  GDALWarpAppOptions* options = GDALWarpAppOptionsNew(list, nullptr);
  GDALDatasetH sources[] = {from};
  Dataset out(options == nullptr ? nullptr : GDALWarp("", nullptr, 1, sources, options, nullptr));
  GDALWarpAppOptionsFree(options);
  CSLDestroy(list);
  return out;
}

// The name of the subdataset that holds the requested variable; subdataset names end in the variable's name.
Result<std::string> pickVariable(GDALDatasetH dataset, const std::string& name, const OpenOptions& options) {
  char** list = GDALGetMetadata(dataset, "SUBDATASETS");
  std::string known;
  for (int i = 1; const char* variable = CSLFetchNameValue(list, fmt::format("SUBDATASET_{}_NAME", i).c_str()); ++i) {
    const std::string full = variable;
    const std::string last = full.substr(full.find_last_of(":/") + 1);
    if (options.channel && *options.channel == last) return full;
    known += (known.empty() ? "" : ", ") + last;
  }
  if (known.empty()) return Error{ErrorCode::kUnsupported, name + ": holds no raster"};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{}: holds several variables; choose one with --channel: {}", name, known)};
}

// How many units of a projected map a metre of ground takes in the middle of the data, along x and y: 1 in most, 2 in
// Mercator's at 60 degrees. Nothing where it cannot be told.
std::optional<double> scaleOfMap(GDALDatasetH dataset) {
  const GdalMessages silence;
  std::array<double, 6> t{};
  OGRSpatialReferenceH crs = GDALGetSpatialRef(dataset);
  if (crs == nullptr || !OSRIsProjected(crs) || GDALGetGeoTransform(dataset, t.data()) != CE_None) return std::nullopt;
  const std::unique_ptr<void, decltype(&OSRDestroySpatialReference)> geographic(OSRCloneGeogCS(crs),
                                                                                OSRDestroySpatialReference);
  if (!geographic) return std::nullopt;
  OSRSetAxisMappingStrategy(geographic.get(), OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<void, decltype(&OCTDestroyCoordinateTransformation)> transformation(
      OCTNewCoordinateTransformation(crs, geographic.get()), OCTDestroyCoordinateTransformation);
  if (!transformation) return std::nullopt;
  const double column = 0.5 * GDALGetRasterXSize(dataset), row = 0.5 * GDALGetRasterYSize(dataset);
  const double cx = t[0] + column * t[1] + row * t[2], cy = t[3] + column * t[4] + row * t[5],
               unit = OSRGetLinearUnits(crs, nullptr);
  const double step = 100 / unit;  // 100 m of the map, either way
  std::array<double, 4> x{cx - step, cx + step, cx, cx}, y{cy, cy, cy - step, cy + step};
  if (!OCTTransform(transformation.get(), 4, x.data(), y.data(), nullptr)) return std::nullopt;
  const double degree = OSRGetAngularUnits(geographic.get(), nullptr), a = OSRGetSemiMajor(geographic.get(), nullptr);
  const double f =
      OSRGetInvFlattening(geographic.get(), nullptr) > 0 ? 1 / OSRGetInvFlattening(geographic.get(), nullptr) : 0;
  const double latitude = 0.25 * (y[0] + y[1] + y[2] + y[3]) * degree, e2 = f * (2 - f);
  const double w = std::sqrt(1 - e2 * std::sin(latitude) * std::sin(latitude));
  const double east = a / w * std::cos(latitude), north = a * (1 - e2) / (w * w * w);  // metres a radian
  const auto length = [&](size_t i, size_t k) {
    return std::hypot(east * (x[k] - x[i]) * degree, north * (y[k] - y[i]) * degree);
  };
  const double scale_x = 200 / length(0, 1), scale_y = 200 / length(2, 3);
  if (!std::isfinite(scale_x) || !std::isfinite(scale_y)) return std::nullopt;
  return std::fabs(scale_x - 1) > std::fabs(scale_y - 1) ? scale_x : scale_y;
}

std::string geographicOf(OGRSpatialReferenceH crs) {
  OGRSpatialReferenceH geographic = OSRCloneGeogCS(crs);
  char* text = nullptr;
  if (geographic != nullptr) OSRExportToWkt(geographic, &text);
  const std::string wkt = text != nullptr ? text : "";
  CPLFree(text);
  if (geographic != nullptr) OSRDestroySpatialReference(geographic);
  return wkt;
}

// The dataset on a map whose distances are those of the ground: one that has control points alone is warped to their
// map, and one whose map is off by more than 0.5 % here to latitude and longitude, unless the user wants the map.
Result<Dataset> onTrueMap(Dataset dataset, const std::string& name, const OpenOptions& options,
                          std::vector<Dataset>& sources, std::vector<std::string>& notes) {
  constexpr double kMaxOff = 0.005;
  std::array<double, 6> t{};
  if (const int points = GDALGetGCPCount(dataset.get());
      points > 0 && GDALGetGeoTransform(dataset.get(), t.data()) != CE_None) {
    GdalMessages messages;
    Dataset placed = warped(dataset.get(), "");
    if (!placed)
      return Error{ErrorCode::kUnsupported, fmt::format("{}: its {} control points do not place it (GDAL says: {}); "
                                                        "try gdalwarp -tps -dstnodata -9999 {} placed.tif",
                                                        name, points, messages.errors(), name)};
    notes.push_back(fmt::format("it is placed by {} control points, and was warped to their map", points));
    sources.push_back(std::exchange(dataset, std::move(placed)));
  }
  const std::optional<double> scale = scaleOfMap(dataset.get());
  if (!scale || std::fabs(*scale - 1) <= kMaxOff) return dataset;
  const char* map = OSRGetName(GDALGetSpatialRef(dataset.get()));
  if (options.frame == FrameChoice::kPlanar) {
    notes.push_back(fmt::format(
        "its map ({}) shows distances {:.3g} times as long as they are here, and slopes as much flatter", map, *scale));
    return dataset;
  }
  Dataset placed = warped(dataset.get(), geographicOf(GDALGetSpatialRef(dataset.get())));
  if (!placed) return dataset;
  notes.push_back(
      fmt::format("its map ({}) shows distances {:.3g} times as long as they are here, so it was warped to latitude "
                  "and longitude (--frame projected keeps the map)",
                  map, *scale));
  sources.push_back(std::move(dataset));
  return placed;
}

// An Error where the file named another one that must not be read, whatever became of it.
Status checkRefused(const GdalFence* fence, const std::string& name) {
  const auto refused = fence != nullptr ? fence->takeRefused() : std::nullopt;
  return refused ? Status(FileFence::refusal(name, *refused)) : Status();
}

Result<std::unique_ptr<Raster>> openOne(const std::string& gdal_path, const std::string& name, OpenOptions options,
                                        const std::shared_ptr<const GdalFence>& fence) {
  GdalMessages messages;
  if (fence)
    if (Status s = checkVrt(gdal_path, name, fence->files()); !s.ok()) return s.error();
  Dataset dataset(GDALOpenEx(gdal_path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, nullptr,
                             nullptr, nullptr));
  if (Status s = checkRefused(fence.get(), name); !s.ok()) return s.error();
  if (!dataset) return openError(name, messages.errors());
  if (GDALGetRasterCount(dataset.get()) == 0) {
    const Result<std::string> variable = pickVariable(dataset.get(), name, options);
    if (!variable.ok()) return variable.error();
    if (fence)
      if (Status s = checkSubdataset(*variable, gdal_path, name, fence->files()); !s.ok()) return s.error();
    dataset.reset(GDALOpenEx(variable->c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, nullptr,
                             nullptr, nullptr));
    if (!dataset) return openError(name, messages.errors());
    options.channel.reset();
  }
  std::vector<std::string> notes;
  std::vector<Dataset> sources;
  Result<Dataset> placed = onTrueMap(std::move(dataset), name, options, sources, notes);
  if (!placed.ok()) return placed.error();
  dataset = std::move(placed).value();
  auto raster = std::make_unique<GdalRaster>(std::move(dataset), name, fence);
  raster->keep(std::move(sources), std::move(notes));
  const Status read = raster->init(options, messages);
  if (Status s = checkRefused(fence.get(), name); !s.ok()) return s.error();
  if (!read.ok()) return read.error();
  return std::unique_ptr<Raster>(std::move(raster));
}

struct Member {
  std::string gdal_path, name;
};

// The rasters inside an archive.
Result<std::vector<Member>> listArchive(const std::string& path) {
  GdalMessages messages;
  const std::string root = "/vsizip/{" + path + "}";
  char** names = VSIReadDirRecursive(root.c_str());
  std::vector<Member> members;
  for (int i = 0; names != nullptr && names[i] != nullptr; ++i) {
    const std::string inside = names[i];
    if (inside.ends_with('/') || inside.starts_with("__MACOSX")) continue;
    const std::string full = root + "/" + inside;
    if (GDALIdentifyDriverEx(full.c_str(), GDAL_OF_RASTER, nullptr, nullptr) != nullptr)
      members.push_back({full, path + "/" + inside});
  }
  CSLDestroy(names);
  if (!members.empty()) return members;
  return Error{ErrorCode::kMalformed,
               fmt::format("{}: an archive without an elevation file in it, or a damaged one{}", path,
                           messages.hasErrors() ? " (GDAL says: " + messages.errors() + ")" : "; see unzip -l")};
}

}  // namespace

void registerGdalDrivers(bool all) {
  static std::once_flag once;
  std::call_once(once, [all] {
    CPLSetConfigOption("GDAL_CACHEMAX", "256");  // MB
    CPLSetConfigOption("GDAL_DRIVER_PATH", "disable");
    CPLSetConfigOption("GDAL_VRT_ENABLE_PYTHON", "NO");
    GDALAllRegister();
    if (!all) closeGdalFileSystems();
  });
}

Result<std::vector<std::unique_ptr<Raster>>> openGdalRasters(const std::filesystem::path& path,
                                                             const OpenOptions& options) {
  registerGdalDrivers();
  const auto fence = options.is_fenced
                         ? std::make_shared<const GdalFence>(FileFence(std::array{path}, options.allowed_folders))
                         : nullptr;
  const std::string name = path.string(), suffix = lower(path.extension().string());
  std::vector<Member> members{{suffix == ".gz" ? "/vsigzip/" + name : name, name}};
  if (suffix == ".zip") {
    Result<std::vector<Member>> listed = listArchive(name);
    if (!listed.ok()) return listed.error();
    members = std::move(listed).value();
  }
  std::vector<std::unique_ptr<Raster>> rasters;
  for (const Member& member : members) {
    Result<std::unique_ptr<Raster>> raster = openOne(member.gdal_path, member.name, options, fence);
    if (!raster.ok()) return raster.error();
    rasters.push_back(std::move(raster).value());
  }
  return rasters;
}

}  // namespace foreland::terrain
