#include "terrain/store/tile_table.h"

namespace foreland::terrain {

std::optional<proto::TileBounds> TileTable::bounds(const proto::TileId&) const { return std::nullopt; }
ByteSpan TileTable::bytes(const proto::TileId&) const { return {}; }
float TileTable::detail(const proto::TileId&) const { return 0; }

}  // namespace foreland::terrain
