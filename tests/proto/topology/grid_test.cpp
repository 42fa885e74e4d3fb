// Laws of proto/topology/grid.h by brute force over whole small grids: the hierarchy is a bisection hierarchy, slots
// are a bijection.
#include "proto/topology/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "proto/section/bounds.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

const std::vector<GridShape> kShapes{{1, 1, 1, 3, 3},   {1, 1, 3, 9, 9},    {2, 3, 2, 7, 11},
                                     {3, 1, 4, 40, 17}, {1, 2, 6, 65, 100}, {8, 5, 3, 65, 38}};

GridTopology makeGrid(const GridShape& shape) { return *GridTopology::create(shape); }

template <class Visit>
void forEachVertex(const GridTopology& grid, const Visit& visit) {
  for (uint32_t y = 0; y <= grid.maxY(); ++y)
    for (uint32_t x = 0; x <= grid.maxX(); ++x) visit(NodeId::at(x, y));
}

template <class Visit>
void forEachNode(const GridTopology& grid, const Visit& visit) {
  forEachVertex(grid, [&](NodeId n) {
    if (!grid.isBase(n)) visit(n);
  });
}

bool has(auto list, NodeId wanted) { return std::find(list.begin(), list.end(), wanted) != list.end(); }

class Grid : public testing::TestWithParam<GridShape> {
 protected:
  GridTopology grid = makeGrid(GetParam());
};

TEST_P(Grid, BaseVerticesAreCornersAndCentresOfRoots) {
  const uint32_t size = grid.rootSize();
  forEachVertex(grid, [&](NodeId v) {
    const bool corner = v.x() % size == 0 && v.y() % size == 0;
    const bool centre = v.x() % size == size / 2 && v.y() % size == size / 2;
    EXPECT_EQ(grid.isBase(v), corner || centre);
  });
}

TEST_P(Grid, SlotsNameNodesOneToOneLevelByLevel) {
  std::set<Slot> seen;
  forEachNode(grid, [&](NodeId n) {
    const Slot slot = grid.slot(n);
    ASSERT_LT(slot, grid.slotCount());
    EXPECT_TRUE(seen.insert(slot).second);
    EXPECT_EQ(grid.node(slot), n);
    EXPECT_GE(slot, grid.levelOffset(grid.level(n)));
    EXPECT_LT(slot, grid.levelOffset(grid.level(n) + 1));
  });
  for (Slot slot = 0; slot < grid.slotCount(); ++slot)
    EXPECT_EQ(grid.node(slot) == NodeId{}, !seen.contains(slot)) << "slot " << slot;
  EXPECT_EQ(grid.node(grid.slotCount()), NodeId{});
  EXPECT_EQ(grid.node(kNoSlot), NodeId{});
}

TEST_P(Grid, PagesOfSlotsLieInOneLevel) {
  for (int level = 1; level <= grid.maxLevel() + 1; ++level) EXPECT_EQ(grid.levelOffset(level) % kPageSlots, 0u);
  forEachNode(grid, [&](NodeId n) {
    const int level = grid.level(n);
    const Slot slot = grid.slot(n), first = slot - slot % kPageSlots;
    EXPECT_EQ(grid.slot(n, level), slot);
    EXPECT_EQ(grid.pageNodes(level, first).at(slot - first), n);
  });
}

TEST_P(Grid, PagesStandInRows) {
  for (int level = 1; level <= grid.maxLevel(); ++level)
    for (Slot first = grid.levelOffset(level); first < grid.levelOffset(level + 1); first += kPageSlots) {
      const PagePlace page = grid.pagePlace(first);
      EXPECT_EQ(page.level, level);
      EXPECT_LT(page.column, grid.pageColumns(level));
      EXPECT_LT(page.row, grid.pageRows(level));
      EXPECT_EQ(grid.pageAt(page), first);
      EXPECT_EQ(grid.pagePlace(first + kPageSlots - 1), page);
    }
  // As far as their nodes lie apart.
  forEachNode(grid, [&](NodeId n) {
    const PagePlace page = grid.pagePlace(grid.slot(n));
    const uint32_t cell = 2u << grid.scaleLog2(n), rows = page.level % 2 == 1 ? 8 : 16;
    EXPECT_EQ(page.column, n.x() / cell / 16);
    EXPECT_EQ(page.row, n.y() / cell / rows);
  });
}

TEST_P(Grid, NodeIsTheMiddleOfItsEndpoints) {
  forEachNode(grid, [&](NodeId n) {
    const auto [a, b] = grid.endpoints(n);
    ASSERT_TRUE(grid.contains(a) && grid.contains(b));
    EXPECT_EQ(a.x() + b.x(), 2 * n.x());
    EXPECT_EQ(a.y() + b.y(), 2 * n.y());
    EXPECT_LT(grid.level(a), grid.level(n));
    EXPECT_LT(grid.level(b), grid.level(n));
  });
}

TEST_P(Grid, ApexesMakeRightAngledTrianglesOnBothSides) {
  forEachNode(grid, [&](NodeId n) {
    const auto [a, b] = grid.endpoints(n);
    const bool border = (a.x() == b.x() && (a.x() == 0 || a.x() == grid.maxX())) ||
                        (a.y() == b.y() && (a.y() == 0 || a.y() == grid.maxY()));
    ASSERT_EQ(grid.apexes(n).count, border ? 1 : 2);
    int64_t sides = 0;
    for (NodeId apex : grid.apexes(n)) {
      ASSERT_TRUE(grid.contains(apex));
      const auto along = [&](NodeId v) {
        return std::pair<int64_t, int64_t>(int64_t{v.x()} - n.x(), int64_t{v.y()} - n.y());
      };
      const auto [ex, ey] = along(b);
      const auto [px, py] = along(apex);
      EXPECT_EQ(ex * px + ey * py, 0);
      EXPECT_EQ(ex * ex + ey * ey, px * px + py * py);
      sides += ex * py - ey * px > 0 ? 1 : -1;
    }
    EXPECT_EQ(sides, border ? sides : 0);
  });
}

TEST_P(Grid, ParentsAreTheApexesThatAreNodesAndOneLevelCoarser) {
  forEachNode(grid, [&](NodeId n) {
    int nodes_above = 0;
    for (NodeId apex : grid.apexes(n)) {
      EXPECT_EQ(has(grid.parents(n), apex), !grid.isBase(apex));
      nodes_above += !grid.isBase(apex);
    }
    EXPECT_EQ(grid.parents(n).count, nodes_above);
    for (NodeId parent : grid.parents(n)) EXPECT_EQ(grid.level(parent), grid.level(n) - 1);
  });
}

TEST_P(Grid, SlotsOfApexesOfALevelAreThoseOfEachNodesApexes) {
  std::vector<GridTopology::ApexSlots> of_level;
  for (int level = 1; level <= grid.maxLevel(); ++level) of_level.emplace_back(grid, level);
  forEachNode(grid, [&](NodeId n) {
    const int level = grid.level(n);
    if (level == 1) return;
    const auto apexes = grid.apexes(n, level);
    const Slot first = grid.slot(apexes.ids[0]), second = apexes.count == 1 ? first : grid.slot(apexes.ids[1]);
    EXPECT_EQ(of_level[static_cast<size_t>(level - 1)].of(n), (std::array{first, second}));
  });
}

TEST_P(Grid, ChildrenAreTheNodesThatHaveItAsParent) {
  std::map<NodeId, std::set<NodeId>> children;
  forEachNode(grid, [&](NodeId n) {
    for (NodeId parent : grid.parents(n)) children[parent].insert(n);
  });
  forEachNode(grid, [&](NodeId n) {
    std::set<NodeId> on_frontier;
    for (NodeId child : grid.children(n)) EXPECT_TRUE(on_frontier.insert(child).second);
    EXPECT_EQ(on_frontier, children[n]);
    EXPECT_LE(on_frontier.size(), 4u);
  });
}

TEST_P(Grid, NodesWhoseSupportHoldsDataAreTheOnesThatTouchData) {
  const GridShape& shape = grid.shape();
  forEachNode(grid, [&](NodeId n) {
    uint32_t west = n.x(), south = n.y();
    const auto widen = [&](NodeId v) { west = std::min(west, v.x()), south = std::min(south, v.y()); };
    for (NodeId v : grid.endpoints(n)) widen(v);
    for (NodeId v : grid.apexes(n)) widen(v);
    EXPECT_EQ(grid.touchesData(n), west < shape.samples_x - 1 && south < shape.samples_y - 1);
  });
}

// Bisects root triangles as long as the section holds the node of the edge; collects the leaves.
struct Mesh {
  const GridTopology& grid;
  std::set<NodeId> section;
  std::map<std::pair<NodeId, NodeId>, int> edges;
  std::set<NodeId> corners;
  int64_t twice_area = 0;

  // (a, b) is the refinement edge; the triangle turns left.
  void bisect(NodeId a, NodeId b, NodeId apex) {
    const NodeId middle = NodeId::at((a.x() + b.x()) / 2, (a.y() + b.y()) / 2);
    const bool halves = (a.x() + b.x()) % 2 == 0 && (a.y() + b.y()) % 2 == 0;  // the finest edges have no node
    if (!halves || !section.contains(middle)) return leaf(a, b, apex);
    EXPECT_TRUE(has(grid.apexes(middle), apex));
    bisect(apex, a, middle);
    bisect(b, apex, middle);
  }
  void leaf(NodeId a, NodeId b, NodeId c) {
    const auto dx = [&](NodeId v) { return int64_t{v.x()} - a.x(); };
    const auto dy = [&](NodeId v) { return int64_t{v.y()} - a.y(); };
    EXPECT_GT(dx(b) * dy(c) - dy(b) * dx(c), 0);
    twice_area += dx(b) * dy(c) - dy(b) * dx(c);
    for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      ++edges[std::minmax(edge.first, edge.second)];
    corners.insert({a, b, c});
  }
  void run() {
    const uint32_t size = grid.rootSize();
    for (uint32_t y = 0; y < grid.maxY(); y += size)
      for (uint32_t x = 0; x < grid.maxX(); x += size) {
        const NodeId sw = NodeId::at(x, y), se = NodeId::at(x + size, y), nw = NodeId::at(x, y + size),
                     ne = NodeId::at(x + size, y + size), centre = NodeId::at(x + size / 2, y + size / 2);
        bisect(sw, se, centre), bisect(se, ne, centre), bisect(ne, nw, centre), bisect(nw, sw, centre);
      }
  }
  void expectConforming() {
    EXPECT_EQ(twice_area, 2ll * grid.maxX() * grid.maxY());
    for (const auto& [edge, uses] : edges) {
      const auto [a, b] = edge;
      const bool border = (a.x() == b.x() && (a.x() == 0 || a.x() == grid.maxX())) ||
                          (a.y() == b.y() && (a.y() == 0 || a.y() == grid.maxY()));
      EXPECT_EQ(uses, border ? 1 : 2);
    }
  }
};

TEST_P(Grid, FullRefinementConformsAndUsesEveryVertex) {
  Mesh mesh{.grid = grid, .section = {}, .edges = {}, .corners = {}};
  forEachNode(grid, [&](NodeId n) { mesh.section.insert(n); });
  mesh.run();
  mesh.expectConforming();
  EXPECT_EQ(mesh.corners.size(), size_t{grid.maxX() + 1} * (grid.maxY() + 1));
}

TEST_P(Grid, AnySetClosedUnderParentsConforms) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Mesh mesh{.grid = grid, .section = {}, .edges = {}, .corners = {}};
    const auto close = [&](auto& self, NodeId n) -> void {
      if (!mesh.section.insert(n).second) return;
      for (NodeId parent : grid.parents(n)) self(self, parent);
    };
    uint64_t state = seed * 0x9e3779b97f4a7c15ull;
    forEachNode(grid, [&](NodeId n) {
      state = state * 6364136223846793005ull + 1442695040888963407ull;
      if ((state >> 33) % 40 == 0) close(close, n);
    });
    mesh.run();
    mesh.expectConforming();
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Grid, testing::ValuesIn(kShapes));

TEST(GridShapes, AreRefusedWhenEmptyTooLargeOrTooSmallForTheirData) {
  const std::vector<GridShape> bad{{0, 1, 3, 3, 3},      {1, 0, 3, 3, 3},    {1, 1, 0, 2, 2},    {1, 1, 16, 3, 3},
                                   {1, 1, 3, 1, 3},      {1, 1, 3, 10, 3},   {1, 1, 3, 3, 10},   {1u << 31, 1, 1, 3, 3},
                                   {~0u, ~0u, 15, 3, 3}, {32, 32, 15, 3, 3}, {1, 1, 3, 3, 3, 5}, {32, 32, 15, 3, 3, 20},
                                   {6, 6, 15, 3, 3, 1}};
  for (const GridShape& shape : bad) EXPECT_FALSE(GridTopology::create(shape).ok());
}

// Of more nodes than 32 bits name.
TEST(Grids, WithSparseLevelsNameNodesOneToOne) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({7, 7, 15, 200'000, 200'000, 12});
  EXPECT_EQ(grid.wholeLevels(), 17);
  EXPECT_GT(grid.slotCount(), Slot{1} << 35);
  for (int i = 0; i < 100'000; ++i) {
    const uint32_t s = 1u << rng.below(15);
    const NodeId n = NodeId::at(static_cast<uint32_t>(rng.below(grid.maxX() + 1)) / s * s,
                                static_cast<uint32_t>(rng.below(grid.maxY() + 1)) / s * s);
    if (grid.isBase(n)) continue;
    const Slot slot = grid.slot(n);
    ASSERT_EQ(grid.node(slot), n) << "seed " << seed;
    ASSERT_EQ(grid.slot(n, grid.level(n)), slot);
    ASSERT_EQ(grid.pageNodes(grid.level(n), slot - slot % kPageSlots).at(static_cast<uint32_t>(slot % kPageSlots)), n);
    ASSERT_EQ(grid.pagePlace(slot).level, grid.level(n));
    const Slot any = rng.below(grid.slotCount());
    if (const NodeId other = grid.node(any); other != NodeId{}) { ASSERT_EQ(grid.slot(other), any) << "seed " << seed; }
  }
}

TEST(GridShapes, CoverTheSamplesWithFewRootsAndLittleWaste) {
  for (uint32_t x : {2u, 3u, 4u, 9u, 10u, 100u, 1025u, 3601u, 10800u, 16385u, 100000u})
    for (uint32_t y : {2u, 5u, 257u, 1201u, 16385u}) {
      const GridShape shape = GridTopology::shapeFor(x, y);
      const auto grid = GridTopology::create(shape);
      ASSERT_TRUE(grid.ok()) << x << " x " << y;
      EXPECT_LE(std::max(shape.roots_x, shape.roots_y), 8u);
      EXPECT_GE(grid->maxX() + 1, x);
      EXPECT_GE(grid->maxY() + 1, y);
      EXPECT_LT(grid->maxX() - grid->rootSize(), x - 1);
      EXPECT_LT(grid->maxY() - grid->rootSize(), y - 1);
    }
}

}  // namespace
}  // namespace foreland::proto
