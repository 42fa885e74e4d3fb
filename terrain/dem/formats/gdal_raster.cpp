#include "terrain/dem/formats/gdal_raster.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal.h>

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
#include "terrain/dem/formats/true_map.h"
#include "terrain/dem/raster/height_decoder.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

namespace {

constexpr uint32_t kMostSide = 1u << 24;

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
  if (count < 3)
    return {ErrorCode::kUnsupported,
            name + ": a picture with a palette, not heights; --imagery lays it over elevation"};
  return {ErrorCode::kUnsupported,
          fmt::format("{}: a picture with {} bands of 8 bits, not heights; if its colours encode heights, say "
                      "--encoding terrarium or terrain-rgb; --imagery lays it over elevation",
                      name, count)};
}

class GdalRaster final : public Raster {
 public:
  GdalRaster(TrueMap map, std::string name, std::shared_ptr<const GdalFence> fence)
      : fence_(std::move(fence)), sources_(std::move(map.sources)), dataset_(std::move(map.dataset)) {
    info_.name = std::move(name);
    info_.notes = std::move(map.notes);
    info_.width = static_cast<uint32_t>(GDALGetRasterXSize(dataset_.get()));
    info_.height = static_cast<uint32_t>(GDALGetRasterYSize(dataset_.get()));
  }

  // `messages` holds what GDAL said while the dataset was opened, and collects what it says from then on.
  Status init(const OpenOptions& options, const GdalMessages& messages);

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
  std::vector<GdalDataset> sources_;        // that the dataset is a view of; closed after it
  GdalDataset dataset_;
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
  if (std::max(info_.width, info_.height) > kMostSide)
    return Error{
        ErrorCode::kLimit,
        fmt::format("{}: {} x {} samples, more than 2^24 a side; cut out what the scene shows with gdal_translate "
                    "-projwin, or make it coarser with -tr",
                    info_.name, info_.width, info_.height)};
  noteFormat();
  if (Status s = pickBands(options); !s.ok()) return s;
  Result<Georeference> place = readGeoreference(dataset_.get(), info_.name, info_.notes);
  if (!place.ok()) return place.error();
  if (const std::string said = messages.all(); !said.empty())
    info_.notes.push_back("about its header GDAL says: " + said);
  info_.georeference = *place;
  if (!sources_.empty()) readHeightStatement(GDALGetSpatialRef(sources_.front().get()), info_.georeference);
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

Result<std::unique_ptr<Raster>> openOne(const std::string& gdal_path, const std::string& name, OpenOptions options,
                                        const std::shared_ptr<const GdalFence>& fence) {
  GdalMessages messages;
  Result<GdalDataset> dataset = openFenced(fence.get(), gdal_path, name);
  if (!dataset.ok()) return dataset.error();
  if (!*dataset) return openError(name, messages.errors());
  if (GDALGetRasterCount(dataset->get()) == 0) {
    const Result<std::string> variable = pickVariable(dataset->get(), name, options);
    if (!variable.ok()) return variable.error();
    dataset = openSubdataset(fence.get(), *variable, gdal_path, name);
    if (!dataset.ok()) return dataset.error();
    if (!*dataset) return openError(name, messages.errors());
    options.channel.reset();
  }
  const MapUse use = options.keeps_map                       ? MapUse::kPlace
                     : options.frame == FrameChoice::kPlanar ? MapUse::kKeep
                                                             : MapUse::kGround;
  Result<TrueMap> placed = onTrueMap(std::move(*dataset), name, use);
  if (!placed.ok()) return placed.error();
  auto raster = std::make_unique<GdalRaster>(std::move(*placed), name, fence);
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
