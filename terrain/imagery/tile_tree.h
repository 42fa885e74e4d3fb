// The tiles of a globe's layer, of whatever they show: level by level from the finest, each level's texels from the
// finer tiles that there are and from the source elsewhere, with gutters that show the faces beyond. One caller; uses
// threads of its own while it runs; the result does not depend on their number. Memory: that of a tile a thread; the
// texels of two levels wait in files without names.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/check.h"
#include "terrain/imagery/cube_fold.h"
#include "terrain/imagery/relief.h"
#include "terrain/parallel.h"
#include "terrain/store/file/new_file.h"

namespace foreland::terrain {

// Which tiles of a layer there are to be, by level, the finest first. Closed under parents.
using WantedTiles = std::vector<std::vector<proto::TileId>>;
// By keys, with their ancestors and all coarsest tiles.
WantedTiles closedUnderParents(const proto::TileLayer& layer, uint8_t index, const std::set<uint64_t>& keys);

// The own texels of a level's tiles, row by row.
template <class Texel>
class LevelTexels {
 public:
  static constexpr size_t kTexels = size_t{proto::kTilePayload} * proto::kTilePayload;

  static Result<LevelTexels> create(const std::filesystem::path& target, const std::vector<proto::TileId>& tiles) {
    auto file = NewFile::create(target, std::max<size_t>(1, tiles.size()) * kTexels * sizeof(Texel));
    if (!file) return file.error();
    LevelTexels level;
    level.file_ = std::make_unique<NewFile>(std::move(*file));
    for (const proto::TileId& tile : tiles) level.places_.emplace(tile.key(), level.places_.size());
    return level;
  }
  bool has(const proto::TileId& tile) const { return places_.contains(tile.key()); }
  Texel* find(const proto::TileId& tile) const {
    const auto found = places_.find(tile.key());
    return found == places_.end() ? nullptr : reinterpret_cast<Texel*>(file_->data()) + found->second * kTexels;
  }

 private:
  std::unordered_map<uint64_t, size_t> places_;
  std::unique_ptr<NewFile> file_;
};

// A Source has
//   Texel                                              what a tile shows
//   Texel at(level, face, x, y)                        from scratch: of a texel on a face
//   Texel meanOf(const Texel& a, b, c, d)              of the four that a coarser one stands for
//   Texel beyond(level, FaceTexel, readTexel)          of a gutter, by readTexel(FaceTexel) of texels within faces
// and may be asked by several threads at once.
template <class Source>
class TileTree {
 public:
  using Texel = typename Source::Texel;
  using Level = LevelTexels<Texel>;

  TileTree(const proto::TileLayer& layer, uint8_t index, const Source& source, unsigned threads)
      : layer_(layer), index_(index), source_(source), threads_(threads) {}

  // Calls emit(tile, texels, worker), which gives a Status, for each wanted tile, all finer ones before it; `texels`
  // are those of the whole image. Returns whether it was not stopped.
  template <class Emit>
  Result<bool> make(const WantedTiles& wanted, const std::filesystem::path& target, const KeepGoing& keepGoing,
                    const Emit& emit) {
    size_t all = 0, before = 0;
    for (const auto& tiles : wanted) all += tiles.size();
    std::unique_ptr<Level> finer;
    for (const std::vector<proto::TileId>& tiles : wanted) {
      auto level = Level::create(target, tiles);
      if (!level) return level.error();
      const auto goOn = [&](double share) {
        return [&, share](uint64_t done) {
          return keepGoing((static_cast<double>(before) + share * static_cast<double>(tiles.size()) +
                            0.5 * static_cast<double>(done)) /
                           static_cast<double>(all));
        };
      };
      if (!parallelFor(
              tiles.size(), threads_, [&](uint64_t i, unsigned) { fill(tiles[i], finer.get(), level->find(tiles[i])); },
              goOn(0)))
        return false;
      FirstFailure failure;
      const auto make = [&](uint64_t i, unsigned worker) {
        std::vector<Texel> image;
        take(tiles[i], *level, image);
        failure.keep(emit(tiles[i], image, worker));
      };
      if (!parallelFor(tiles.size(), threads_, make, goOn(0.5))) return false;
      if (!failure.status().ok()) return failure.status().error();
      finer = std::make_unique<Level>(std::move(*level));
      before += tiles.size();
    }
    return true;
  }

 private:
  void fill(const proto::TileId& tile, const Level* finer, Texel* out) const {
    const uint32_t face = layer_.faceOf(tile), left = layer_.columnOf(tile) * proto::kTilePayload,
                   below = tile.y * proto::kTilePayload, side = layer_.widthAt(tile.level);
    const Texel* children[4]{};
    for (uint32_t k = 0; k < 4 && tile.level > 0; ++k) children[k] = finer->find(tile.child(k));
    constexpr uint32_t kChildSide = proto::kTilePayload / 2;
    for (uint32_t y = 0; y < proto::kTilePayload; ++y)
      for (uint32_t x = 0; x < proto::kTilePayload; ++x, ++out) {
        if (left + x >= side || below + y >= side) continue;
        const Texel* child = children[2 * (y / kChildSide) + x / kChildSide];
        if (child == nullptr) {
          *out = source_.at(tile.level, face, left + x, below + y);
          continue;
        }
        const Texel* four = child + size_t{2} * (y % kChildSide) * proto::kTilePayload + 2 * (x % kChildSide);
        *out = source_.meanOf(four[0], four[1], four[proto::kTilePayload], four[proto::kTilePayload + 1]);
      }
  }

  // Beyond the gutter of the face, which a partial tile is, texels repeat the last ones.
  void take(const proto::TileId& tile, const Level& level, std::vector<Texel>& image) const {
    const uint32_t face = layer_.faceOf(tile);
    const int64_t side = layer_.widthAt(tile.level), most = side - 1 + proto::kTileGutter,
                  left = int64_t{layer_.columnOf(tile)} * proto::kTilePayload - proto::kTileGutter,
                  below = int64_t{tile.y} * proto::kTilePayload - proto::kTileGutter;
    const auto readTexel = [&](const FaceTexel& t) { return read(tile.level, t, level); };
    image.resize(size_t{proto::kTileSide} * proto::kTileSide);
    auto out = image.begin();
    for (int64_t y = below; y < below + proto::kTileSide; ++y)
      for (int64_t x = left; x < left + proto::kTileSide; ++x) {
        const FaceTexel at{face, std::min(x, most), std::min(y, most)};
        *out++ = at.beyond(side) == 0 ? readTexel(at) : source_.beyond(tile.level, at, readTexel);
      }
  }
  Texel read(uint8_t level, const FaceTexel& t, const Level& texels) const {
    const auto x = static_cast<uint32_t>(t.x), y = static_cast<uint32_t>(t.y);
    const proto::TileId tile{index_, level, layer_.xOf(level, t.face, x / proto::kTilePayload),
                             y / proto::kTilePayload};
    const Texel* own = texels.find(tile);
    if (own == nullptr) return source_.at(level, t.face, x, y);
    return own[size_t{y % proto::kTilePayload} * proto::kTilePayload + x % proto::kTilePayload];
  }

  const proto::TileLayer& layer_;
  uint8_t index_;
  const Source& source_;
  unsigned threads_;
};

}  // namespace foreland::terrain
