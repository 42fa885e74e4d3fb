#include "apps/fly/globe_sources.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>

#include "apps/globe_inputs.h"
#include "base/bytes.h"
#include "oracle/globe/source_samples.h"
#include "terrain/dem/opened_inputs.h"
#include "terrain/dem/vertical/map_places.h"
#include "terrain/fence/confined_child.h"
#include "terrain/fence/file_fence.h"

namespace foreland::apps {

namespace {

using oracle::SourceBlock;
using oracle::SourceRaster;

constexpr size_t kMaxBytes = size_t{1} << 33;
constexpr uint8_t kSamples = 1, kError = 0;

// Heights become those above the ellipsoid, by the geoid's undulation at each sample.
Result<SourceRaster> readRaster(terrain::Tile& tile, const terrain::Scene& scene, const terrain::Datum* datum) {
  const terrain::RasterInfo& info = tile.raster->info();
  const std::string file = std::filesystem::path(info.name).filename().string();
  const auto stated = std::ranges::find(scene.inputs(), file, &terrain::SceneInput::name);
  if (stated == scene.inputs().end())
    return Error{ErrorCode::kInvalidArgument, info.name + ": the scene names no such input; see foreland info"};
  const auto places = terrain::MapPlaces::of(tile.map, info.name);
  if (!places) return places.error();
  SourceRaster out{static_cast<uint32_t>(stated - scene.inputs().begin()), info.width, info.height, {}, {}};
  const size_t count = size_t{info.width} * info.height;
  out.degrees.reserve(count), out.metres.reserve(count);
  std::vector<float> row(info.width);
  std::vector<double> undulations(info.width);
  std::vector<glm::dvec2> degrees(info.width);
  const bool is_above_geoid = datum != nullptr && datum->scene.zero_surface == proto::ZeroSurface::kGeoid;
  if (is_above_geoid && !datum->scene.geoid) return Error{ErrorCode::kNotFound, datum->scene.why_unknown};
  for (uint32_t y = 0; y < info.height; ++y) {
    if (Status s = tile.raster->readRows(y, 1, row); !s.ok()) return s.error();
    for (uint32_t x = 0; x < info.width; ++x) degrees[x] = {x, y};
    places->toDegrees(degrees);
    if (is_above_geoid) datum->scene.geoid->undulations(degrees, undulations);
    out.degrees.insert(out.degrees.end(), degrees.begin(), degrees.end());
    for (uint32_t x = 0; x < info.width; ++x) out.metres.push_back(double{row[x]} + undulations[x]);
  }
  return out;
}

Result<std::vector<SourceBlock>> readSamples(const terrain::Scene& scene, const GlobeInputs& inputs) {
  auto opened = terrain::openInputs(inputs.base, inputs.open);
  if (!opened.ok()) return opened.error();
  std::vector<terrain::Tile*> tiles;
  for (terrain::Tile& tile : opened->base.tiles) tiles.push_back(&tile);
  for (terrain::LaidTile& laid : opened->others) tiles.push_back(&laid.tile);
  std::vector<SourceRaster> rasters;
  for (terrain::Tile* tile : tiles) {
    auto raster = readRaster(*tile, scene, opened->datum ? &*opened->datum : nullptr);
    if (!raster.ok()) return raster.error();
    rasters.push_back(std::move(*raster));
  }
  return oracle::samplesAlone(scene, rasters);
}

// What the child answers: samples, or the text of an error.
Bytes encode(const Result<std::vector<SourceBlock>>& blocks) {
  Bytes out;
  ByteWriter to(out);
  to.put(blocks.ok() ? kSamples : kError);
  if (!blocks.ok()) {
    const std::string& text = blocks.error().message;
    to.putBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    return out;
  }
  for (const SourceBlock& block : *blocks) {
    to.putVarint(block.input);
    to.putVarint(block.samples.size());
    for (const proto::Geodetic& at : block.samples)
      to.put(at.latitude_rad), to.put(at.longitude_rad), to.put(at.height_m);
  }
  return out;
}

bool isOnEarth(const proto::Geodetic& at) {
  constexpr double kMostAngle = 10, kMostHeight_m = 1e6;
  return std::fabs(at.latitude_rad) < kMostAngle && std::fabs(at.longitude_rad) < kMostAngle &&
         std::fabs(at.height_m) < kMostHeight_m;
}

Result<std::vector<SourceBlock>> decode(ByteSpan bytes, size_t inputs) {
  const Error damaged{ErrorCode::kMalformed, "--source: its reader's answer is damaged"};
  ByteReader from(bytes);
  if (from.get<uint8_t>() == kError) {
    const ByteSpan text = from.getBytes(from.remaining());
    return Error{ErrorCode::kInvalidArgument, std::string(text.begin(), text.end())};
  }
  std::vector<SourceBlock> out;
  while (from.ok() && from.remaining() > 0) {
    const uint64_t input = from.getVarint(), count = from.getVarint();
    if (input >= inputs || count > from.remaining() / (3 * sizeof(double))) return damaged;
    SourceBlock& block = out.emplace_back();
    block.input = static_cast<uint32_t>(input);
    block.samples.resize(count);
    for (proto::Geodetic& at : block.samples) {
      at = {from.get<double>(), from.get<double>(), from.get<double>()};
      if (!isOnEarth(at)) return damaged;
    }
  }
  if (!from.ok()) return damaged;
  return out;
}

}  // namespace

Result<oracle::SourceOracle> sourceOracle(const terrain::Scene& scene, const std::vector<std::string>& sources,
                                          const ForeignFiles& foreign) {
  if (!scene.grid().isCube())
    return Error{ErrorCode::kUnsupported,
                 "--source: flights over globes alone are judged against files; `foreland verify --source` compares "
                 "other scenes with theirs, and --truth flights with the scene"};
  const auto inputs = globeInputs(scene, sources, foreign);
  if (!inputs.ok()) return inputs.error();
  const terrain::FileFence fence(filesOfSources(sources), foreign.allowed);
  terrain::Confinement confinement{fence.folders(), {}};
  confinement.read.insert(confinement.read.end(), fence.files().begin(), fence.files().end());
  const auto answer =
      terrain::inConfinedChild(confinement, kMaxBytes, [&] { return encode(readSamples(scene, *inputs)); });
  if (!answer.ok()) return answer.error();
  const auto blocks = decode(*answer, scene.inputs().size());
  if (!blocks.ok()) return blocks.error();
  return oracle::SourceOracle(scene, *blocks);
}

}  // namespace foreland::apps
