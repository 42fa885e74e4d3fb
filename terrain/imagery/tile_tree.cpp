#include "terrain/imagery/tile_tree.h"

namespace foreland::terrain {

WantedTiles closedUnderParents(const proto::TileLayer& layer, uint8_t index, const std::set<uint64_t>& keys) {
  const uint32_t levels = layer.levels();
  std::vector<std::set<uint64_t>> by_level(levels);
  for (uint32_t face = 0; face < layer.faces(); ++face)
    by_level.back().insert(proto::TileId{index, static_cast<uint8_t>(levels - 1), face, 0}.key());
  for (const uint64_t key : keys) by_level[proto::TileId::of(key).level].insert(key);
  for (uint32_t level = 0; level + 1 < levels; ++level)
    for (const uint64_t key : by_level[level]) by_level[level + 1].insert(proto::TileId::of(key).parent().key());
  WantedTiles wanted(levels);
  for (uint32_t level = 0; level < levels; ++level)
    for (const uint64_t key : by_level[level]) wanted[level].push_back(proto::TileId::of(key));
  return wanted;
}

}  // namespace foreland::terrain
