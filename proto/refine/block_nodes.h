// Which nodes of an adapter's frontier a block of the terrain concerns (hidden_blocks.h). Pure; any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "proto/refine/frontier.h"
#include "proto/refine/hidden/hidden_blocks.h"

namespace foreland::proto {

namespace block_nodes_detail {

// Calls visit(page number) for each page of a level with nodes in the tiles from (x0, y0) to (x1, y1), both included;
// at the grid's far borders perhaps for others, too.
template <class Visit>
void forEachPage(const GridTopology& grid, const Frontier::Nodes& nodes, int level, uint32_t scale, uint32_t x0,
                 uint32_t y0, uint32_t x1, uint32_t y1, const Visit& visit) {
  const uint32_t s = 1u << scale, side = GridTopology::kTileSide * s;
  const auto visitPageAt = [&](uint32_t x, uint32_t y) {
    if (x > grid.maxX() || y > grid.maxY()) return;
    const uint32_t number = nodes.find(grid.slot(NodeId::at(x + s, level & 1 ? y : y + s), level));
    if (number != Frontier::Nodes::kNone) visit(number);
  };
  for (uint32_t y = y0; y <= y1; ++y)
    for (uint32_t x = x0; x <= x1; ++x) {
      visitPageAt(x * side, y * side);
      if (level & 1) visitPageAt(x * side, y * side + side / 2);
    }
}

// The levels of a scale that have nodes: the coarsest has no centres, which are base vertices.
inline std::array<int, 2> levelsOf(const GridTopology& grid, uint32_t scale) {
  const int level = grid.levelOfScale(scale);
  return {level, level + 1};
}

}  // namespace block_nodes_detail

// Calls visit(page number, low) for each frontier node, of the block's scale or a finer one, whose blocks may include
// it or a part of it: those that lie no more than 3 s beside it, with s of their own scale. Of each level O(tiles), or
// O(pages that are there) where these are fewer, as they are of levels much finer than a block.
template <class Visit>
void forEachNodeAbout(const GridTopology& grid, const Frontier::Nodes& nodes, const BlockId& block,
                      const Visit& visit) {
  const int64_t side = int64_t{BlockId::kSide} << block.scale, x = block.x * side, y = block.y * side;
  for (uint32_t scale = block.scale + 1u; scale-- > 0;) {
    const int64_t s = int64_t{1} << scale, reach = 3 * s, tile = int64_t{GridTopology::kTileSide} << scale;
    const int64_t x0 = std::max<int64_t>(0, x - reach), y0 = std::max<int64_t>(0, y - reach),
                  x1 = std::min<int64_t>(grid.maxX(), x + side + reach),
                  y1 = std::min<int64_t>(grid.maxY(), y + side + reach);
    for (int level : block_nodes_detail::levelsOf(grid, scale)) {
      if (level == 0) continue;
      const auto pages = nodes.pagesOf(grid.levelOffset(level), grid.levelOffset(level + 1));
      if (pages.empty()) continue;
      const auto visitPage = [&](uint32_t number) {
        const FrontierPage& page = nodes.page(number);
        const auto names = grid.pageNodes(level, page.first());
        page.on_frontier.forEach([&](uint8_t low) {
          const NodeId n = names.at(low);
          if (n.x() >= x0 && n.x() <= x1 && n.y() >= y0 && n.y() <= y1) visit(number, low);
        });
      };
      if (static_cast<uint64_t>((x1 - x0) / tile + 1) * static_cast<uint64_t>((y1 - y0) / tile + 1) > pages.size()) {
        for (const auto& page : pages) {
          const NodeId n = grid.pageNodes(level, nodes.page(page.number).first()).at(0);  // up to s from its corner
          if (n.x() <= x1 + s && n.y() <= y1 + s && n.x() + tile > x0 && n.y() + tile > y0) visitPage(page.number);
        }
        continue;
      }
      block_nodes_detail::forEachPage(grid, nodes, level, scale, static_cast<uint32_t>(x0 / tile),
                                      static_cast<uint32_t>(y0 / tile), static_cast<uint32_t>(x1 / tile),
                                      static_cast<uint32_t>(y1 / tile), visitPage);
    }
  }
}

// Whether any node of a tile's scale that is in the section or on its frontier may lie in the tile or less than a tile
// beside it. If not, no such node, of the scale or a finer one, depends on the tile's blocks.
inline bool hasNodesNear(const GridTopology& grid, const Frontier::Nodes& nodes, const BlockId& lowest) {
  bool any = false;
  constexpr uint32_t kTile = 1u << HiddenBlocks::kTileLog2, kBlocks = GridTopology::kTileSide / BlockId::kSide;
  const uint32_t x0 = (std::max(lowest.x, kTile) - kTile) / kBlocks, y0 = (std::max(lowest.y, kTile) - kTile) / kBlocks,
                 x1 = (lowest.x + 2 * kTile - 1) / kBlocks, y1 = (lowest.y + 2 * kTile - 1) / kBlocks;
  for (int level : block_nodes_detail::levelsOf(grid, lowest.scale))
    if (level > 0)
      block_nodes_detail::forEachPage(grid, nodes, level, lowest.scale, x0, y0, x1, y1, [&](uint32_t) { any = true; });
  return any;
}

}  // namespace foreland::proto
