#include "terrain/imagery/globe_imagery.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <set>
#include <vector>

#include "proto/space/cube_map.h"
#include "terrain/imagery/tile_tree.h"

namespace foreland::terrain {

namespace {

using proto::TileId;

constexpr double kAlike = 1.01;  // resolutions that differ by less are the same
constexpr uint32_t kNet = 9;     // directions along each side of a patch

// Of a texel in the middle of a face.
double radiansOf(const proto::TileLayer& layer, uint32_t level) {
  return 0.5 * std::numbers::pi / layer.width * static_cast<double>(uint64_t{1} << level);
}

// What a tile shows, gutters included.
GlobePatch patchOf(const proto::TileLayer& layer, const TileId& tile) {
  const uint32_t face = layer.faceOf(tile);
  const proto::LatticeBox box = layer.boxOf(tile);
  const glm::dvec2 gutter(proto::kTileGutter * layer.texelAt(tile.level)), low = box.low - gutter,
                                                                           size = box.high + gutter - low;
  const double step = 2.0 / layer.face_steps;
  const auto direction = [&](double u, double v) {
    const glm::dvec2 at = (low + size * glm::dvec2(u, v) - glm::dvec2(1.0 * face * layer.face_steps, 0)) * step - 1.0;
    return proto::cubeVector({face, at.x, at.y});
  };
  GlobePatch patch{.middle = glm::normalize(direction(0.5, 0.5)), .angle_rad = 0, .side = kNet, .directions = {}};
  for (uint32_t j = 0; j < kNet; ++j)
    for (uint32_t i = 0; i < kNet; ++i) {
      const glm::dvec3 d = direction(i / (kNet - 1.0), j / (kNet - 1.0));
      patch.directions.push_back(d);
      patch.angle_rad =
          std::max(patch.angle_rad, std::atan2(glm::length(glm::cross(patch.middle, d)), glm::dot(patch.middle, d)));
    }
  return patch;
}

// From the coarsest on, as long as a parent's texels are coarser than pixels.
void want(const proto::TileLayer& layer, const GlobePicture& picture, const TileId& tile, std::set<uint64_t>& keys) {
  keys.insert(tile.key());
  if (tile.level == 0 || radiansOf(layer, tile.level) <= kAlike * picture.spacingIn(patchOf(layer, tile))) return;
  for (uint32_t k = 0; k < 4; ++k)
    if (const TileId child = tile.child(k); layer.has(child)) want(layer, picture, child, keys);
}

// Makes a tile of its texels, or leaves it out.
class TileWriter {
 public:
  TileWriter(const proto::TileLayer& layer, const BoundsOf& boundsOf, const ImageryOptions& options,
             TileSection& section)
      : layer_(layer), boundsOf_(boundsOf), options_(options), section_(section) {}

  Status write(const TileId& tile, const std::vector<LinearTexel>& texels) {
    std::vector<Rgba> shown(texels.size());
    std::ranges::transform(texels, shown.begin(), toSrgb);
    bool has_finer = false;
    for (uint32_t k = 0; k < 4 && tile.level > 0; ++k)
      has_finer = has_finer || (layer_.has(tile.child(k)) && section_.has(tile.child(k)));
    const std::vector<Rgb> colours = filled(shown);
    const float detail = detailOf(shown, colours);
    if (!layer_.isCoarsest(tile) && !has_finer && detail < kMinDetail) return {};
    const auto bytes = encodeTile(colours, options_.quality);
    if (!bytes) return bytes.error();
    const auto bounds = boundsOf(tile);
    if (!bounds) return bounds.error();
    ++stored;
    return section_.add(tile, *bytes, *bounds, detail);
  }
  std::atomic<uint64_t> stored{0};

 private:
  Result<proto::TileBounds> boundsOf(const TileId& tile) const {
    std::vector<glm::dvec3> scratch;
    if (tile.level == 0) return boundsOf_(layer_.boxOf(tile), scratch);
    std::vector<proto::TileBounds> parts;
    for (uint32_t k = 0; k < 4; ++k) {
      const TileId child = tile.child(k);
      if (!layer_.has(child)) continue;
      const auto part = section_.has(child) ? section_.bounds(child) : boundsOf_(layer_.boxOf(child), scratch);
      if (!part) return part.error();
      parts.push_back(*part);
    }
    return unionOf(std::span<const proto::TileBounds>(parts));
  }

  const proto::TileLayer& layer_;
  const BoundsOf& boundsOf_;
  const ImageryOptions& options_;
  TileSection& section_;
};

Status checkOptions(const ImageryOptions& options) {
  if (options.quality < 1 || options.quality > 100)
    return Error{ErrorCode::kInvalidArgument, "the quality of imagery is from 1 to 100"};
  if (options.attribution.size() > kMaxAttributionBytes)
    return Error{ErrorCode::kInvalidArgument, "the attribution has " + std::to_string(options.attribution.size()) +
                                                  " bytes; at most " + std::to_string(kMaxAttributionBytes) + " fit"};
  return {};
}

// Share of the body that pictures cover, by a net of directions.
double coveredShare(const GlobePicture& picture) {
  constexpr uint32_t kSide = 64;
  uint32_t covered = 0;
  for (uint32_t i = 0; i < 6 * kSide * kSide; ++i) {
    const auto coordinate = [](uint32_t at) { return (at + 0.5) * (2.0 / kSide) - 1; };
    const glm::dvec3 direction =
        proto::cubeVector({i / (kSide * kSide), coordinate(i % kSide), coordinate(i / kSide % kSide)});
    covered += picture.colourAt(direction, 0).alpha >= 128 ? 1 : 0;
  }
  return covered / (6.0 * kSide * kSide);
}

}  // namespace

LinearTexel GlobeImagerySource::at(uint32_t level, uint32_t face, uint32_t x, uint32_t y) const {
  const double step = 2.0 / layer_.widthAt(level);
  return toLinear(picture_.colourAt(proto::cubeVector({face, (x + 0.5) * step - 1, (y + 0.5) * step - 1}),
                                    radiansOf(layer_, level)));
}

LinearTexel GlobeImagerySource::meanOfThree(const LinearTexel& a, const LinearTexel& b, const LinearTexel& c) {
  const uint32_t all = uint32_t{a.coverage} + b.coverage + c.coverage;
  if (all == 0) return {};
  const auto mean = [&](uint16_t LinearTexel::*part) {
    return static_cast<uint16_t>(
        (uint64_t{a.*part} * a.coverage + uint64_t{b.*part} * b.coverage + uint64_t{c.*part} * c.coverage) / all);
  };
  return {mean(&LinearTexel::red), mean(&LinearTexel::green), mean(&LinearTexel::blue), static_cast<uint16_t>(all / 3)};
}

proto::TileLayer globeImageryLayer(const GlobePicture& picture, uint32_t face_steps) {
  const double wanted = std::ceil(0.5 * std::numbers::pi / (picture.finestSpacing() * kAlike));
  proto::TileLayer layer{.content = proto::TileContent::kImagery,
                         .coding = proto::TileCoding::kWebP,
                         .width = static_cast<uint32_t>(std::clamp(wanted, 1.0, 1.0 * proto::kMaxLayerSide)),
                         .step_m = 0,
                         .attribution = {},
                         .face_steps = face_steps};
  layer.height = layer.width;
  // Texels of the coarsest level fill the faces, too.
  const uint32_t coarsest = 1u << (layer.levels() - 1);
  layer.width = layer.height = (layer.width + coarsest - 1) / coarsest * coarsest;
  layer.texel = static_cast<double>(face_steps) / layer.width;
  return layer;
}

Result<ImageryReport> addGlobeImagery(const GlobePicture& picture, uint32_t face_steps, const BoundsOf& boundsOf,
                                      const ImageryOptions& options, const KeepGoing& keepGoing, TileSection& section) {
  proto::TileLayer layer = globeImageryLayer(picture, face_steps);
  layer.attribution = options.attribution;
  if (Status s = checkOptions(options); !s.ok()) return s.error();
  if (Status s = layer.validate(); !s.ok()) return s.error();
  const uint8_t index = section.addLayer(layer);
  std::set<uint64_t> keys;
  for (uint32_t face = 0; face < layer.faces(); ++face)
    want(layer, picture, {index, static_cast<uint8_t>(layer.levels() - 1), face, 0}, keys);
  TileWriter writer(layer, boundsOf, options, section);
  const GlobeImagerySource source(picture, layer);
  const auto made = TileTree(layer, index, source, options.threads)
                        .make(closedUnderParents(layer, index, keys), options.target, keepGoing,
                              [&](const TileId& tile, const std::vector<LinearTexel>& texels, unsigned) {
                                return writer.write(tile, texels);
                              });
  if (!made) return made.error();
  ImageryReport report;
  report.is_complete = *made, report.tiles = keys.size(), report.stored = writer.stored;
  report.covered = coveredShare(picture);
  return report;
}

}  // namespace foreland::terrain
