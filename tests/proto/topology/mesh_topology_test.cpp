// Laws of proto/topology/mesh_topology.h over whole small surfaces, against subdivision done by hand
// (tests/support/mesh_reference.h).
#include "proto/topology/mesh_topology.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "tests/support/base_meshes.h"
#include "tests/support/mesh_reference.h"

namespace foreland::proto {
namespace {

using test::Key;
using test::keyOf;
using test::MeshReference;

using Case = std::tuple<test::NamedBase, MeshRule, uint32_t>;

MeshTopology makeMesh(const Case& c) {
  const auto& [base, rule, halvings] = c;
  return *MeshTopology::create({rule, halvings, base.vertices, base.faces});
}

class Mesh : public testing::TestWithParam<Case> {
 protected:
  template <class Visit>
  void forEachNode(const Visit& visit) const {
    for (Slot slot = 0; slot < mesh.slotCount(); ++slot)
      if (const NodeId n = mesh.node(slot); !mesh.isBase(n)) visit(n, slot);
  }
  std::set<Key> keysOf(const auto& list) const {
    std::set<Key> keys;
    for (NodeId v : list) keys.insert(keyOf(mesh, v));
    return keys;
  }
  const MeshTopology mesh = makeMesh(GetParam());
  const MeshReference reference{mesh};
};

TEST_P(Mesh, SlotsNameNodesOneToOneLevelByLevel) {
  std::set<NodeId> seen;
  forEachNode([&](NodeId n, Slot slot) {
    EXPECT_TRUE(seen.insert(n).second);
    EXPECT_TRUE(mesh.contains(n));
    EXPECT_EQ(mesh.slot(n), slot);
    EXPECT_GE(slot, mesh.levelOffset(mesh.level(n)));
    EXPECT_LT(slot, mesh.levelOffset(mesh.level(n) + 1));
  });
  EXPECT_EQ(seen.size(), reference.nodes().size());
  EXPECT_EQ(mesh.node(mesh.slotCount()), NodeId{});
  EXPECT_EQ(mesh.node(kNoSlot), NodeId{});
}

TEST_P(Mesh, NodesAreTheMiddlesOfTheEdgesOfTheCoarserMesh) {
  std::set<Key> keys;
  forEachNode([&](NodeId n, Slot) {
    const Key key = keyOf(mesh, n);
    ASSERT_TRUE(reference.nodes().contains(key));
    EXPECT_TRUE(keys.insert(key).second);
    EXPECT_EQ(mesh.level(n), reference.nodes().at(key).level);
    EXPECT_EQ(keysOf(mesh.endpoints(n)), reference.nodes().at(key).endpoints);
  });
  EXPECT_EQ(keys.size(), reference.nodes().size());
}

TEST_P(Mesh, BaseVerticesAreTheRootsCorners) {
  std::set<Key> corners, keys;
  for (const auto& t : reference.triangles(0))
    for (int i = 0; i < 3; ++i) corners.insert(reference.key(t, i));
  for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) {
    EXPECT_TRUE(mesh.contains(baseVertexId(v)));
    EXPECT_EQ(mesh.level(baseVertexId(v)), 0);
    keys.insert(keyOf(mesh, baseVertexId(v)));
  }
  EXPECT_EQ(keys, corners);
  EXPECT_FALSE(mesh.contains(baseVertexId(mesh.baseVertexCount())));
}

TEST_P(Mesh, ParentsAreOneLevelCoarserAndHoldTheSupport) {
  forEachNode([&](NodeId n, Slot) {
    const auto parents = mesh.parents(n);
    EXPECT_LE(parents.count, 2);
    EXPECT_EQ(keysOf(parents), reference.nodes().at(keyOf(mesh, n)).parents);
    EXPECT_EQ(keysOf(parents).size(), static_cast<size_t>(parents.count));
    std::set<size_t> covered;
    for (NodeId parent : parents) {
      EXPECT_EQ(mesh.level(parent), mesh.level(n) - 1);
      covered.merge(std::set(reference.nodes().at(keyOf(mesh, parent)).support));
    }
    for (size_t t : reference.nodes().at(keyOf(mesh, n)).support)
      EXPECT_TRUE(covered.contains(t) || mesh.level(n) == 1);
  });
}

TEST_P(Mesh, ChildrenAreTheNodesThatHaveItAsParent) {
  std::map<NodeId, std::set<NodeId>> children;
  forEachNode([&](NodeId n, Slot) {
    for (NodeId parent : mesh.parents(n)) children[parent].insert(n);
  });
  forEachNode([&](NodeId n, Slot) {
    std::set<NodeId> on_frontier;
    for (NodeId child : mesh.children(n)) EXPECT_TRUE(on_frontier.insert(child).second);
    EXPECT_EQ(on_frontier, children[n]);
    EXPECT_LE(on_frontier.size(), mesh.rule() == MeshRule::kQuadrisection ? 6u : 4u);
  });
}

TEST_P(Mesh, IdsOfNodesAreTheOnlyOnesItContains) {
  std::set<NodeId> nodes;
  forEachNode([&](NodeId n, Slot) { nodes.insert(n); });
  const uint32_t patches = mesh.base().edgeCount() + 2, side = (1u << mesh.halvings()) + 2;
  for (uint64_t patch = 0; patch < patches; ++patch)
    for (uint64_t y = 0; y < side; ++y)
      for (uint64_t x = 0; x < side; ++x) {
        const NodeId id{(patch + 1) << 32 | y << 16 | x};
        EXPECT_EQ(mesh.contains(id), nodes.contains(id)) << patch << ' ' << x << ' ' << y;
      }
  EXPECT_FALSE(mesh.contains({~0ull}));
  EXPECT_FALSE(mesh.contains({0xffffffffull << 32 | 1}));
}

TEST_P(Mesh, AVertexIsOnePointInAllFacesThatHoldIt) {
  const auto expectAt = [&](NodeId v) {
    const FacePoint place = mesh.facePoint(v);
    EXPECT_EQ(place.weights[0] + place.weights[1] + place.weights[2], mesh.weightScale());
    for (uint32_t i = 0; i < 3; ++i) {
      const HalfEdge h = 3 * place.face + i, twin = mesh.base().twin(h);
      if (place.weights[(i + 2) % 3] > 0 || twin == kNoHalfEdge) continue;
      EXPECT_EQ(keyOf(mesh, mesh.facePointIn(BaseMesh::face(twin), v)), keyOf(mesh, place));
    }
    EXPECT_EQ(keyOf(mesh, mesh.facePointIn(place.face, v)), keyOf(mesh, place));
  };
  forEachNode([&](NodeId n, Slot) { expectAt(n); });
  for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) expectAt(baseVertexId(v));
}

std::string nameOf(const testing::TestParamInfo<Case>& info) {
  const auto& [base, rule, halvings] = info.param;
  return base.name + (rule == MeshRule::kBisection ? "Bisected" : "Quadrisected") + std::to_string(halvings);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Mesh,
                         testing::Combine(testing::ValuesIn(test::baseMeshes()),
                                          testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection),
                                          testing::Values(1u, 2u, 3u)),
                         nameOf);

TEST(MeshShapes, OfDeepLatticesKeepTheLaws) {
  const test::NamedBase base = test::shuffled(test::fanBase(5), 9);
  for (MeshRule rule : {MeshRule::kQuadrisection, MeshRule::kBisection}) {
    const MeshTopology mesh = *MeshTopology::create({rule, 13, base.vertices, base.faces});
    const uint64_t seed = 20240101;
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    for (int i = 0; i < 20000; ++i) {
      const auto slot = static_cast<Slot>(rng.below(mesh.slotCount()));
      const NodeId n = mesh.node(slot);
      if (mesh.isBase(n)) continue;
      ASSERT_EQ(mesh.slot(n), slot);
      for (NodeId child : mesh.children(n)) {
        ASSERT_EQ(mesh.node(mesh.slot(child)), child);
        const auto parents = mesh.parents(child);
        EXPECT_TRUE(std::count(parents.begin(), parents.end(), n) == 1);
      }
    }
  }
}

TEST(MeshShapes, PutNearNodesInNearSlots) {
  const test::NamedBase base = test::torusBase(4, 4);
  for (MeshRule rule : {MeshRule::kQuadrisection, MeshRule::kBisection}) {
    const MeshTopology mesh = *MeshTopology::create({rule, 6, base.vertices, base.faces});
    double distance = 0, count = 0;
    for (Slot slot = mesh.levelOffset(mesh.maxLevel()); slot + 1 < mesh.slotCount(); ++slot) {
      const NodeId a = mesh.node(slot), b = mesh.node(slot + 1);
      if (mesh.isBase(a) || mesh.isBase(b)) continue;
      const PatchPoint p = patchPointOf(a), q = patchPointOf(b);
      distance += p.patch == q.patch ? std::abs(p.x - q.x) + std::abs(p.y - q.y) : 64;
      ++count;
    }
    EXPECT_LE(distance / count, 6);  // neighbours are 2 apart, any two about 40
  }
}

TEST(MeshShapes, AreRefusedWhenTheirNumbersAreWrong) {
  const auto refusal = [](MeshRule rule, uint32_t halvings, uint32_t faces) {
    const test::NamedBase base = test::fanBase(faces);
    const auto mesh = MeshTopology::create({rule, halvings, base.vertices, base.faces});
    return mesh.ok() ? std::string() : mesh.error().message;
  };
  EXPECT_NE(refusal(MeshRule::kBisection, 0, 3).find("0 halvings"), std::string::npos);
  EXPECT_NE(refusal(MeshRule::kQuadrisection, 16, 3).find("16 halvings"), std::string::npos);
  EXPECT_NE(refusal(static_cast<MeshRule>(2), 3, 3).find("rule 2"), std::string::npos);
  EXPECT_EQ(refusal(MeshRule::kQuadrisection, 15, 3), "");
  EXPECT_NE(refusal(MeshRule::kQuadrisection, 15, 12).find("2^32"), std::string::npos);
  EXPECT_NE(refusal(MeshRule::kBisection, 15, 4).find("2^32"), std::string::npos);
}

}  // namespace
}  // namespace foreland::proto
