#include "terrain/imagery/verify_globe_relief.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "proto/space/cube_map.h"
#include "terrain/imagery/globe_relief.h"
#include "terrain/imagery/normal_cone.h"
#include "terrain/parallel.h"

namespace foreland::terrain {

namespace {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;
using proto::TileId;

constexpr double kRoundingSteps = 1e-3;  // of a step: heights are floats while tiles are made

struct NormalAngles {
  double squares = 0, largest = 0;
  uint64_t count = 0;
};

class GlobeReliefCheck {
 public:
  GlobeReliefCheck(const Scene& scene, uint8_t layer, Faults& faults)
      : tiles_(scene.tiles()),
        layer_(tiles_.layers()[layer]),
        faults_(faults),
        ground_(scene.grid(), scene.pages(), scene.records(),
                proto::BaseHeights{scene.cornerHeights(), scene.centreHeights()}),
        source_(ground_, layer_),
        quantum_m_(scene.frame().height_quantum_m),
        spheroid_(scene.frame().semi_major_m, scene.frame().semiMinor()) {}

  NormalAngles check(const TileId& tile, uint64_t order) const {
    const auto fault = [&](const std::string& what) { faults_.add(order, nameOf(tile) + " " + what); };
    const auto bounds = tiles_.bounds(tile);
    if (!bounds) return {};  // the directory's check says so
    std::vector<int32_t> steps(proto::kTileTexels);
    if (!proto::decodeRelief(tiles_.bytes(tile), steps).ok()) {
      fault("cannot be decoded");
      return {};
    }
    checkChildrensBounds(tiles_, tile, order, faults_);
    if (!isOfFiner(tile, steps)) fault("is not the mean of those of the finer level");
    if (tile.level > 0) return {};
    std::vector<float> data(steps.size());
    if (!isOfGround(tile, *bounds, steps, data)) {
      fault("has heights that are not those of the ground, or not within its bounds");
      return {};
    }
    return checkNormals(tile, *bounds, steps, data, fault);
  }

 private:
  double step(uint32_t level) const { return layer_.stepAt(level); }
  // A texel of a tile's image on its face; beyond the gutter of the face the last one.
  FaceTexel texelOf(const TileId& tile, uint32_t x, uint32_t y) const {
    const auto on = [&](uint32_t at, uint32_t i) {
      return std::min<int64_t>(int64_t{at} * kTilePayload + i - kTileGutter,
                               int64_t{layer_.widthAt(tile.level)} - 1 + kTileGutter);
    };
    return {layer_.faceOf(tile), on(layer_.columnOf(tile), x), on(tile.y, y)};
  }
  bool isOwn(const TileId& tile, uint32_t x, uint32_t y) const {
    const auto in_payload = [](uint32_t i) { return i >= kTileGutter && i < kTileSide - kTileGutter; };
    return in_payload(x) && in_payload(y) && texelOf(tile, x, y).beyond(layer_.widthAt(tile.level)) == 0;
  }

  // Of the finest level, gutters included.
  bool isOfGround(const TileId& tile, const proto::TileBounds& bounds, const std::vector<int32_t>& steps,
                  std::vector<float>& data) const {
    const int64_t side = layer_.widthAt(tile.level);
    const auto read = [&](const FaceTexel& t) {
      return source_.at(tile.level, t.face, static_cast<uint32_t>(t.x), static_cast<uint32_t>(t.y));
    };
    size_t i = 0;
    for (uint32_t y = 0; y < kTileSide; ++y)
      for (uint32_t x = 0; x < kTileSide; ++x, ++i) {
        const FaceTexel at = texelOf(tile, x, y);
        data[i] = at.beyond(side) == 0 ? read(at) : source_.beyond(tile.level, at, read);
        const double height_m = double{data[i]} * quantum_m_;
        if (!(std::abs(steps[i] * step(0) - height_m) <= (0.5 + kRoundingSteps) * step(0))) return false;
        if (isOwn(tile, x, y) && !(height_m >= bounds.lowest_m && height_m <= bounds.highest_m)) return false;
      }
    return true;
  }

  // Own texels are means of those of finer tiles where these are stored, and of the ground elsewhere.
  bool isOfFiner(const TileId& tile, const std::vector<int32_t>& steps) const {
    if (tile.level == 0) return true;
    std::vector<int32_t> finer(proto::kTileTexels);
    constexpr uint32_t kQuarterSide = kTilePayload / 2;
    for (uint32_t k = 0; k < 4; ++k) {
      const TileId child = tile.child(k);
      const bool is_stored = layer_.has(child) && tiles_.bounds(child).has_value();
      if (is_stored && !proto::decodeRelief(tiles_.bytes(child), finer).ok()) continue;  // its own check says so
      for (uint32_t y = 0; y < kQuarterSide; ++y)
        for (uint32_t x = 0; x < kQuarterSide; ++x) {
          const uint32_t left = kTileGutter + k % 2 * kQuarterSide + x, below = kTileGutter + k / 2 * kQuarterSide + y;
          if (!isOwn(tile, left, below)) continue;
          const double own_m = steps[size_t{below} * kTileSide + left] * step(tile.level);
          const int32_t* four = &finer[size_t{2 * y + kTileGutter} * kTileSide + 2 * x + kTileGutter];
          double there_m = 0.25 * step(child.level) *
                           static_cast<double>(int64_t{four[0]} + four[1] + four[kTileSide] + four[kTileSide + 1]);
          if (!is_stored) {
            const FaceTexel at = texelOf(tile, left, below);
            there_m = quantum_m_ *
                      double{source_.at(tile.level, at.face, static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y))};
          }
          const double most_m = (0.5 + kRoundingSteps) * (step(tile.level) + (is_stored ? step(child.level) : 0));
          if (!(std::abs(own_m - there_m) <= most_m)) return false;
        }
    }
    return true;
  }

  template <class Fault>
  NormalAngles checkNormals(const TileId& tile, const proto::TileBounds& bounds, const std::vector<int32_t>& steps,
                            const std::vector<float>& data, const Fault& fault) const {
    const NormalCone cone = NormalCone::of(bounds);
    const double to_side = 2.0 / layer_.widthAt(tile.level);
    const auto position = [&](uint32_t x, uint32_t y, double height_m) {
      const FaceTexel at = texelOf(tile, x, y);
      const auto coordinate = [&](int64_t i) { return (static_cast<double>(i) + 0.5) * to_side - 1; };
      return spheroid_.position(proto::cubeVector({at.face, coordinate(at.x), coordinate(at.y)}), height_m);
    };
    const auto normal = [&](uint32_t x, uint32_t y, const auto& height) {
      const auto p = [&](uint32_t i, uint32_t j) { return position(i, j, height(size_t{j} * kTileSide + i)); };
      return glm::normalize(glm::cross(p(x + 1, y) - p(x - 1, y), p(x, y + 1) - p(x, y - 1)));
    };
    NormalAngles angles;
    bool all_within = true;
    for (uint32_t y = kTileGutter; y < kTileSide - kTileGutter; ++y)
      for (uint32_t x = kTileGutter; x < kTileSide - kTileGutter; ++x) {
        if (!isOwn(tile, x, y)) continue;
        const glm::dvec3 of_data = normal(x, y, [&](size_t i) { return double{data[i]} * quantum_m_; }),
                         of_relief = normal(x, y, [&](size_t i) { return steps[i] * step(0); });
        all_within = all_within && cone.holds(of_data);
        const double angle = std::atan2(glm::length(glm::cross(of_data, of_relief)), glm::dot(of_data, of_relief));
        angles.squares += angle * angle, angles.largest = std::max(angles.largest, angle), ++angles.count;
      }
    if (!all_within) fault("has normals outside its cone");
    return angles;
  }

  const TileTable& tiles_;
  const proto::TileLayer& layer_;
  Faults& faults_;
  const StoredHeights ground_;
  const GlobeReliefSource source_;
  double quantum_m_;
  proto::Spheroid spheroid_;
};

}  // namespace

LayerReport verifyGlobeRelief(const Scene& scene, uint8_t layer, unsigned threads, Faults& faults) {
  LayerReport report{.content = proto::TileContent::kRelief};
  const proto::TileLayer& own = scene.tiles().layers()[layer];
  if (own.width != scene.frame().face_steps) {
    faults.add(0, "the layer of relief does not fit the samples");
    return report;
  }
  std::vector<TileId> ids;
  scene.tiles().forEach(layer, [&](const TileId& id) {
    if (scene.tiles().bounds(id)) ids.push_back(id);
  });
  const GlobeReliefCheck checker(scene, layer, faults);
  std::vector<NormalAngles> angles(ids.size());
  parallelFor(
      ids.size(), threads, [&](uint64_t i, unsigned) { angles[i] = checker.check(ids[i], i); },
      [](uint64_t) { return true; });
  report.tiles = ids.size();
  uint64_t count = 0;
  double squares = 0;
  for (const NormalAngles& a : angles)
    squares += a.squares, count += a.count, report.largest_rad = std::max(report.largest_rad, a.largest);
  report.rms_rad = count ? std::sqrt(squares / static_cast<double>(count)) : 0;
  return report;
}

}  // namespace foreland::terrain
