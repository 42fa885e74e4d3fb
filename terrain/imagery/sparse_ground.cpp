#include "terrain/imagery/sparse_ground.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "proto/imagery/relief_codec.h"
#include "terrain/geo/geodesy.h"
#include "terrain/imagery/cube_fold.h"
#include "terrain/imagery/ground_bounds.h"
#include "terrain/imagery/normal_cone.h"
#include "terrain/imagery/relief_steps.h"
#include "terrain/parallel.h"
#include "terrain/store/flat_squares.h"

namespace foreland::terrain {

namespace {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;
using proto::NodeId;
using proto::TileId;

constexpr double kSparseRing = 2;                          // samples around a box, as for whole scenes
constexpr double kHalfAngleUnit = std::numbers::pi / 510;  // of NormalCone::half_angle
constexpr uint32_t kWindow = kTileSide + 4;                // nodes around a tile
constexpr uint64_t kKeptNormals = 1 << 20;                 // 24 MB

}  // namespace

SparseGroundBounds::SparseGroundBounds(const StoredHeights& ground, const proto::Frame& frame)
    : ground_(ground),
      height_quantum_m_(frame.height_quantum_m),
      positions_(frame, ground.grid().maxX(), ground.grid().maxY()) {
  const proto::GridShape& shape = ground.grid().shape();
  const glm::dvec2 spacing_m = sampleSpacing(frame, shape.samples_x, shape.samples_y);
  // Of neighbours one may be rounded up and the other down.
  rounding_rad_ = std::atan(1.5 * height_quantum_m_ / std::min(spacing_m.x, spacing_m.y));
}

// Calls visit(low_x, low_y, high_x, high_y) for the windows of samples that hold a box and a ring about it.
template <class Visit>
void SparseGroundBounds::forEachWindow(const proto::LatticeBox& box, const Visit& visit) const {
  const glm::dvec2 low = glm::floor(box.low) - kSparseRing, high = glm::ceil(box.high) + kSparseRing;
  const proto::GridShape& shape = ground_.grid().shape();
  const auto within = [&](const glm::dvec2& first, const glm::dvec2& last, const FaceBox& b) {
    const glm::uvec2 from(glm::clamp(b.low, first, last)), to(glm::clamp(b.high, first, last));
    visit(from.x, from.y, to.x, to.y);
  };
  if (!shape.is_cube)
    return within(glm::dvec2(0), glm::dvec2(shape.samples_x, shape.samples_y) - 1.0, FaceBox{0, low, high});
  const double side = ground_.grid().rootSize(), face = std::floor(0.5 * (box.low.x + box.high.x) / side);
  const auto onFace = [&](const FaceBox& b) {
    const glm::dvec2 origin(b.face * side, 0);
    within(origin, origin + (side - 1), {b.face, origin + b.low, origin + b.high});
  };
  const FaceBox own{static_cast<uint32_t>(face), low - glm::dvec2(face * side, 0), high - glm::dvec2(face * side, 0)};
  onFace(own);
  const glm::dvec2 inner_low = glm::max(own.low, 0.0), inner_high = glm::min(own.high, side);
  const auto beyond = [&](const glm::dvec2& a, const glm::dvec2& b) {
    onFace(foldedOver(FaceBox{own.face, a, b}, side));
  };
  if (own.low.x < 0) beyond({own.low.x, inner_low.y}, {0, inner_high.y});
  if (own.high.x > side) beyond({side, inner_low.y}, {own.high.x, inner_high.y});
  if (own.low.y < 0) beyond({inner_low.x, own.low.y}, {inner_high.x, 0});
  if (own.high.y > side) beyond({inner_low.x, side}, {inner_high.x, own.high.y});
}

// Calls see(height in quanta) for the corners of the flat squares that meet a box and a ring about it, and
// visit(unit normal) for the normals at these.
template <class See, class Visit>
void SparseGroundBounds::forEachNormal(const proto::LatticeBox& box, const See& see, const Visit& visit) const {
  const proto::GridTopology& grid = ground_.grid();
  const auto include = [&](uint32_t x, uint32_t y, uint32_t side) {
    glm::dvec3 p[4];
    for (uint32_t k = 0; k < 4; ++k) {
      const NodeId v = grid.nameIn(x >> grid.shape().root_log2, NodeId::at(x + side * (k % 2), y + side * (k / 2)));
      const double height = ground_.exactAt(v);
      see(height);
      p[k] = positions_.position(v, height);
    }
    for (const glm::dvec3& east : {p[1] - p[0], p[3] - p[2]})
      for (const glm::dvec3& north : {p[2] - p[0], p[3] - p[1]}) visit(glm::normalize(glm::cross(east, north)));
  };
  const FlatSquares squares(grid, ground_.pages());
  forEachWindow(box, [&](uint32_t low_x, uint32_t low_y, uint32_t high_x, uint32_t high_y) {
    squares.forEachIn(low_x, low_y, high_x, high_y, include);
  });
}

proto::TileBounds SparseGroundBounds::over(const proto::LatticeBox& box) const {
  std::vector<glm::dvec3> kept;  // the first normals: what is more is looked up again
  uint64_t count = 0;
  glm::dvec3 sum(0);
  double lowest = proto::kMaxHeight, highest = -proto::kMaxHeight;
  forEachNormal(
      box, [&](double height) { lowest = std::min(lowest, height), highest = std::max(highest, height); },
      [&](const glm::dvec3& n) {
        sum += n;
        if (count++ < kKeptNormals) kept.push_back(n);
      });
  // Floats, and heights that are rounded.
  proto::TileBounds bounds;
  bounds.lowest_m = std::nextafter(static_cast<float>((lowest - 1) * height_quantum_m_), -1e30f);
  bounds.highest_m = std::nextafter(static_cast<float>((highest + 1) * height_quantum_m_), 1e30f);
  NormalCone cone = NormalCone::everything();
  if (glm::length(sum) > 1e-3) {
    const auto axis = quantisedAxis(sum);
    const glm::dvec3 unit = NormalCone{axis, 0}.unitAxis();
    double least = 1;
    const auto hold = [&](const glm::dvec3& n) { least = std::min(least, glm::dot(n, unit)); };
    if (count > kept.size())
      forEachNormal(
          box, [](double) {}, hold);
    else
      std::ranges::for_each(kept, hold);
    cone = coneOf(axis, least);
    const double widened = cone.half_angle + std::ceil(rounding_rad_ / kHalfAngleUnit);
    cone = cone.isEverything() || widened > 255 ? NormalCone::everything()
                                                : NormalCone{axis, static_cast<uint8_t>(widened)};
  }
  std::copy(cone.axis.begin(), cone.axis.end(), bounds.axis);
  bounds.half_angle = cone.half_angle;
  return bounds;
}

namespace {

// Which tiles of a layer of relief there are to be.
class Wanted {
 public:
  Wanted(const proto::TileLayer& layer, const proto::GridTopology& grid, const proto::PageDirectory& pages)
      : layer_(layer) {
    const uint32_t whole = grid.shape().sparse_levels / 2;
    for (uint32_t level = 0; level < layer.levels(); ++level)
      is_wanted_.emplace_back(size_t{layer.tilesX(level)} * layer.tilesY(level), level >= whole);
    pages.forEachPage([&](proto::Slot first, uint64_t) { addPage(grid, grid.pagePlace(first)); });
    for (uint32_t level = 0; level + 1 < layer.levels(); ++level)
      for (uint32_t y = 0; y < layer.tilesY(level); ++y)
        for (uint32_t x = 0; x < layer.tilesX(level); ++x)
          if (has(level, x, y)) is_wanted_[level + 1][number(level + 1, x / 2, y / 2)] = true;
  }
  bool has(uint32_t level, uint32_t x, uint32_t y) const { return is_wanted_[level][number(level, x, y)]; }
  uint64_t count() const {
    uint64_t count = 0;
    for (const auto& level : is_wanted_) count += static_cast<uint64_t>(std::ranges::count(level, true));
    return count;
  }

 private:
  size_t number(uint32_t level, uint32_t x, uint32_t y) const { return size_t{y} * layer_.tilesX(level) + x; }
  void addPage(const proto::GridTopology& grid, const proto::PagePlace& page) {
    const uint32_t scale = grid.shape().root_log2 - 1 - static_cast<uint32_t>(page.level) / 2;
    if (scale >= layer_.levels()) return;
    // In texels of the level, which are as far apart as the page's nodes.
    const bool is_sides = page.level % 2 == 1;
    const uint32_t x = page.column * proto::GridTopology::kTileSide,
                   height = proto::GridTopology::kTileSide >> is_sides, y = page.row * height;
    const auto tileOf = [](uint32_t texel, uint32_t tiles) { return std::min(texel / kTilePayload, tiles - 1); };
    const uint32_t tiles_x = layer_.tilesX(scale), tiles_y = layer_.tilesY(scale);
    for (uint32_t j = tileOf(y - std::min(y, 1u), tiles_y); j <= tileOf(y + height + 1, tiles_y); ++j)
      for (uint32_t i = tileOf(x - std::min(x, 1u), tiles_x);
           i <= tileOf(x + proto::GridTopology::kTileSide + 1, tiles_x); ++i)
        is_wanted_[scale][number(scale, i, j)] = true;
  }

  const proto::TileLayer& layer_;
  std::vector<std::vector<bool>> is_wanted_;
};

// The ground's heights at nodes 2^level samples apart about a tile, and on the triangles between them. They are read
// when the first is asked for.
class NodesAbout {
 public:
  // From the node below and left of the texel (x, y) of the level on.
  void moveTo(uint32_t level, int64_t x, int64_t y) {
    first_x_ = std::max<int64_t>(x, 0), first_y_ = std::max<int64_t>(y, 0), level_ = level;
    is_read_ = false;
  }
  // At a lattice position; beyond the data at its border.
  double at(const StoredHeights& ground, double x, double y) {
    if (!is_read_) read(ground);
    return drawn(x, y);
  }

 private:
  // Square by square of what is flat, for to look up every node takes as many steps as there are levels.
  void read(const StoredHeights& ground) {
    is_read_ = true;
    const proto::GridShape& shape = ground.grid().shape();
    last_x_ = shape.samples_x - 1.0, last_y_ = shape.samples_y - 1.0;
    const auto within = [&](int64_t first, uint32_t samples) {
      return std::min<int64_t>(kWindow - 1, ((int64_t{samples} - 1) >> level_) - first);
    };
    const int64_t columns = within(first_x_, shape.samples_x), rows = within(first_y_, shape.samples_y);
    const auto position = [&](int64_t first, int64_t k) { return static_cast<uint32_t>((first + k) << level_); };
    FlatSquares(ground.grid(), ground.pages())
        .forEachIn(position(first_x_, 0), position(first_y_, 0), position(first_x_, columns), position(first_y_, rows),
                   [&](uint32_t x, uint32_t y, uint32_t side) {
                     fill(ground, {x, y, side}, columns, rows);
                   });
    // Beyond the data as at its border.
    for (int64_t j = 0; j < kWindow; ++j)
      for (int64_t i = 0; i < kWindow; ++i)
        if (i > columns || j > rows)
          at(i, j) = ground.exactAt(NodeId::at(std::min(position(first_x_, i), shape.samples_x - 1),
                                               std::min(position(first_y_, j), shape.samples_y - 1)));
  }
  struct Square {
    uint32_t x, y, side;
  };
  // The nodes of a flat square, its sides included.
  void fill(const StoredHeights& ground, const Square& s, int64_t columns, int64_t rows) {
    const auto first = [&](uint32_t low, int64_t from) {
      return std::max<int64_t>(0, ((int64_t{low} + (1 << level_) - 1) >> level_) - from);
    };
    const auto last = [&](uint32_t low, int64_t from, int64_t count) {
      return std::min<int64_t>(count, (int64_t{low + s.side} >> level_) - from);
    };
    const int64_t i0 = first(s.x, first_x_), i1 = last(s.x, first_x_, columns), j0 = first(s.y, first_y_),
                  j1 = last(s.y, first_y_, rows);
    if (i0 > i1 || j0 > j1) return;
    const auto corner = [&](uint32_t dx, uint32_t dy) { return ground.exactAt(NodeId::at(s.x + dx, s.y + dy)); };
    const double a = corner(0, 0), b = corner(s.side, 0), c = corner(0, s.side), d = corner(s.side, s.side);
    const bool is_rising = (s.x / s.side + s.y / s.side) % 2 == 0;
    for (int64_t j = j0; j <= j1; ++j)
      for (int64_t i = i0; i <= i1; ++i)
        at(i, j) = inSquare(is_rising, static_cast<double>(((first_x_ + i) << level_) - s.x) / s.side,
                            static_cast<double>(((first_y_ + j) << level_) - s.y) / s.side, {a, b, c, d});
  }
  struct Corners {
    double a, b, c, d;
  };
  static double inSquare(bool is_rising, double u, double v, const Corners& k) {
    if (is_rising) return u > v ? k.a + u * (k.b - k.a) + v * (k.d - k.b) : k.a + v * (k.c - k.a) + u * (k.d - k.c);
    return u + v < 1 ? k.a + u * (k.b - k.a) + v * (k.c - k.a) : k.d + (1 - u) * (k.c - k.d) + (1 - v) * (k.b - k.d);
  }
  double drawn(double x, double y) const {
    const double step = std::ldexp(1.0, -static_cast<int>(level_));
    const double u0 = std::clamp(x, 0.0, last_x_) * step - static_cast<double>(first_x_),
                 v0 = std::clamp(y, 0.0, last_y_) * step - static_cast<double>(first_y_);
    const auto i = static_cast<uint32_t>(std::clamp(std::floor(u0), 0.0, kWindow - 2.0)),
               j = static_cast<uint32_t>(std::clamp(std::floor(v0), 0.0, kWindow - 2.0));
    return inSquare((first_x_ + i + first_y_ + j) % 2 == 0, u0 - i, v0 - j,
                    {height(i, j), height(i + 1, j), height(i, j + 1), height(i + 1, j + 1)});
  }
  double& at(int64_t i, int64_t j) { return heights_[static_cast<size_t>(j * kWindow + i)]; }
  double height(uint32_t i, uint32_t j) const { return heights_[size_t{j} * kWindow + i]; }

  int64_t first_x_ = 0, first_y_ = 0;
  uint32_t level_ = 0;
  bool is_read_ = false;
  double last_x_ = 0, last_y_ = 0;
  std::vector<double> heights_ = std::vector<double>(size_t{kWindow} * kWindow);
};

using Texels = std::vector<float>;  // a tile's own, in quanta
using LevelTiles = std::unordered_map<uint64_t, Texels>;

class SparseReliefMaker {
 public:
  SparseReliefMaker(const StoredHeights& ground, const SparseGroundBounds& bounds, const proto::Frame& frame,
                    unsigned threads, const KeepGoing& keepGoing, TileSection& section, uint8_t layer)
      : ground_(ground),
        bounds_(bounds),
        section_(section),
        layer_index_(layer),
        layer_(section.layer(layer)),
        wanted_(layer_, ground.grid(), ground.pages()),
        height_quantum_m_(frame.height_quantum_m),
        threads_(threads),
        keepGoing_(keepGoing),
        all_(wanted_.count()) {}

  Result<bool> make() {
    LevelTiles finer;
    for (uint32_t level = 0; level < layer_.levels(); ++level) {
      LevelTiles tiles;
      const bool is_complete = makeLevel(level, finer, tiles);
      if (!failure_.status().ok()) return failure_.status().error();
      if (!is_complete) return false;
      finer = std::move(tiles);
    }
    return true;
  }

 private:
  bool makeLevel(uint32_t level, const LevelTiles& finer, LevelTiles& tiles) {
    std::vector<TileId> ids;
    for (uint32_t y = 0; y < layer_.tilesY(level); ++y)
      for (uint32_t x = 0; x < layer_.tilesX(level); ++x)
        if (wanted_.has(level, x, y)) {
          ids.push_back({layer_index_, static_cast<uint8_t>(level), x, y});
          tiles[ids.back().key()].resize(size_t{kTilePayload} * kTilePayload);
        }
    std::vector<NodesAbout> nodes(threadCount(threads_));
    const auto onProgress = [&](uint64_t done) {
      return keepGoing_((static_cast<double>(done_) + 0.5 * static_cast<double>(done)) / static_cast<double>(all_));
    };
    if (!parallelFor(
            ids.size(), threads_,
            [&](uint64_t i, unsigned worker) { fill(ids[i], finer, nodes[worker], tiles.at(ids[i].key())); },
            onProgress))
      return false;
    if (!parallelFor(
            ids.size(), threads_,
            [&](uint64_t i, unsigned worker) { failure_.keep(add(ids[i], tiles, nodes[worker])); }, onProgress))
      return false;
    done_ += ids.size();
    return true;
  }

  // A tile's own texels.
  void fill(const TileId& tile, const LevelTiles& finer, NodesAbout& nodes, Texels& out) const {
    nodes.moveTo(tile.level, int64_t{tile.x} * kTilePayload - 1, int64_t{tile.y} * kTilePayload - 1);
    for (uint32_t j = 0; j < kTilePayload; ++j)
      for (uint32_t i = 0; i < kTilePayload; ++i) {
        const uint32_t x = tile.x * kTilePayload + i, y = tile.y * kTilePayload + j;
        out[size_t{j} * kTilePayload + i] = static_cast<float>(
            tile.level == 0 ? ground_.exactAt(NodeId::at(std::min(x, layer_.width - 1), std::min(y, layer_.height - 1)))
                            : meanOfFiner(tile.level - 1u, x, y, finer, nodes));
      }
  }

  double meanOfFiner(uint32_t level, uint32_t x, uint32_t y, const LevelTiles& finer, NodesAbout& nodes) const {
    const TileId tile{layer_index_, static_cast<uint8_t>(level), 2 * x / kTilePayload, 2 * y / kTilePayload};
    const auto found = finer.find(tile.key());
    double sum = 0;
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t at_x = std::min(2 * x + k % 2, layer_.widthAt(level) - 1),
                     at_y = std::min(2 * y + k / 2, layer_.heightAt(level) - 1);
      sum += found != finer.end() ? own(found->second, tile, at_x, at_y) : middleOf(level, at_x, at_y, nodes);
    }
    return 0.25 * sum;
  }
  static float own(const Texels& texels, const TileId& tile, uint32_t x, uint32_t y) {
    return texels[size_t{y - tile.y * kTilePayload} * kTilePayload + (x - tile.x * kTilePayload)];
  }
  double middleOf(uint32_t level, uint32_t x, uint32_t y, NodesAbout& nodes) const {
    const double size = std::ldexp(1.0, static_cast<int>(level));
    return nodes.at(ground_, (x + 0.5) * size - 0.5, (y + 0.5) * size - 0.5);
  }

  Status add(const TileId& tile, const LevelTiles& tiles, NodesAbout& nodes) {
    nodes.moveTo(tile.level, int64_t{tile.x} * kTilePayload - kTileGutter - 1,
                 int64_t{tile.y} * kTilePayload - kTileGutter - 1);
    std::vector<int32_t> steps;
    takeReliefSteps(
        layer_, tile, height_quantum_m_,
        [&](uint32_t x, uint32_t y) {
          const TileId at{layer_index_, tile.level, x / kTilePayload, y / kTilePayload};
          const auto found = tiles.find(at.key());
          return found != tiles.end() ? own(found->second, at, x, y) : middleOf(tile.level, x, y, nodes);
        },
        steps);
    return section_.add(tile, proto::encodeRelief(steps), boundsOf(tile), 0);
  }

  proto::TileBounds boundsOf(const TileId& tile) const {
    if (tile.level == 0) return bounds_.over(layer_.boxOf(tile));
    std::vector<proto::TileBounds> parts;
    for (uint32_t k = 0; k < 4; ++k)
      if (const TileId child = tile.child(k); layer_.has(child))
        parts.push_back(wanted_.has(child.level, child.x, child.y) ? section_.bounds(child)
                                                                   : bounds_.over(layer_.boxOf(child)));
    return unionOf(std::span<const proto::TileBounds>(parts));
  }

  const StoredHeights& ground_;
  const SparseGroundBounds& bounds_;
  TileSection& section_;
  uint8_t layer_index_;
  const proto::TileLayer layer_;
  Wanted wanted_;
  double height_quantum_m_;
  unsigned threads_;
  const KeepGoing& keepGoing_;
  uint64_t all_, done_ = 0;
  FirstFailure failure_;
};

}  // namespace

Result<bool> addSparseRelief(const StoredHeights& ground, const SparseGroundBounds& bounds, const proto::Frame& frame,
                             unsigned threads, const KeepGoing& keepGoing, TileSection& section) {
  const proto::GridShape& shape = ground.grid().shape();
  const proto::TileLayer layer = reliefLayer(shape.samples_x, shape.samples_y, frame);
  if (Status s = layer.validate(); !s.ok()) return s.error();
  const uint8_t index = section.addLayer(layer);
  return SparseReliefMaker(ground, bounds, frame, threads, keepGoing, section, index).make();
}

}  // namespace foreland::terrain
