// Topology of bisection over a grid of root squares (P 2.1; THEORY section 2). Each root square has 2^k + 1 samples a
// side, shares its border with its neighbours, and has its centre inserted: four root triangles whose refinement edges
// are its sides. Corners and centres are the base vertices (level 0); every other lattice point is a node, refined by
// halving an edge.
//
// With s = 2^t the largest power of two dividing both x and y, a node is one of two kinds:
//   side    one of x/s, y/s odd:  midpoint of the side of a square of 2s; level 2(k-1-t)+1; parents are the centres beside it
//   centre  both odd:             centre of a square of 2s; level 2(k-1-t); its edge is the diagonal through the centre of
//                                 the enclosing square of 4s; parents are the two side nodes on the other diagonal
// So each node has at most two parents and four children, and a set closed under parents is a conforming mesh.
//
// The raster need not fill the roots: samples_x, samples_y say how far the data goes; triangles beyond are never drawn
// (oracle/reference/mesh_builder.cpp clips).
//
// The roots of a cube are its six faces, laid and glued as cube.h says. All of the above holds across its edges, each
// of which borders two squares like any line of the lattice; nothing lies outside. A node on an edge is named by one of
// the faces, and its offsets to others cross no more than that edge. The row of corners at y = W repeats those at y =
// 0, but for its first: base vertices are named like nodes (cube.h), and the others' heights are copies.
//
// Immutable after creation; any thread; every function is O(1) integer arithmetic.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "base/check.h"
#include "base/result.h"
#include "proto/topology/cube.h"
#include "proto/topology/node.h"

namespace foreland::proto {

// What a grid is made of; travels in the handshake and stands in the scene file.
struct GridShape {
  uint32_t roots_x = 1;    // root squares along x
  uint32_t roots_y = 1;    // root squares along y
  uint32_t root_log2 = 1;  // k: a root square spans 2^k sample intervals
  uint32_t samples_x = 3;  // data columns, at most roots_x * 2^k + 1
  uint32_t samples_y = 3;  // data rows
  // So many of the finest levels are sparse: not all of their pages need be there. Of all other levels all are.
  uint32_t sparse_levels = 0;
  bool is_cube = false;  // 6 x 1 roots are the faces of a cube, and full of data
  bool operator==(const GridShape&) const = default;
};

// Where a page (kPageSlots) lies among those of its level, which stand in rows: a tile of 16 x 16 centres is a page, of
// sides half a tile is, the lower or the upper one.
struct PagePlace {
  int level = 1;
  uint32_t column = 0, row = 0;
  bool operator==(const PagePlace&) const = default;
};

class GridTopology {
 public:
  static constexpr uint32_t kMaxRootLog2 = 15, kMaxCubeLog2 = 24;
  static constexpr uint32_t kMaxSamples = 1u << 20;  // per axis
  static constexpr int kMaxLevels = 2 * kMaxCubeLog2;
  static constexpr Slot kMaxWholeSlots = 0xffffffffu;           // of the levels that are whole
  static constexpr uint64_t kMaxPositions = uint64_t{1} << 37;  // of the lattice, but for cubes

  // Refuses shapes that are empty, larger than the limits above, without a level that is whole, or whose data exceeds
  // the roots.
  static Result<GridTopology> create(const GridShape& shape);

  // Root squares that cover `samples_x` x `samples_y` with at most about eight roots a side. Both at least 2.
  static GridShape shapeFor(uint32_t samples_x, uint32_t samples_y);
  // A cube with faces of 2^root_log2 steps a side.
  static GridShape cubeShape(uint32_t root_log2, uint32_t sparse_levels = 0) {
    return {Cube::kFaces, 1, root_log2, (Cube::kFaces << root_log2) + 1, (1u << root_log2) + 1, sparse_levels, true};
  }

  const GridShape& shape() const { return shape_; }
  bool isCube() const { return shape_.is_cube; }
  // How a cube's squares are laid.
  Cube cube() const { return Cube(shape_.root_log2); }
  uint32_t rootSize() const { return 1u << shape_.root_log2; }
  uint32_t maxX() const { return shape_.roots_x << shape_.root_log2; }
  uint32_t maxY() const { return shape_.roots_y << shape_.root_log2; }
  int maxLevel() const { return 2 * static_cast<int>(shape_.root_log2) - 1; }
  // The finest level all of whose pages are there, at least 1.
  int wholeLevels() const { return maxLevel() - static_cast<int>(shape_.sparse_levels); }
  // One past the largest slot.
  Slot slotCount() const { return level_offset_[maxLevel() + 1]; }
  Slot levelOffset(int level) const { return level_offset_[level]; }
  // The level of the centres whose coordinates have 2^scale as their largest power of two; the sides' is the next.
  int levelOfScale(uint32_t scale) const { return 2 * static_cast<int>(shape_.root_log2 - 1 - scale); }
  // A page has the centres, or half of the sides, of a tile of so many samples times 2^scale.
  static constexpr uint32_t kTileSide = 32;
  // Tiles of a level follow each other in the slot order, row by row, so many in a row.
  uint32_t tilesAlongX(int level) const { return tiles_x_[level]; }

  // The columns of pages of a level, and the rows.
  uint32_t pageColumns(int level) const { return tiles_x_[level]; }
  uint32_t pageRows(int level) const {
    return static_cast<uint32_t>((level_offset_[level + 1] - level_offset_[level]) / kPageSlots / tiles_x_[level]);
  }
  // Of a slot in the grid.
  PagePlace pagePlace(Slot slot) const {
    const int level = levelOf(slot);
    const Cell cell = cellOf(level, slot);
    return {level, cell.x >> kTileLog2, cell.y >> (kTileLog2 - (level & 1))};
  }
  // The first slot of a page in the grid.
  Slot pageAt(const PagePlace& page) const {
    const uint32_t sides = page.level & 1;
    const Slot tile = Slot{page.row >> sides} * tiles_x_[page.level] + page.column;
    return level_offset_[page.level] + ((tile << sides | (page.row & sides)) * kPageSlots);
  }

  // Whether it names a vertex.
  bool contains(NodeId n) const {
    if (isCube()) [[unlikely]]
      return namesCubeVertex(n);
    return n.x() <= maxX() && n.y() <= maxY();
  }
  // Whether a node lies on an edge of a cube.
  bool isOnSeam(NodeId n) const { return isCube() && cube().isOnSeam(n); }
  // The vertex at (x, y) on the square of root `root_x` (and of any row), which may lie on its far sides: its name.
  NodeId nameIn(uint32_t root_x, NodeId v) const { return isCube() ? nameOnFace(root_x, v) : v; }

  // log2 of the largest power of two dividing both coordinates, capped at k.
  uint32_t scaleLog2(NodeId n) const { return static_cast<uint32_t>(std::countr_zero((n.x() | n.y()) | rootSize())); }
  // 0 for base vertices.
  int level(NodeId n) const {
    const uint32_t t = scaleLog2(n);
    if (t >= shape_.root_log2) return 0;
    return levelOfScale(t) + 1 - static_cast<int>((n.x() & n.y()) >> t & 1);
  }
  bool isBase(NodeId n) const { return level(n) == 0; }

  // Here and below `n` is a node, of this level if one is given. Branches depend on the level and the border alone, for
  // these functions are called for many nodes of a level in turn.

  // The two vertices whose midpoint the node refines.
  std::array<NodeId, 2> endpoints(NodeId n, int level) const {
    const uint32_t t = scaleLog2At(level), s = 1u << t, x = n.x(), y = n.y();
    const uint32_t along_x = 0 - (x >> t & 1), dx = s & along_x,
                   dy = isCentreLevel(level) ? rise(x, y, t) : s & ~along_x;
    if (isCube()) [[unlikely]]
      return cubeEndpoints(n, dx, dy);
    return {NodeId::at(x - dx, y - dy), NodeId::at(x + dx, y + dy)};
  }
  std::array<NodeId, 2> endpoints(NodeId n) const { return endpoints(n, level(n)); }

  // The third vertices of the one or two triangles that share the node's edge: parents, or base vertices.
  NodeList<2> apexes(NodeId n, int level) const {
    const uint32_t t = scaleLog2At(level), s = 1u << t, x = n.x(), y = n.y();
    NodeList<2> result;
    if (isCube()) [[unlikely]]
      return cubeApexes(n, level);
    if (isCentreLevel(level)) {
      const uint32_t up = rise(x, y, t);
      result.push(NodeId::at(x - s, y + up));
      result.push(NodeId::at(x + s, y - up));
      return result;
    }
    const uint32_t along_x = 0 - (x >> t & 1), dx = s & ~along_x, dy = s & along_x;
    if (x >= dx && y >= dy) result.push(NodeId::at(x - dx, y - dy));
    if (x + dx <= maxX() && y + dy <= maxY()) result.push(NodeId::at(x + dx, y + dy));
    return result;
  }
  NodeList<2> apexes(NodeId n) const { return apexes(n, level(n)); }

  // The nodes that must be in a section before `n` can be.
  NodeList<2> parents(NodeId n, int level) const { return level == 1 ? NodeList<2>{} : apexes(n, level); }
  NodeList<2> parents(NodeId n) const { return parents(n, level(n)); }

  // The nodes of which `n` is a parent. `n` may also be the centre of a root, of level 0, whose children are parentless
  // or half so. A centre's are those west, east, south and north of it; a side's those south-west, south-east,
  // north-west and north-east, as seen on the square that names it, without those outside of the grid.
  NodeList<4> children(NodeId n, int level) const {
    const uint32_t t = scaleLog2At(level), x = n.x(), y = n.y();
    NodeList<4> result;
    if (isCube()) [[unlikely]]
      return cubeChildren(n, level);
    if (isCentreLevel(level)) {
      const uint32_t s = 1u << t;
      result.push(NodeId::at(x - s, y));
      result.push(NodeId::at(x + s, y));
      result.push(NodeId::at(x, y - s));
      result.push(NodeId::at(x, y + s));
      return result;
    }
    if (t == 0) return result;
    const uint32_t h = 1u << (t - 1);
    const bool has_west = x >= h, has_east = x + h <= maxX(), has_south = y >= h, has_north = y + h <= maxY();
    if (has_west && has_south) result.push(NodeId::at(x - h, y - h));
    if (has_east && has_south) result.push(NodeId::at(x + h, y - h));
    if (has_west && has_north) result.push(NodeId::at(x - h, y + h));
    if (has_east && has_north) result.push(NodeId::at(x + h, y + h));
    return result;
  }
  NodeList<4> children(NodeId n) const { return children(n, level(n)); }

  // Whether all parents of a child of `n` but `n` itself, of which there is at most one, are there: isThere(NodeId).
  template <class IsThere>
  bool hasOtherParent(NodeId child, NodeId n, const IsThere& isThere) const {
    const NodeId other = isCube() ? otherApex(child, n)
                                  : NodeId::at(2 * child.x() - n.x(), 2 * child.y() - n.y());  // on both sides of it
    return !contains(other) || isThere(other);
  }

  // Bijection between nodes and (some of the) slots. `n` is a node inside the grid.
  Slot slot(NodeId n) const { return slot(n, level(n)); }
  // The same for a node whose level is known.
  Slot slot(NodeId n, int level) const {
    const uint32_t t = scaleLog2At(level), sides = level & 1;
    const Slot cell = tileSlot(n.x() >> (t + 1), n.y() >> (t + 1), tiles_x_[level]);
    return level_offset_[level] + (cell << sides) + (sides & ~(n.x() >> t));
  }
  // The node of a slot, or base vertex (0, 0) if the slot is padding or out of range.
  NodeId node(Slot slot) const {
    if (slot >= slotCount()) return {};
    const int level = levelOf(slot);
    const uint32_t sides = level & 1, along_y = sides & static_cast<uint32_t>(slot - level_offset_[level]);
    const Cell cell = cellOf(level, slot);
    const uint32_t t = scaleLog2At(level), s = 1u << t;
    const NodeId n =
        NodeId::at((cell.x << (t + 1)) + (s & (along_y - 1)), (cell.y << (t + 1)) + (s & ((sides & ~along_y) - 1)));
    return contains(n) ? n : NodeId{};
  }

  // node() for the slots of one page (kPageSlots, which are all of one level), by their index in it; not for padding.
  class PageNodes {
   public:
    NodeId at(uint32_t low) const {
      const uint32_t cell = low >> sides_, along_y = low & sides_;
      return NodeId::at(x_ + ((cell & (kTile - 1)) << cell_log2_) + (half_ & (along_y - 1)),
                        y_ + (cell >> kTileLog2 << cell_log2_) + (half_ & ((sides_ & ~along_y) - 1)));
    }

   private:
    friend class GridTopology;
    uint32_t x_, y_, half_, cell_log2_, sides_;
  };
  PageNodes pageNodes(int level, Slot first) const {
    const uint32_t t = scaleLog2At(level);
    const Cell cell = cellOf(level, first);
    PageNodes page;
    page.x_ = cell.x << (t + 1);
    page.y_ = cell.y << (t + 1);
    page.half_ = 1u << t;
    page.cell_log2_ = t + 1;
    page.sides_ = level & 1;
    return page;
  }

  // The slots of apexes() for many nodes of one level above 1: what depends on the level alone is computed once.
  class ApexSlots {
   public:
    ApexSlots(const GridTopology& grid, int level)
        : grid_(grid),
          level_(level),
          t_(grid.scaleLog2At(level)),
          parent_t_(grid.scaleLog2At(level - 1)),
          parent_sides_(~static_cast<uint32_t>(level) & 1),
          tiles_x_(grid.tiles_x_[level - 1]),
          max_x_(grid.maxX()),
          max_y_(grid.maxY()),
          offset_(grid.level_offset_[level - 1]) {}
    // Of a single apex, twice the same.
    std::array<Slot, 2> of(NodeId n) const {
      if (grid_.isCube()) [[unlikely]]
        return ofCube(n);
      const uint32_t s = 1u << t_, x = n.x(), y = n.y();
      if (parent_sides_ != 0) {  // of centres
        const uint32_t up = rise(x, y, t_);
        return {slot(x - s, y + up), slot(x + s, y - up)};
      }
      const uint32_t along_x = 0 - (x >> t_ & 1), dx = s & ~along_x, dy = s & along_x;
      const bool has_first = x >= dx && y >= dy, has_second = x + dx <= max_x_ && y + dy <= max_y_;
      const Slot first = has_first ? slot(x - dx, y - dy) : slot(x + dx, y + dy);
      return {first, has_second ? slot(x + dx, y + dy) : first};
    }

   private:
    [[gnu::noinline]] std::array<Slot, 2> ofCube(NodeId n) const {
      const NodeList<2> both = grid_.cubeApexes(n, level_);
      const Slot first = grid_.slot(both.ids[0], level_ - 1);
      return {first, both.count == 1 ? first : grid_.slot(both.ids[1], level_ - 1)};
    }
    Slot slot(uint32_t x, uint32_t y) const {
      const Slot cell = tileSlot(x >> (parent_t_ + 1), y >> (parent_t_ + 1), tiles_x_);
      return offset_ + (cell << parent_sides_) + (parent_sides_ & ~(x >> parent_t_));
    }

    const GridTopology& grid_;
    int level_;
    uint32_t t_, parent_t_, parent_sides_, tiles_x_, max_x_, max_y_;
    Slot offset_;
  };

  // True if the node's support (its one or two triangles) holds data beyond its border.
  bool touchesData(NodeId n) const {
    const uint32_t s = 1u << scaleLog2(n);
    return (n.x() < s || n.x() - s < shape_.samples_x - 1) && (n.y() < s || n.y() - s < shape_.samples_y - 1);
  }

 private:
  static constexpr uint32_t kTileLog2 = 4, kTile = 1u << kTileLog2;

  // Of a cube: the vertex so many steps away, modulo 2^32, on the square that names the node, or as if the square
  // across the one edge that it lies on were a part of it.
  [[gnu::noinline]] NodeId moved(NodeId n, uint32_t dx, uint32_t dy) const {
    const uint32_t side = rootSize() - 1, x = (n.x() & side) + dx, y = n.y() + dy;
    if (x <= side && y <= side && n.x() < maxX()) return NodeId::at(n.x() + dx, y);
    return cube().moved(n, static_cast<int32_t>(dx), static_cast<int32_t>(dy));
  }
  // What else is a cube's alone, not in line: grids pay for it neither in size nor in registers.
  [[gnu::noinline]] std::array<NodeId, 2> cubeEndpoints(NodeId n, uint32_t dx, uint32_t dy) const {
    return {moved(n, 0 - dx, 0 - dy), moved(n, dx, dy)};
  }
  [[gnu::noinline]] bool namesCubeVertex(NodeId n) const {
    return n.x() < maxX() ? n.y() < maxY() || n == NodeId::at(0, maxY()) : n == NodeId::at(maxX(), 0);
  }
  [[gnu::noinline]] NodeId nameOnFace(uint32_t face, NodeId v) const {
    const uint32_t west = face << shape_.root_log2;
    return cube().name({face, static_cast<int32_t>(v.x() - west), static_cast<int32_t>(v.y())});
  }
  [[gnu::noinline]] NodeId otherApex(NodeId child, NodeId n) const {
    const NodeList<2> both = apexes(child);
    return both.ids[0] == n ? both.ids[1] : both.ids[0];
  }
  NodeList<2> cubeApexes(NodeId n, int level) const;
  NodeList<4> cubeChildren(NodeId n, int level) const;

  // Of a slot in the grid.
  int levelOf(Slot slot) const {
    int level = level_hint_[std::bit_width(slot)];
    while (slot >= level_offset_[level + 1]) ++level;  // levels grow about twofold, so rarely more than two steps
    return level;
  }
  // Of the nodes of a level.
  uint32_t scaleLog2At(int level) const { return shape_.root_log2 - 1 - (static_cast<uint32_t>(level) >> 1); }
  // The square of 2s that a slot belongs to.
  struct Cell {
    uint32_t x, y;
  };
  Cell cellOf(int level, Slot slot) const {
    const uint64_t cell = (slot - level_offset_[level]) >> (level & 1), tile = cell >> (2 * kTileLog2);
    // Division by multiplication: there are fewer than 2^kSlotBits / 256 tiles, and doubles hold a quotient below 2^32
    // to far better than one, so it is off by one at most. The tile is converted as a signed number, which takes one
    // instruction.
    const uint64_t tiles_x = tiles_x_[level];
    uint64_t row = static_cast<uint32_t>(static_cast<double>(static_cast<int64_t>(tile)) * inverse_tiles_x_[level]);
    row -= row * tiles_x > tile;
    row += tile - row * tiles_x >= tiles_x;
    const auto low = static_cast<uint32_t>(cell);
    return {static_cast<uint32_t>(tile - row * tiles_x) << kTileLog2 | (low & (kTile - 1)),
            static_cast<uint32_t>(row) << kTileLog2 | (low >> kTileLog2 & (kTile - 1))};
  }
  static bool isCentre(NodeId n, uint32_t t) { return (n.x() & n.y()) >> t & 1; }
  // Whether the nodes of a level are centres; else they are sides.
  static bool isCentreLevel(int level) { return (level & 1) == 0; }
  // A centre's edge leads to the centre of the square of 4s around it: the corner whose coordinates are both odd in 2s.
  // Modulo 2^32: s, or minus s if the diagonal falls.
  static uint32_t rise(uint32_t x, uint32_t y, uint32_t t) { return (1u << t) - (((x ^ y) >> (t + 1) & 1) << (t + 1)); }
  static Slot tileSlot(uint32_t cx, uint32_t cy, uint32_t tiles_x) {
    const Slot tile = Slot{cy >> kTileLog2} * tiles_x + (cx >> kTileLog2);
    return tile << (2 * kTileLog2) | (cy & (kTile - 1)) << kTileLog2 | (cx & (kTile - 1));
  }

  GridShape shape_;
  std::array<Slot, kMaxLevels + 2> level_offset_{};
  std::array<uint32_t, kMaxLevels + 1> tiles_x_{};
  std::array<double, kMaxLevels + 1> inverse_tiles_x_{};
  std::array<int, kSlotBits + 1> level_hint_{};  // by bit width of a slot: the level of the smallest slot of that width
};

}  // namespace foreland::proto
