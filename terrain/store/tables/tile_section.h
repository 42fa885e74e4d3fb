// The section of tiles as it lies in a scene file, and how it is made. Change docs/SCENE_FORMAT.md with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/imagery/tile.h"
#include "terrain/store/file/spool_file.h"

namespace foreland::terrain {

// Followed by `layers` StoredLayer, then for each layer a StoredTile for every tile it has (in the order of
// tileNumber), then the attributions, then the tiles' bytes. On a globe, most of whose tiles need not be there, a
// layer's tiles are a tree instead: one StoredTile for each face's coarsest tile, then level by level, the coarser
// first, and in the order of their parents, the four children of each tile that has one that is stored. `children` is
// the number of the first of these in the layer, 0 if there are none.
struct TileSectionStart {
  uint32_t layers = 0, zero = 0;
};
struct StoredLayer {
  uint32_t content, coding, width, height;
  double origin[2], texel, step_m;
  uint32_t attribution_bytes;
  uint32_t tiles;  // on a globe how many StoredTile there are, else 0
};
struct StoredTile {
  uint64_t offset;  // of its bytes, from the section's start
  uint32_t bytes;   // 0: it is not stored, and the rest is zero too
  float detail, lowest_m, highest_m;
  int8_t axis[3];
  uint8_t half_angle;
  uint32_t children;
};
static_assert(sizeof(TileSectionStart) == 8 && sizeof(StoredLayer) == 56 && sizeof(StoredTile) == 32);
static_assert(std::is_trivially_copyable_v<StoredLayer> && std::is_trivially_copyable_v<StoredTile>);

inline constexpr uint32_t kMaxAttributionBytes = 1u << 12;

// How many tiles a layer has, and a number below that for each: level by level from the finest, row by row from the
// south, from west to east.
uint64_t tileCount(const proto::TileLayer& layer);
uint64_t tileNumber(const proto::TileLayer& layer, const proto::TileId& tile);

// The tiles of a globe's layer that are stored, as its tree has them, with the empty ones between them. Closed under
// parents. At most `most`, however many a damaged file has.
std::vector<proto::TileId> treeOf(const proto::TileLayer& layer, uint8_t index, size_t most,
                                  const std::function<bool(const proto::TileId&)>& isStored);

// Collects tiles. Coded tiles wait in a file, so memory is that of the directory alone.
class TileSection {
 public:
  // For a scene file at `target`.
  static Result<TileSection> create(const std::filesystem::path& target);

  // The layer must be valid. Returns its index.
  uint8_t addLayer(const proto::TileLayer& layer);
  const proto::TileLayer& layer(uint8_t index) const { return layers_[index]; }
  // Each tile at most once, in any order; several threads at once. `detail`: see TileTable::detail().
  Status add(const proto::TileId& tile, ByteSpan bytes, const proto::TileBounds& bounds, float detail);

  // What was added.
  bool has(const proto::TileId& tile) const {
    const StoredTile* found = find(tile);
    return found != nullptr && found->bytes > 0;
  }
  proto::TileBounds bounds(const proto::TileId& tile) const;

  // Size of the whole section; 0 without layers.
  uint64_t bytes() const;
  // Calls put(offset, bytes) for all of its bytes(), in pieces. They do not depend on the order of add().
  Status write(const std::function<Status(uint64_t offset, ByteSpan what)>& put) const;

  // A file for who makes tiles, on the disk where they wait.
  Result<SpoolFile> scratch() const { return SpoolFile::create(target_); }

 private:
  TileSection(SpoolFile spool, std::filesystem::path target) : target_(std::move(target)), spool_(std::move(spool)) {}
  const StoredTile* find(const proto::TileId& tile) const;
  std::vector<StoredTile> directory(uint8_t layer) const;

  std::filesystem::path target_;
  SpoolFile spool_;
  std::vector<proto::TileLayer> layers_;
  // Offsets are those in the spool. Of layers of a globe `tiles_` is empty, and what was added is in `sparse_`.
  std::vector<std::vector<StoredTile>> tiles_;
  struct Sparse {
    std::mutex mutex;
    std::unordered_map<uint64_t, StoredTile> tiles;  // by key
  };
  std::unique_ptr<Sparse> sparse_ = std::make_unique<Sparse>();
};

}  // namespace foreland::terrain
