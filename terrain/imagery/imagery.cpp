#include "terrain/imagery/imagery.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "terrain/imagery/tile_image.h"
#include "terrain/parallel.h"
#include "terrain/store/file/new_file.h"

namespace foreland::terrain {

namespace {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;
using proto::TileId;

constexpr uint32_t kBatchColumns = 8, kBatchRows = 4;  // tiles of the finest level that are read at a time

// One level of the picture, in a file without a name that is not mapped: pictures may be larger than address space.
struct LinearLevel {
  uint32_t width = 0, height = 0;
  NewFile file;

  uint64_t at(uint32_t x, uint32_t y) const { return (uint64_t{y} * width + x) * sizeof(LinearTexel); }
  Status read(uint32_t x, uint32_t y, std::span<LinearTexel> out) const {
    return file.read(at(x, y), {reinterpret_cast<uint8_t*>(out.data()), out.size_bytes()});
  }
  Status put(uint32_t x, uint32_t y, std::span<const LinearTexel> row) const {
    return file.put(at(x, y), {reinterpret_cast<const uint8_t*>(row.data()), row.size_bytes()});
  }
};

// A rectangle of one.
struct LinearWindow {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  std::vector<LinearTexel> texels{};

  void reset(uint32_t to_x, uint32_t to_y, uint32_t to_width, uint32_t to_height) {
    x = to_x, y = to_y, width = to_width, height = to_height;
    texels.resize(size_t{width} * height);
  }
  std::span<LinearTexel> row(uint32_t at_y) { return std::span(texels).subspan(size_t{at_y - y} * width, width); }
  LinearTexel& at(uint32_t at_x, uint32_t at_y) { return texels[size_t{at_y - y} * width + (at_x - x)]; }
};

// Texels around one tile or several, read from the picture; those beyond its border are the border's.
struct Window {
  PictureWindow on;
  std::vector<Rgba> texels;
  const Rgba& at(int64_t x, int64_t y) const {
    const auto column = std::clamp<int64_t>(x - on.x, 0, on.width - 1),
               row = std::clamp<int64_t>(y - on.y, 0, on.height - 1);
    return texels[static_cast<size_t>(row * on.width + column)];
  }
};

class ImageryMaker {
 public:
  ImageryMaker(PictureSource& picture, const BoundsOf& boundsOf, const ImageryOptions& options,
               const KeepGoing& keepGoing, TileSection& section, uint8_t layer)
      : picture_(picture),
        boundsOf_(boundsOf),
        options_(options),
        keepGoing_(keepGoing),
        section_(section),
        layer_index_(layer),
        layer_(section.layer(layer)),
        bounds_(tileCount(layer_)),
        scratch_(threadCount(options.threads)) {
    report_.tiles = tileCount(layer_);
  }

  Result<ImageryReport> make() {
    if (Status s = makeAll(); !s.ok()) return s.error();
    report_.stored = stored_;
    report_.covered = static_cast<double>(covered_) / (static_cast<double>(layer_.width) * layer_.height);
    return report_;
  }

 private:
  struct Scratch {
    std::vector<Rgba> texels = std::vector<Rgba>(size_t{kTileSide} * kTileSide);
    std::vector<glm::dvec3> positions;
    LinearWindow linear, halved;
  };

  // Leaves is_complete false if it was stopped.
  Status makeAll() {
    std::unique_ptr<LinearLevel> level;
    if (layer_.levels() > 1)
      if (Status s = newLevel(1, level); !s.ok()) return s;
    if (Status s = makeFinest(level.get()); !s.ok()) return s;
    for (uint32_t at = 1; at < layer_.levels() && is_going_; ++at) {
      const auto l = static_cast<uint8_t>(at);
      if (l > 1) {
        std::unique_ptr<LinearLevel> coarse;
        if (Status s = newLevel(l, coarse); !s.ok()) return s;
        halve(*level, *coarse);
        if (!failure_.status().ok()) return failure_.status();
        level = std::move(coarse);
      }
      makeLevel(l, *level);
      if (!failure_.status().ok()) return failure_.status();
    }
    report_.is_complete = is_going_;
    return {};
  }

  Status newLevel(uint32_t l, std::unique_ptr<LinearLevel>& out) const {
    const uint32_t width = layer_.widthAt(l), height = layer_.heightAt(l);
    auto file = NewFile::create(options_.target, sizeof(LinearTexel) * uint64_t{width} * height, FileMapping::kNone);
    if (!file) return file.error();
    out.reset(new LinearLevel{width, height, std::move(file).value()});
    return {};
  }

  void halve(const LinearLevel& fine, const LinearLevel& coarse) {
    const auto halveRow = [&](uint64_t row, unsigned worker) {
      LinearWindow &from = scratch_[worker].linear, &to = scratch_[worker].halved;
      const auto y = static_cast<uint32_t>(row);
      const uint32_t north = std::min(2 * y + 1, fine.height - 1);
      from.reset(0, 2 * y, fine.width, north - 2 * y + 1);
      to.reset(0, y, coarse.width, 1);
      if (!failure_.keep(fine.read(0, 2 * y, from.texels))) return;
      for (uint32_t x = 0; x < coarse.width; ++x) {
        const uint32_t east = std::min(2 * x + 1, fine.width - 1);
        to.at(x, y) = meanOf(from.at(2 * x, 2 * y), from.at(east, 2 * y), from.at(2 * x, north), from.at(east, north));
      }
      failure_.keep(coarse.put(0, y, to.texels));
    };
    parallelFor(coarse.height, options_.threads, halveRow, [](uint64_t) { return true; });
  }

  // Reads the picture once, and writes the level above it into `coarse`, if there is one.
  Status makeFinest(const LinearLevel* coarse) {
    for (uint32_t y = 0; y < layer_.tilesY(0) && is_going_; y += kBatchRows)
      for (uint32_t x = 0; x < layer_.tilesX(0) && is_going_; x += kBatchColumns) {
        if (Status s = makeBatch(x, y, coarse); !s.ok()) return s;
        if (!failure_.status().ok()) return failure_.status();
      }
    return {};
  }

  Status makeBatch(uint32_t first_x, uint32_t first_y, const LinearLevel* coarse) {
    const uint32_t columns = std::min(kBatchColumns, layer_.tilesX(0) - first_x),
                   rows = std::min(kBatchRows, layer_.tilesY(0) - first_y);
    const auto range = [](uint32_t first, uint32_t count, uint32_t texels) {
      const uint32_t begin = first * kTilePayload;
      const uint32_t low = begin - std::min(begin, kTileGutter);
      return std::pair(low, std::min(begin + count * kTilePayload + kTileGutter, texels) - low);
    };
    const auto [x, width] = range(first_x, columns, layer_.width);
    const auto [y, height] = range(first_y, rows, layer_.height);
    window_.on = {x, y, width, height};
    window_.texels.resize(size_t{width} * height);
    if (Status s = picture_.read(window_.on, window_.texels); !s.ok()) return s;
    const auto halfOf = [](uint32_t first, uint32_t count, uint32_t texels) {
      return std::min(count * kTilePayload / 2, texels - first * kTilePayload / 2);
    };
    if (coarse != nullptr)
      half_.reset(first_x * kTilePayload / 2, first_y * kTilePayload / 2, halfOf(first_x, columns, coarse->width),
                  halfOf(first_y, rows, coarse->height));
    forTiles(uint64_t{columns} * rows, [&](uint64_t i, Scratch& scratch) {
      const TileId tile{layer_index_, 0, first_x + static_cast<uint32_t>(i % columns),
                        first_y + static_cast<uint32_t>(i / columns)};
      takeTexels(tile, scratch.texels, [&](int64_t tx, int64_t ty) { return window_.at(tx, ty); });
      covered_ += coveredOwn(tile, scratch.texels);
      if (coarse != nullptr) putHalf(tile, scratch.texels);
      makeTile(tile, scratch);
    });
    if (coarse == nullptr || !is_going_) return {};
    for (uint32_t row = half_.y; row < half_.y + half_.height; ++row)
      if (Status s = coarse->put(half_.x, row, half_.row(row)); !s.ok()) return s;
    return {};
  }

  void makeLevel(uint8_t l, const LinearLevel& level) {
    const uint32_t columns = layer_.tilesX(l);
    forTiles(uint64_t{columns} * layer_.tilesY(l), [&](uint64_t i, Scratch& scratch) {
      const TileId tile{layer_index_, l, static_cast<uint32_t>(i % columns), static_cast<uint32_t>(i / columns)};
      if (!failure_.keep(readAround(tile, level, scratch.linear))) return;
      takeTexels(tile, scratch.texels, [&](int64_t x, int64_t y) {
        return toSrgb(scratch.linear.at(static_cast<uint32_t>(std::clamp<int64_t>(x, 0, level.width - 1)),
                                        static_cast<uint32_t>(std::clamp<int64_t>(y, 0, level.height - 1))));
      });
      makeTile(tile, scratch);
    });
  }

  // A tile's texels, those of its gutter that are there among them.
  static Status readAround(const TileId& tile, const LinearLevel& level, LinearWindow& out) {
    const auto low = [](uint32_t at) { return at * kTilePayload - std::min(at * kTilePayload, kTileGutter); };
    const auto high = [](uint32_t at, uint32_t texels) {
      return std::min((at + 1) * kTilePayload + kTileGutter, texels);
    };
    out.reset(low(tile.x), low(tile.y), high(tile.x, level.width) - low(tile.x),
              high(tile.y, level.height) - low(tile.y));
    for (uint32_t row = out.y; row < out.y + out.height; ++row)
      if (Status s = level.read(out.x, row, out.row(row)); !s.ok()) return s;
    return {};
  }

  template <class Work>
  void forTiles(uint64_t count, const Work& work) {
    const bool complete = parallelFor(
        count, options_.threads, [&](uint64_t i, unsigned worker) { work(i, scratch_[worker]); },
        [&](uint64_t done) {
          return keepGoing_(static_cast<double>(done_ + done) / static_cast<double>(report_.tiles));
        });
    done_ += count;
    is_going_ = is_going_ && complete;
  }

  template <class At>
  static void takeTexels(const TileId& tile, std::vector<Rgba>& texels, const At& at) {
    const int64_t left = int64_t{tile.x} * kTilePayload - kTileGutter,
                  below = int64_t{tile.y} * kTilePayload - kTileGutter;
    auto out = texels.begin();
    for (uint32_t y = 0; y < kTileSide; ++y)
      for (uint32_t x = 0; x < kTileSide; ++x) *out++ = at(left + x, below + y);
  }

  // Texels of a tile that are neither of its gutter nor beyond the picture, along each side.
  std::pair<uint32_t, uint32_t> ownSize(const TileId& tile) const {
    return {std::min(kTilePayload, layer_.widthAt(tile.level) - tile.x * kTilePayload),
            std::min(kTilePayload, layer_.heightAt(tile.level) - tile.y * kTilePayload)};
  }
  uint64_t coveredOwn(const TileId& tile, const std::vector<Rgba>& texels) const {
    const auto [width, height] = ownSize(tile);
    uint64_t covered = 0;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x)
        covered += texels[size_t{y + kTileGutter} * kTileSide + x + kTileGutter].alpha >= 128 ? 1 : 0;
    return covered;
  }
  // Each tile's own texels are those of whole coarser ones, so tiles write apart.
  void putHalf(const TileId& tile, const std::vector<Rgba>& texels) {
    const auto [width, height] = ownSize(tile);
    for (uint32_t y = 0; y < (height + 1) / 2; ++y)
      for (uint32_t x = 0; x < (width + 1) / 2; ++x) {
        const Rgba* south = &texels[size_t{2 * y + kTileGutter} * kTileSide + 2 * x + kTileGutter];
        const Rgba* north = south + kTileSide;
        half_.at(tile.x * kTilePayload / 2 + x, tile.y * kTilePayload / 2 + y) =
            meanOf(toLinear(south[0]), toLinear(south[1]), toLinear(north[0]), toLinear(north[1]));
      }
  }

  void makeTile(const TileId& tile, Scratch& scratch) {
    proto::TileBounds& bounds = bounds_[tileNumber(layer_, tile)];
    bool has_finer = false;
    if (tile.level == 0) {
      const auto found = boundsOf_(layer_.boxOf(tile), scratch.positions);
      if (!failure_.keep(found ? Status() : Status(found.error()))) return;
      bounds = *found;
    } else {
      std::vector<proto::TileBounds> children;
      for (uint32_t k = 0; k < 4; ++k) {
        const TileId child = tile.child(k);
        if (!layer_.has(child)) continue;
        children.push_back(bounds_[tileNumber(layer_, child)]);
        has_finer = has_finer || section_.has(child);
      }
      bounds = unionOf(std::span<const proto::TileBounds>(children));
    }
    const std::vector<Rgb> colours = filled(scratch.texels);
    const float detail = detailOf(scratch.texels, colours);
    if (!layer_.isCoarsest(tile) && !has_finer && detail < kMinDetail) return;
    const auto bytes = encodeTile(colours, options_.quality);
    failure_.keep(bytes ? section_.add(tile, *bytes, bounds, detail) : Status(bytes.error()));
    ++stored_;
  }

  PictureSource& picture_;
  const BoundsOf& boundsOf_;
  const ImageryOptions& options_;
  const KeepGoing& keepGoing_;
  TileSection& section_;
  uint8_t layer_index_;
  const proto::TileLayer layer_;
  std::vector<proto::TileBounds> bounds_;  // of all tiles, stored or not
  std::vector<Scratch> scratch_;           // by worker
  Window window_;
  LinearWindow half_;  // of the level above what window_ shows
  ImageryReport report_;
  uint64_t done_ = 0;
  bool is_going_ = true;
  std::atomic<uint64_t> stored_{0}, covered_{0};
  FirstFailure failure_;
};

}  // namespace

Result<ImageryReport> addImagery(PictureSource& picture, const BoundsOf& boundsOf, const ImageryOptions& options,
                                 const KeepGoing& keepGoing, TileSection& section) {
  const PictureInfo& info = picture.info();
  const proto::TileLayer layer{.content = proto::TileContent::kImagery,
                               .coding = proto::TileCoding::kWebP,
                               .width = info.width,
                               .height = info.height,
                               .origin = info.origin,
                               .texel = info.texel,
                               .step_m = 0,
                               .attribution = options.attribution};
  if (Status s = layer.validate(); !s.ok()) return s.error();
  if (options.quality < 1 || options.quality > 100)
    return Error{ErrorCode::kInvalidArgument, "the quality of imagery is from 1 to 100"};
  if (options.attribution.size() > kMaxAttributionBytes)
    return Error{ErrorCode::kInvalidArgument, "the attribution has " + std::to_string(options.attribution.size()) +
                                                  " bytes; at most " + std::to_string(kMaxAttributionBytes) + " fit"};
  const uint8_t index = section.addLayer(layer);
  return ImageryMaker(picture, boundsOf, options, keepGoing, section, index).make();
}

}  // namespace foreland::terrain
