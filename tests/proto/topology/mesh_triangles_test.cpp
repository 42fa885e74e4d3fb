// Meshes of random sections on every kind of base: watertight, without T-vertices, covering each face once, and exactly
// the piecewise linear surface of THEORY section 2.
#include "proto/topology/mesh_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include "tests/support/base_meshes.h"
#include "tests/support/mesh_reference.h"

namespace foreland::proto {
namespace {

using test::Key;
using test::keyOf;
using Nodes = std::unordered_set<NodeId>;

void close(const MeshTopology& mesh, NodeId n, Nodes& nodes) {
  if (!nodes.insert(n).second) return;
  for (NodeId parent : mesh.parents(n)) close(mesh, parent, nodes);
}

Nodes randomSection(const MeshTopology& mesh, uint64_t one_in, Rng& rng) {
  Nodes nodes;
  for (Slot slot = 0; slot < mesh.slotCount(); ++slot)
    if (const NodeId n = mesh.node(slot); !mesh.isBase(n) && rng.below(one_in) == 0) close(mesh, n, nodes);
  return nodes;
}

// Twice the area of weights' triangle, in units of the whole face being weightScale() squared.
int64_t twiceArea(const FacePoint& a, const FacePoint& b, const FacePoint& c) {
  const auto w = [](const FacePoint& p, int i) { return static_cast<int64_t>(p.weights[i]); };
  return (w(b, 1) - w(a, 1)) * (w(c, 2) - w(a, 2)) - (w(b, 2) - w(a, 2)) * (w(c, 1) - w(a, 1));
}

struct Drawn {
  const MeshTopology& mesh;
  const Nodes& section;
  using Edge = std::tuple<uint32_t, NodeId, NodeId>;  // the face it is inside of, or none; from, to
  std::map<Edge, int> edges;
  std::set<NodeId> vertices;

  void draw() {
    const int64_t scale = mesh.weightScale();
    for (uint32_t face = 0; face < mesh.base().faceCount(); ++face) {
      int64_t area = 0;
      const auto is_in_section = [&](NodeId n) { return section.contains(n); };
      forEachTriangleOf(mesh, face, is_in_section, [&](NodeId a, NodeId b, NodeId c) {
        const int64_t own = twiceArea(mesh.facePointIn(face, a), mesh.facePointIn(face, b), mesh.facePointIn(face, c));
        EXPECT_GT(own, 0);
        area += own;
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
          ++edges[edge(face, from, to)];
        vertices.insert({a, b, c});
      });
      EXPECT_EQ(area, scale * scale);
    }
  }
  // Base vertices that the edge's ends are between.
  std::set<uint32_t> corners(NodeId a, NodeId b) const {
    std::set<uint32_t> result;
    for (NodeId v : {a, b})
      for (const auto& [vertex, weight] : keyOf(mesh, v).weights) result.insert(vertex);
    return result;
  }
  Edge edge(uint32_t face, NodeId from, NodeId to) const {
    return {corners(from, to).size() == 3 ? face : ~0u, from, to};
  }
  bool isOnBorder(NodeId a, NodeId b) const {
    for (HalfEdge h = 0; h < 3 * mesh.base().faceCount(); ++h)
      if (mesh.base().twin(h) == kNoHalfEdge &&
          corners(a, b) == std::set{mesh.base().vertex(h), mesh.base().vertex(BaseMesh::next(h))})
        return true;
    return false;
  }
  void expectWatertight() const {
    for (const auto& [edge, uses] : edges) {
      const auto& [face, from, to] = edge;
      EXPECT_EQ(uses, 1);
      EXPECT_TRUE(edges.contains({face, to, from}) || isOnBorder(from, to));
    }
  }
  // What is drawn is the section and no more: other vertices are nodes beside active ones.
  void expectVertices() const {
    for (NodeId n : section) EXPECT_TRUE(vertices.contains(n));
    for (NodeId v : vertices) {
      if (mesh.isBase(v) || section.contains(v)) continue;
      ASSERT_EQ(mesh.rule(), MeshRule::kQuadrisection);
      const auto siblings = mesh.quad().siblings(patchPointOf(v));
      EXPECT_TRUE(std::any_of(siblings.begin(), siblings.end(), [&](NodeId n) { return section.contains(n); }));
    }
  }
};

using Case = std::tuple<test::NamedBase, MeshRule>;

class Triangles : public testing::TestWithParam<Case> {
 protected:
  MeshTopology makeMesh(uint32_t halvings) const {
    const auto& [base, rule] = GetParam();
    return *MeshTopology::create({rule, halvings, base.vertices, base.faces});
  }
};

TEST_P(Triangles, OfAnySectionAreWatertightAndCoverEachFaceOnce) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const MeshTopology mesh = makeMesh(static_cast<uint32_t>(1 + seed % 5));
    const Nodes section = randomSection(mesh, 1 + rng.below(60), rng);
    Drawn drawn{mesh, section, {}, {}};
    drawn.draw();
    drawn.expectWatertight();
    drawn.expectVertices();
  }
}

TEST_P(Triangles, OfNothingAreTheRootsAndOfAllTheFinest) {
  const MeshTopology mesh = makeMesh(3);
  const size_t roots = mesh.base().faceCount() * (mesh.rule() == MeshRule::kBisection ? 3 : 1);
  for (bool all : {false, true}) {
    size_t count = 0;
    forEachTriangle(
        mesh, [&](NodeId) { return all; }, [&](NodeId, NodeId, NodeId) { ++count; });
    EXPECT_EQ(count, all ? roots * 64 : roots);
  }
}

// p_S(v) = the middle of p_S at v's endpoints, plus the displacement if v is in S, and linear in every triangle. Whole
// numbers times powers of two, so exact.
TEST_P(Triangles, DrawExactlyTheSurfaceOfTheSection) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const MeshTopology mesh = makeMesh(3);
    const Nodes section = randomSection(mesh, 2 + rng.below(12), rng);
    std::unordered_map<NodeId, double> value;
    const auto number = [&] { return static_cast<double>(rng.below(2048)) - 1024; };
    for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) value[baseVertexId(v)] = number();
    std::vector<NodeId> nodes;
    for (Slot slot = 0; slot < mesh.slotCount(); ++slot)
      if (const NodeId n = mesh.node(slot); !mesh.isBase(n)) nodes.push_back(n);
    for (NodeId n : nodes) {
      const auto [a, b] = mesh.endpoints(n);
      value[n] = (value.at(a) + value.at(b)) / 2 + (section.contains(n) ? number() : 0);
    }
    const auto expectInside = [&](uint32_t face, NodeId a, NodeId b, NodeId c) {
      const FacePoint pa = mesh.facePointIn(face, a), pb = mesh.facePointIn(face, b), pc = mesh.facePointIn(face, c);
      const auto area = static_cast<double>(twiceArea(pa, pb, pc));
      for (NodeId n : nodes) {
        const FacePoint p = mesh.facePoint(n);
        if (p.face != face) continue;
        const int64_t u = twiceArea(p, pb, pc), v = twiceArea(pa, p, pc), w = twiceArea(pa, pb, p);
        if (u < 0 || v < 0 || w < 0) continue;
        const double drawn = (static_cast<double>(u) * value.at(a) + static_cast<double>(v) * value.at(b) +
                              static_cast<double>(w) * value.at(c)) /
                             area;
        EXPECT_EQ(drawn, value.at(n));
      }
    };
    for (uint32_t face = 0; face < mesh.base().faceCount(); ++face)
      forEachTriangleOf(
          mesh, face, [&](NodeId n) { return section.contains(n); },
          [&](NodeId a, NodeId b, NodeId c) { expectInside(face, a, b, c); });
  }
}

std::string nameOf(const testing::TestParamInfo<Case>& info) {
  const auto& [base, rule] = info.param;
  return base.name + (rule == MeshRule::kBisection ? "Bisected" : "Quadrisected");
}

INSTANTIATE_TEST_SUITE_P(Shapes, Triangles,
                         testing::Combine(testing::ValuesIn(test::baseMeshes()),
                                          testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection)),
                         nameOf);

}  // namespace
}  // namespace foreland::proto
