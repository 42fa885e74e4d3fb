// Laws of proto/topology/grid.h on the cube, whole: over its edges and at its corners everything is as anywhere else.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <vector>

#include "base/rng.h"
#include "proto/topology/grid.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

GridTopology cubeOf(uint32_t log2) { return *GridTopology::create(GridTopology::cubeShape(log2)); }

// Every vertex once, by its name.
std::set<NodeId> verticesOf(const GridTopology& grid) {
  std::set<NodeId> all;
  for (uint32_t face = 0; face < Cube::kFaces; ++face)
    for (int32_t y = 0; y <= grid.cube().side(); ++y)
      for (int32_t x = 0; x <= grid.cube().side(); ++x) all.insert(grid.cube().name({face, x, y}));
  return all;
}

std::vector<NodeId> nodesOf(const GridTopology& grid) {
  std::vector<NodeId> nodes;
  for (NodeId v : verticesOf(grid))
    if (!grid.isBase(v)) nodes.push_back(v);
  return nodes;
}

bool has(const auto& list, NodeId wanted) { return std::find(list.begin(), list.end(), wanted) != list.end(); }

class CubeGrid : public testing::TestWithParam<uint32_t> {
 protected:
  const GridTopology grid = cubeOf(GetParam());
  const std::vector<NodeId> nodes = nodesOf(grid);
};

TEST_P(CubeGrid, BaseVerticesAreEightCornersAndSixCentres) {
  EXPECT_EQ(verticesOf(grid).size() - nodes.size(), 14u);
  const size_t side = grid.rootSize();
  EXPECT_EQ(nodes.size(), 6 * side * side + 2 - 14);
}

TEST_P(CubeGrid, SlotsNameNodesOneToOneLevelByLevel) {
  std::set<Slot> seen;
  for (NodeId n : nodes) {
    const Slot slot = grid.slot(n);
    ASSERT_LT(slot, grid.slotCount());
    ASSERT_TRUE(seen.insert(slot).second);
    ASSERT_EQ(grid.node(slot), n);
    ASSERT_GE(slot, grid.levelOffset(grid.level(n)));
    ASSERT_LT(slot, grid.levelOffset(grid.level(n) + 1));
    const Slot first = slot & ~(kPageSlots - 1);
    ASSERT_EQ(grid.pageNodes(grid.level(n), first).at(static_cast<uint32_t>(slot - first)), n);
  }
  for (Slot slot = 0; slot < grid.slotCount(); ++slot) ASSERT_EQ(grid.node(slot) == NodeId{}, !seen.contains(slot));
}

// From a level of 16 cells a side of a face on, no slot is padding.
TEST_P(CubeGrid, FineLevelsHaveNoPadding) {
  std::vector<size_t> count(static_cast<size_t>(grid.maxLevel()) + 1);
  for (NodeId n : nodes) ++count[static_cast<size_t>(grid.level(n))];
  for (int level = 8; level <= grid.maxLevel(); ++level)
    EXPECT_EQ(count[static_cast<size_t>(level)], grid.levelOffset(level + 1) - grid.levelOffset(level));
}

TEST_P(CubeGrid, SlotsOfApexesOfALevelAreThoseOfEachNodesApexes) {
  std::vector<GridTopology::ApexSlots> of_level;
  for (int level = 1; level <= grid.maxLevel(); ++level) of_level.emplace_back(grid, level);
  for (NodeId n : nodes) {
    const int level = grid.level(n);
    if (level == 1) continue;
    const auto apexes = grid.apexes(n, level);
    const std::array slots{grid.slot(apexes.ids[0]), grid.slot(apexes.ids[1])};
    EXPECT_EQ(of_level[static_cast<size_t>(level - 1)].of(n), slots);
  }
}

TEST_P(CubeGrid, ParentsAndChildrenAreMutual) {
  std::map<NodeId, std::set<NodeId>> children;
  for (NodeId n : nodes) {
    const auto apexes = grid.apexes(n);
    ASSERT_EQ(apexes.count, 2);
    ASSERT_NE(apexes.ids[0], apexes.ids[1]);
    for (NodeId apex : apexes) {
      ASSERT_EQ(grid.level(apex), grid.level(n) - 1);
      children[apex].insert(n);
    }
    ASSERT_EQ(grid.parents(n).count, grid.level(n) == 1 ? 0 : 2);
    for (NodeId end : grid.endpoints(n)) ASSERT_LT(grid.level(end), grid.level(n));
  }
  for (const auto& [apex, expected] : children) {
    std::set<NodeId> found;
    for (NodeId child : grid.children(apex, grid.level(apex))) ASSERT_TRUE(found.insert(child).second);
    ASSERT_EQ(found, expected);
    ASSERT_EQ(found.size(), 4u);
    for (NodeId child : found) {
      const auto both = grid.apexes(child);
      NodeId asked{};
      ASSERT_TRUE(grid.hasOtherParent(child, apex, [&](NodeId other) { return asked = other, true; }));
      ASSERT_NE(asked, apex);
      ASSERT_TRUE(has(both, asked));
      ASSERT_FALSE(grid.hasOtherParent(child, apex, [](NodeId) { return false; }));
    }
  }
  for (NodeId n : nodes) {
    if (grid.level(n) == grid.maxLevel()) { ASSERT_EQ(grid.children(n).count, 0); }
  }
}

// Halves root triangles as long as the section holds the node of the edge, in each face's own square; collects the
// leaves by the names of their corners.
struct Mesh {
  const GridTopology& grid;
  const std::set<NodeId>& section;
  std::map<std::pair<NodeId, NodeId>, int> edges;  // directed
  std::set<NodeId> corners;
  size_t triangles = 0;
  uint32_t face = 0;

  NodeId name(NodeId v) const { return grid.nameIn(face, v); }
  void bisect(NodeId a, NodeId b, NodeId apex) {
    const NodeId middle = NodeId::at((a.x() + b.x()) / 2, (a.y() + b.y()) / 2);
    const bool halves = (a.x() + b.x()) % 2 == 0 && (a.y() + b.y()) % 2 == 0;
    if (!halves || !section.contains(name(middle))) return leaf(name(a), name(b), name(apex));
    EXPECT_TRUE(has(grid.apexes(name(middle)), name(apex)));
    EXPECT_TRUE(has(grid.endpoints(name(middle)), name(a)) && has(grid.endpoints(name(middle)), name(b)));
    bisect(apex, a, middle);
    bisect(b, apex, middle);
  }
  void leaf(NodeId a, NodeId b, NodeId c) {
    ++triangles;
    for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) ++edges[edge];
    corners.insert({a, b, c});
  }
  void run() {
    const uint32_t size = grid.rootSize();
    for (face = 0; face < Cube::kFaces; ++face) {
      const uint32_t x = face * size;
      const NodeId sw = NodeId::at(x, 0), se = NodeId::at(x + size, 0), nw = NodeId::at(x, size),
                   ne = NodeId::at(x + size, size), centre = NodeId::at(x + size / 2, size / 2);
      bisect(sw, se, centre), bisect(se, ne, centre), bisect(ne, nw, centre), bisect(nw, sw, centre);
    }
  }
  // Closed, turned the same way everywhere, and a sphere.
  void expectASphere() const {
    for (const auto& [edge, uses] : edges) {
      ASSERT_EQ(uses, 1);
      ASSERT_TRUE(edges.contains({edge.second, edge.first}));
    }
    EXPECT_EQ(corners.size() + triangles, edges.size() / 2 + 2);
  }
};

TEST_P(CubeGrid, FullRefinementIsASphere) {
  const std::set<NodeId> all(nodes.begin(), nodes.end());
  Mesh mesh{.grid = grid, .section = all, .edges = {}, .corners = {}};
  mesh.run();
  mesh.expectASphere();
  EXPECT_EQ(mesh.corners.size(), nodes.size() + 14);
}

TEST_P(CubeGrid, AnySetClosedUnderParentsIsASphere) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 20; ++round) {
    std::set<NodeId> section;
    const auto close = [&](auto& self, NodeId n) -> void {
      if (!section.insert(n).second) return;
      for (NodeId parent : grid.parents(n)) self(self, parent);
    };
    for (NodeId n : nodes)
      if (rng.below(60) == 0) close(close, n);
    Mesh mesh{.grid = grid, .section = section, .edges = {}, .corners = {}};
    mesh.run();
    mesh.expectASphere();
    EXPECT_EQ(mesh.triangles, 24 + 2 * section.size());
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, CubeGrid, testing::Values(1u, 2u, 3u, 5u, 6u));

TEST(CubeShapes, AreFullAndSixByOne) {
  EXPECT_TRUE(GridTopology::create(GridTopology::cubeShape(24, 46)).ok());
  GridShape shape = GridTopology::cubeShape(5);
  EXPECT_TRUE(GridTopology::create(shape).ok());
  shape.samples_x -= 1;
  EXPECT_FALSE(GridTopology::create(shape).ok());
  shape = GridTopology::cubeShape(5);
  shape.roots_x = 5;
  EXPECT_FALSE(GridTopology::create(shape).ok());
  EXPECT_FALSE(GridTopology::create(GridTopology::cubeShape(25)).ok());
}

// The finest names stay apart, and find their way back.
TEST(CubeShapes, TheLargestCubeHasASlotForEachNode) {
  const GridTopology grid = *GridTopology::create(GridTopology::cubeShape(24, 46));
  EXPECT_LT(grid.slotCount(), Slot{1} << kSlotBits);
  Rng rng(test::randomSeed());
  for (int i = 0; i < 100'000; ++i) {
    const auto side = static_cast<uint32_t>(grid.cube().side());
    const NodeId n = grid.cube().name({static_cast<uint32_t>(rng.below(6)), static_cast<int32_t>(rng.below(side + 1)),
                                       static_cast<int32_t>(rng.below(4) == 0 ? side : rng.below(side + 1))});
    if (grid.isBase(n)) continue;
    ASSERT_EQ(grid.node(grid.slot(n)), n);
    for (NodeId parent : grid.parents(n)) ASSERT_TRUE(has(grid.children(parent), n));
  }
}

}  // namespace
}  // namespace foreland::proto
