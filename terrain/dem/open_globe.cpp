#include "terrain/dem/open_globe.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>
#include <utility>

#include "terrain/dem/globe_layers.h"
#include "terrain/dem/insets/feather.h"
#include "terrain/dem/mosaic/mosaic_source.h"
#include "terrain/dem/mosaic/placement.h"
#include "terrain/dem/mosaic_info.h"
#include "terrain/dem/opened_inputs.h"
#include "terrain/dem/planet/planet_raster.h"
#include "terrain/dem/vertical/fit_undulations.h"
#include "terrain/dem/voids/voids.h"

namespace foreland::terrain {

namespace {

constexpr double kDegrees = std::numbers::pi / 180;  // in radians
constexpr uint32_t kBaseRows = 256;

// The base, its layers from the lowest on, and a geoid under all of them.
class Globe final : public GlobeSource {
 public:
  Globe(PlanetRaster base, std::vector<GlobeLayer> layers, bool is_above_geoid, GlobeInfo info)
      : base_(std::move(base)), layers_(std::move(layers)), is_above_geoid_(is_above_geoid), info_(std::move(info)) {}

  const GlobeInfo& info() const override { return info_; }

  GlobeHeight heightAt(const glm::dvec3& direction) const override {
    const glm::dvec3 unit = glm::normalize(direction);
    const glm::dvec2 degrees = degreesOf(unit);
    GlobeHeight at{base_.heightAt(degrees), static_cast<int>(layers_.size())};
    for (size_t i = 0; i < layers_.size(); ++i)
      if (layers_[i].mayMeet(unit, 0)) lay(i, degrees, at);
    at.metres += undulationAt(degrees);
    return at;
  }

  double spacingIn(const GlobePatch& patch) const override {
    double finest_m = info_.inputs.back().spacing_m;
    for (const GlobeLayer& layer : layers_)
      if (layer.spacing() < finest_m && layer.meets(patch)) finest_m = layer.spacing();
    return finest_m;
  }

  uint32_t rowsOf(size_t input) const override {
    return input == layers_.size() ? base_.rows() : layerOf(input).layer().samples.height;
  }

  void samplesOf(size_t input, uint32_t row, std::vector<GlobeSample>& out) const override {
    const size_t first = out.size();
    if (input == layers_.size()) {
      for (uint32_t x = 0; x < base_.columns(); ++x)
        out.push_back({directionOf(base_.degreesOf(x, row)), base_.sampleAt(x, row)});
    } else {
      layerOf(input).samplesOf(row, out);
    }
    for (size_t i = first; i < out.size(); ++i) out[i].metres += undulationAt(degreesOf(out[i].direction));
  }

 private:
  // Inputs are listed from the uppermost on.
  const GlobeLayer& layerOf(size_t input) const { return layers_[layers_.size() - 1 - input]; }

  double undulationAt(glm::dvec2 degrees) const { return is_above_geoid_ ? info_.vertical.undulations.at(degrees) : 0; }

  void lay(size_t index, glm::dvec2 degrees, GlobeHeight& at) const {
    std::vector<glm::dvec2> place{degrees};
    layers_[index].toSamples(place);
    const Layer& layer = layers_[index].layer();
    const double height_m = cubicHeight(layer.samples, place[0]);
    if (std::isnan(height_m)) return;
    const double weight = weightAt(layer.samples, layer.weights, place[0]);
    at.metres = weight == 1 ? height_m : at.metres + weight * (height_m - at.metres);
    if (weight > 0) at.owner = weight == 1 ? static_cast<int>(layers_.size() - 1 - index) : GlobeHeight::kMixed;
  }

  PlanetRaster base_;
  std::vector<GlobeLayer> layers_;
  bool is_above_geoid_;
  GlobeInfo info_;
};

struct GlobeBase {
  PlanetRaster raster;
  LatticePlace lattice;
};

Result<Samples> readSamples(ElevationSource& source) {
  Samples out{source.info().width, source.info().height, {}};
  out.metres.resize(size_t{out.width} * out.height);
  for (uint32_t row = 0; row < out.height; row += kBaseRows) {
    const uint32_t count = std::min(kBaseRows, out.height - row);
    const auto rows = std::span(out.metres).subspan(size_t{row} * out.width, size_t{count} * out.width);
    if (Status s = source.readRows(row, count, rows); !s.ok()) return s.error();
  }
  return out;
}

Result<GlobeBase> readGlobeBase(Mosaic mosaic, const OpenOptions& options, GlobeInfo& info) {
  const std::string name = mosaic.tiles.front().raster->info().name;
  const Georeference map = mosaic.map;
  const auto placement = placeRaster(map, {titleOf(mosaic), mosaic.width, mosaic.height, 0, 0}, options);
  if (!placement.ok()) return placement.error();
  const proto::Frame& frame = placement->frame;
  if (frame.kind != proto::FrameKind::kGeographic)
    return Error{ErrorCode::kInvalidArgument,
                 name +
                     ": a globe's first input must go around it in latitude and longitude; what covers a part comes "
                     "as --inset"};
  info.title = titleOf(mosaic);
  info.crs_wkt = map.crs_wkt;
  info.semi_major_m = frame.semi_major_m;
  info.flattening = frame.flattening;
  for (const std::string& note : mosaic.notes) info.notes.push_back(note);
  for (const std::string& note : placement->notes) info.notes.push_back(note);
  GlobeInput input{.files = {}, .vertical = mosaic.tiles.front().vertical};
  for (const Tile& tile : mosaic.tiles)
    input.files.push_back(std::filesystem::path(tile.raster->info().name).filename().string());
  ElevationInfo size;
  size.width = mosaic.width, size.height = mosaic.height;
  const auto source = mosaicSource(std::move(mosaic), *placement, std::move(size));
  auto samples = readSamples(*source);
  if (!samples.ok()) return samples.error();
  for (const std::string& warning : source->warnings()) info.warnings.push_back(warning);
  const VoidReport voids = fillVoids(samples->metres, samples->width, samples->height);
  if (voids.all_void)
    return Error{ErrorCode::kMalformed, name + ": holds no data, only voids; check the file and --nodata"};
  if (!voids.note.empty()) info.notes.push_back(voids.note);
  info.voids_filled = voids.samples;
  auto raster = PlanetRaster::of(std::move(*samples), glm::dvec2(frame.longitude0_rad, frame.latitude0_rad) / kDegrees,
                                 glm::dvec2(frame.longitude_step_rad, frame.latitude_step_rad) / kDegrees);
  if (!raster.ok()) return Error{raster.error().code, name + ": " + raster.error().message};
  input.spacing_m = frame.latitude_step_rad * frame.semi_major_m;
  input.samples = uint64_t{raster->columns()} * raster->rows();
  info.inputs.push_back(std::move(input));
  return GlobeBase{std::move(*raster), degreeLattice(map, name)};
}

// Heights become those above the ellipsoid; the geoid's undulations are kept, by degrees.
Status setDatum(const std::optional<Datum>& datum, GlobeInfo& info) {
  if (!datum) {
    info.notes.push_back(
        "nothing says what the heights are above, so they are taken as above the ellipsoid, from which "
        "the sea lies up to 107 m on the earth; --vertical egm96 says that they are above the sea");
    return {};
  }
  info.vertical = {proto::ZeroSurface::kEllipsoid, kEllipsoidName, {}, {}};
  const HeightReference& geoid = datum->geoid;
  const bool must_know = datum->scene.zero_surface == proto::ZeroSurface::kGeoid;
  if (!geoid.geoid) {
    if (must_know) return Error{ErrorCode::kNotFound, datum->scene.name + ": " + geoid.why_unknown};
    return {};
  }
  const glm::dvec2 origin(-180, -90);
  std::optional<LatticeLines> lines;
  if (const auto known = geoid.geoid->lines()) lines = LatticeLines{known->first_degrees - origin, known->step_degrees};
  std::vector<glm::dvec2> degrees;
  auto grid = fitUndulations(361, 181, lines, [&](std::span<const glm::dvec2> places, std::span<double> out) {
    degrees.clear();
    for (const glm::dvec2& p : places) degrees.push_back(p + origin);
    geoid.geoid->undulations(degrees, out);
  });
  if (!grid) {
    if (must_know)
      return Error{ErrorCode::kInvalidArgument, geoid.name + ": its grid of undulations does not cover the globe"};
    info.notes.push_back("undulations of " + geoid.name + " are not known: its grid does not cover the globe");
    return {};
  }
  grid->first += origin;
  info.vertical.geoid = geoid.name;
  info.vertical.undulations = std::move(*grid);
  return {};
}

}  // namespace

Result<std::unique_ptr<GlobeSource>> openGlobe(const std::vector<std::filesystem::path>& inputs,
                                               const OpenOptions& options) {
  auto opened = openInputs(inputs, options);
  if (!opened.ok()) return opened.error();
  GlobeInfo info;
  info.notes = std::move(opened->notes);
  auto base = readGlobeBase(std::move(opened->base), options, info);
  if (!base.ok()) return base.error();
  if (Status s = setDatum(opened->datum, info); !s.ok()) return s.error();
  std::vector<GlobeInput> laid;
  auto layers =
      globeLayers(std::move(opened->others), base->lattice, info.inputs.back().spacing_m, options, info, laid);
  if (!layers.ok()) return layers.error();
  for (GlobeInput& input : laid) info.inputs.insert(info.inputs.begin(), std::move(input));
  const bool is_above_geoid = opened->datum && opened->datum->scene.zero_surface == proto::ZeroSurface::kGeoid;
  return std::unique_ptr<GlobeSource>(
      new Globe(std::move(base->raster), std::move(*layers), is_above_geoid, std::move(info)));
}

}  // namespace foreland::terrain
