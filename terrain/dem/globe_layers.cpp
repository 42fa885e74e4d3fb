#include "terrain/dem/globe_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <tuple>
#include <utility>

#include "terrain/dem/insets/feather.h"
#include "terrain/dem/voids/void_regions.h"
#include "terrain/dem/voids/voids.h"
#include "terrain/geo/geodesy.h"

namespace foreland::terrain {

namespace {

constexpr double kRadian = std::numbers::pi / 180;
constexpr size_t kMostRuns = 1u << 24, kSmallGap = 50;  // of a raster's samples one in so many
constexpr double kWide = 0.05;    // radians: patches that are wider are judged by their cones alone
constexpr uint32_t kSurvey = 17;  // rows and columns of samples that a raster is surveyed at

// Metres between columns and between rows of a raster, at a sample.
std::optional<glm::dvec2> spacingAt(const LayerPlace& place, const Ellipsoid& ellipsoid, glm::dvec2 sample) {
  std::vector<glm::dvec2> p{sample, sample + glm::dvec2(1, 0), sample + glm::dvec2(0, 1)};
  place.places.toLattice(p);
  if (std::isnan(p[0].x + p[1].x + p[2].x)) return std::nullopt;
  const glm::dvec2 metres = metresPerRadian(ellipsoid, (p[0].y - 90) * kRadian) * kRadian;
  return glm::dvec2(glm::length((p[1] - p[0]) * metres), glm::length((p[2] - p[0]) * metres));
}

Result<glm::dvec2> spacingOf(const TileGroup& group, const LayerPlace& place, const Ellipsoid& ellipsoid) {
  std::vector<double> columns, rows;
  const glm::dvec2 last(group.mosaic.width - 2.0, group.mosaic.height - 2.0);
  for (uint32_t y = 0; y < kSurvey; ++y)
    for (uint32_t x = 0; x < kSurvey; ++x)
      if (const auto s = spacingAt(place, ellipsoid, last * glm::dvec2(x, y) / (kSurvey - 1.0)))
        columns.push_back(s->x), rows.push_back(s->y);
  if (columns.empty())
    return Error{ErrorCode::kInvalidArgument, group.name + ": none of its samples has a place on the globe"};
  return glm::dvec2(medianOf(columns), medianOf(rows));
}

struct GlobeGroup {
  TileGroup group;
  LayerPlace place;
  glm::dvec2 spacing_m;

  double resolution() const { return std::sqrt(spacing_m.x * spacing_m.y); }
};

double featherOnGlobe(const GlobeGroup& g, double base_spacing_m, const OpenOptions& options) {
  if (options.feather_m) return *options.feather_m;
  const glm::dvec2 sides_m = glm::dvec2(g.group.mosaic.width, g.group.mosaic.height) * g.spacing_m;
  return base_spacing_m * defaultFeather(sides_m / base_spacing_m);
}

auto rankOnGlobe(const GlobeGroup& g) { return std::tuple(g.group.priority.has_value(), g.group.priority.value_or(0)); }

GlobeInput describeLayer(const GlobeGroup& g, double feather_m) {
  GlobeInput input{.files = {},
                   .vertical = g.group.mosaic.tiles.front().vertical,
                   .spacing_m = g.resolution(),
                   .feather_m = feather_m,
                   .samples = uint64_t{g.group.mosaic.width} * g.group.mosaic.height};
  for (const Tile& tile : g.group.mosaic.tiles)
    input.files.push_back(std::filesystem::path(tile.raster->info().name).filename().string());
  return input;
}

// Fills regions of voids that are small against a raster: its edges are mixed with what is below over a distance that
// is large where the base is coarse, and around each of many gaps little would be left of it. Returns how many samples.
uint64_t fillGaps(Samples& samples) {
  const auto found = findVoidRegions(samples.metres, samples.width, samples.height, kMostRuns);
  if (!found || found->runs.empty()) return 0;
  std::vector<float> filled = samples.metres;
  if (fillVoids(filled, samples.width, samples.height).all_void) return 0;
  uint64_t count = 0;
  for (const VoidRun& run : found->runs) {
    if (found->regions[run.region].samples > samples.metres.size() / kSmallGap) continue;
    const auto begin = static_cast<std::ptrdiff_t>(size_t{run.row} * samples.width + run.begin);
    std::copy_n(filled.begin() + begin, run.end - run.begin, samples.metres.begin() + begin);
    count += run.end - run.begin;
  }
  return count;
}

double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

glm::dvec2 degreesOf(const glm::dvec3& d) {
  return {std::atan2(d.y, d.x) / kRadian, std::atan2(d.z, std::hypot(d.x, d.y)) / kRadian};
}

glm::dvec3 directionOf(glm::dvec2 degrees) {
  const double lon = degrees.x * kRadian, lat = degrees.y * kRadian;
  return {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
}

LatticePlace degreeLattice(const Georeference& base, const std::string& name) {
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGeographic;
  frame.latitude0_rad = -90 * kRadian;
  frame.longitude0_rad = -180 * kRadian;
  frame.latitude_step_rad = frame.longitude_step_rad = kRadian;
  frame.semi_major_m = base.ellipsoid.semi_major_m;
  frame.flattening = base.ellipsoid.flattening;
  return {frame, 361, 181, base.crs_wkt, name};
}

GlobeLayer::GlobeLayer(Layer layer, glm::dvec2 spacing_m)
    : layer_(std::move(layer)),
      spacing_m_(std::sqrt(spacing_m.x * spacing_m.y)),
      mutex_(std::make_unique<std::mutex>()) {
  const Samples& s = layer_.samples;
  std::vector<glm::dvec2> net;
  for (uint32_t y = 0; y < kSurvey; ++y)
    for (uint32_t x = 0; x < kSurvey; ++x)
      net.push_back(glm::dvec2(s.width - 1.0, s.height - 1.0) * glm::dvec2(x, y) / (kSurvey - 1.0));
  layer_.to_lattice(net);
  glm::dvec3 sum(0);
  for (const glm::dvec2& p : net) {
    if (std::isnan(p.x)) return;  // it may lie anywhere
    sum += directionOf(p - glm::dvec2(180, 90));
  }
  if (!(glm::length(sum) > 0.1 * kSurvey * kSurvey)) return;  // around the body
  middle_ = glm::normalize(sum);
  angle_rad_ = 0;
  for (const glm::dvec2& p : net)
    angle_rad_ = std::max(angle_rad_, angleBetween(middle_, directionOf(p - glm::dvec2(180, 90))));
  angle_rad_ *= 1.02;  // a net misses a little of curved borders
}

bool GlobeLayer::mayMeet(const glm::dvec3& middle, double angle_rad) const {
  const double reach = angle_rad_ + angle_rad;
  return reach >= std::numbers::pi || glm::dot(middle, middle_) >= std::cos(reach);
}

void GlobeLayer::toSamples(std::vector<glm::dvec2>& degrees) const {
  for (glm::dvec2& p : degrees) p += glm::dvec2(180, 90);
  const std::lock_guard lock(*mutex_);
  layer_.to_samples(degrees);
}

bool GlobeLayer::meets(const GlobePatch& patch) const {
  if (!mayMeet(patch.middle, patch.angle_rad)) return false;
  if (patch.angle_rad > kWide) return true;
  std::vector<glm::dvec2> net;
  for (const glm::dvec3& d : patch.directions) net.push_back(degreesOf(d));
  toSamples(net);
  glm::dvec2 low(INFINITY), high(-INFINITY);
  for (const glm::dvec2& p : net)
    if (!std::isnan(p.x)) low = glm::min(low, p), high = glm::max(high, p);
  const glm::dvec2 ring = 1.0 + 0.5 * (high - low) / std::max(1.0, patch.side - 1.0);
  low -= ring, high += ring;
  return low.x <= layer_.samples.width - 1.0 && low.y <= layer_.samples.height - 1.0 && high.x >= 0 && high.y >= 0;
}

void GlobeLayer::samplesOf(uint32_t row, std::vector<GlobeSample>& out) const {
  std::vector<glm::dvec2> places;
  for (uint32_t x = 0; x < layer_.samples.width; ++x) places.emplace_back(x, row);
  {
    const std::lock_guard lock(*mutex_);
    layer_.to_lattice(places);
  }
  for (uint32_t x = 0; x < layer_.samples.width; ++x)
    if (const float h = layer_.samples.at(x, row); !std::isnan(h) && !std::isnan(places[x].x))
      out.push_back({directionOf(places[x] - glm::dvec2(180, 90)), double{h}});
}

Result<std::vector<GlobeLayer>> globeLayers(std::vector<LaidTile> tiles, const LatticePlace& lattice,
                                            double base_spacing_m, const OpenOptions& options, GlobeInfo& info,
                                            std::vector<GlobeInput>& inputs) {
  auto groups = groupTiles(std::move(tiles));
  if (!groups.ok()) return groups.error();
  const Ellipsoid ellipsoid{info.semi_major_m, info.flattening};
  std::vector<GlobeGroup> placed;
  for (TileGroup& group : *groups) {
    auto place = placeLayer(group, lattice);
    if (!place.ok()) return place.error();
    const auto spacing_m = spacingOf(group, *place, ellipsoid);
    if (!spacing_m.ok()) return spacing_m.error();
    placed.push_back({std::move(group), std::move(*place), *spacing_m});
  }
  sortUpwards(placed, rankOnGlobe);
  std::vector<GlobeLayer> layers;
  for (GlobeGroup& g : placed) {
    const std::string name = g.group.name;
    if (g.resolution() * kAlike > base_spacing_m) {
      info.notes.push_back(name + ": it is not finer than the globe's own samples, and is left out");
      continue;
    }
    if (g.place.places.isBallpark())
      info.warnings.push_back(name + ": PROJ knows no exact transformation between its reference system and " +
                              lattice.name +
                              "'s on this machine, so places may be off by up to 200 m; `projsync "
                              "--file` or the package proj-data brings the grids");
    const double feather_m = featherOnGlobe(g, base_spacing_m, options);
    inputs.push_back(describeLayer(g, feather_m));
    info.notes.insert(info.notes.end(), g.group.mosaic.notes.begin(), g.group.mosaic.notes.end());
    if (info.title.size() <= 200) info.title += ", " + std::filesystem::path(name).filename().string();
    auto layer = readLayer(g.group, g.place, lattice, 0, info.warnings);
    if (!layer.ok()) return layer.error();
    if (const uint64_t filled = fillGaps(layer->samples); filled > 0)
      info.notes.push_back(
          fmt::format("{}: {} samples of small gaps in it were filled from around them", name, filled));
    layer->weights = featherWeights(layer->samples, g.spacing_m, feather_m);
    layers.emplace_back(std::move(*layer), g.spacing_m);
  }
  return layers;
}

}  // namespace foreland::terrain
