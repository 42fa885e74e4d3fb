// Objects on a terrain, from the scene's records to the client's mesh. What must be drawn is refined from scratch from
// the records (tests/protocol/expectation.h), so nothing of what was sent or of the client is taken for granted.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "proto/topology/mesh_triangles.h"
#include "sim/world.h"
#include "tests/protocol/expectation.h"
#include "tests/support/globe_scene.h"
#include "tests/support/scene.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using sim::onKnownTour;
using sim::World;

using proto::NodeId;
using proto::Section;

// p_S(v) as THEORY section 2 has it, in the scene's frame.
class Drawn {
 public:
  Drawn(const proto::ObjectPlacement& placement, const Section& section)
      : surface_(models().surfaces[placement.model]), placement_(placement), section_(section) {}

  bool holds(NodeId n) const { return proto::contains(section_, surface_.topology.slot(n)); }
  glm::dvec3 at(NodeId v) const { return placement_.toScene(inObject(v)); }

 private:
  glm::dvec3 inObject(NodeId v) const {
    if (surface_.topology.isBase(v) || holds(v)) return surface_.position(v);
    const auto [a, b] = surface_.topology.endpoints(v);
    return 0.5 * (inObject(a) + inObject(b));
  }

  const terrain::TrueSurface& surface_;
  const proto::ObjectPlacement& placement_;
  const Section& section_;
};

using Corner = std::array<double, 6>;  // of a triangle: in `from` and in `to`, metres
using Triangles = std::vector<std::array<Corner, 3>>;

Corner cornerOf(const glm::dvec3& from, const glm::dvec3& to) { return {from.x, from.y, from.z, to.x, to.y, to.z}; }

Triangles expected(const server::SceneObjects& objects, const std::vector<Section>& from,
                   const std::vector<Section>& to, const glm::dvec3& origin) {
  Triangles all;
  for (size_t i = 0; i < objects.set.size(); ++i) {
    const Drawn a(objects.set.placement(i), from[i]), b(objects.set.placement(i), to[i]);
    proto::forEachTriangle(
        objects.set.domain(i).topology(), [&](NodeId n) { return a.holds(n) || b.holds(n); },
        [&](NodeId p, NodeId q, NodeId r) {
          std::array<Corner, 3> t;
          const NodeId names[3] = {p, q, r};
          for (int k = 0; k < 3; ++k) t[k] = cornerOf(a.at(names[k]) - origin, b.at(names[k]) - origin);
          all.push_back(t);
        });
  }
  return all;
}

// Triangles with three times the same corner are none.
template <class Visit>
void forEachDrawn(const client::BlendMesh& mesh, const Visit& visit) {
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::array<uint32_t, 3> t{mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]};
    if (t[0] != t[1] || t[0] != t[2]) visit(t);
  }
}

Triangles drawn(const client::BlendMesh& mesh) {
  Triangles all;
  forEachDrawn(mesh, [&](const std::array<uint32_t, 3>& corners) {
    std::array<Corner, 3>& t = all.emplace_back();
    for (size_t k = 0; k < 3; ++k)
      t[k] = cornerOf(glm::vec3(mesh.from_positions[corners[k]]), glm::vec3(mesh.to_positions[corners[k]]));
  });
  return all;
}

constexpr double kNear_m = 0.01;  // positions of the mesh are floats

bool isNear(const std::array<Corner, 3>& a, const std::array<Corner, 3>& b) {
  for (size_t k = 0; k < 3; ++k)
    for (size_t axis = 0; axis < 6; ++axis)
      if (!(std::abs(a[k][axis] - b[k][axis]) <= kNear_m)) return false;
  return true;
}

// Whether each triangle of one is one of the other, in any order. Sought by the cells that a first corner is near.
testing::AssertionResult areNear(const Triangles& a, const Triangles& b) {
  if (a.size() != b.size()) return testing::AssertionFailure() << a.size() << " triangles, not " << b.size();
  const auto cell = [](double v) { return static_cast<int64_t>(std::floor(v)); };
  std::multimap<std::array<int64_t, 2>, size_t> found;
  for (size_t i = 0; i < a.size(); ++i) found.insert({{cell(a[i][0][0]), cell(a[i][0][1])}, i});
  const auto take = [&](const std::array<Corner, 3>& wanted) {
    for (const double dx : {-kNear_m, kNear_m})
      for (const double dy : {-kNear_m, kNear_m}) {
        const auto [begin, end] = found.equal_range({cell(wanted[0][0] + dx), cell(wanted[0][1] + dy)});
        for (auto it = begin; it != end; ++it) {
          if (!isNear(a[it->second], wanted)) continue;
          found.erase(it);
          return true;
        }
      }
    return false;
  };
  for (size_t i = 0; i < b.size(); ++i)
    if (!take(b[i])) return testing::AssertionFailure() << "triangle " << i << " is not drawn";
  return testing::AssertionSuccess();
}

// Closed surfaces: each edge has two triangles, which run along it in opposite directions.
uint64_t openEdges(const client::BlendMesh& mesh) {
  // A vertex on a base edge is stored once for each face, at the very same positions.
  using Positions = std::array<float, 6>;
  const auto at = [&](uint32_t v) {
    const glm::vec4 p = mesh.from_positions[v], q = mesh.to_positions[v];
    return Positions{p.x, p.y, p.z, q.x, q.y, q.z};
  };
  std::map<std::array<Positions, 2>, int> runs;
  forEachDrawn(mesh, [&](const std::array<uint32_t, 3>& t) {
    for (size_t k = 0; k < 3; ++k) ++runs[{at(t[k]), at(t[(k + 1) % 3])}];
  });
  uint64_t open = 0;
  for (const auto& [edge, count] : runs) {
    const auto twin = runs.find({edge[1], edge[0]});
    open += count != 1 || twin == runs.end() || twin->second != 1;
  }
  return open;
}

std::vector<Section> heldBy(const client::Viewer& viewer) {
  std::vector<Section> all;
  for (const client::ObjectReplica& object : viewer.replica()->objects()) all.push_back(object.section());
  return all;
}

void expectDrawnByAllLaws(const std::shared_ptr<const terrain::Scene>& scene, double scale) {
  const server::SceneObjects objects = objectsIn(*scene, 8, scale);
  World world(scene, {}, Duration::milliseconds(4), 1, objectsIn(*scene, 8, scale));
  world.addClient(onKnownTour(*scene, "orbit", 30));
  uint32_t seen = 0;
  size_t checked = 0, most = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    if (std::exchange(seen, view.mesh_version) == view.mesh_version) return;
    EXPECT_EQ(openEdges(view.mesh->objects), 0u);
    most = std::max(most, view.mesh->drawnTriangles() - view.mesh->triangleCount());
    ++checked;
    const server::Hierarchy& hierarchy = world.session(0).world().hierarchy;
    ASSERT_TRUE(
        areNear(drawn(view.mesh->objects), expected(objects, sectionsOf(hierarchy, view.mesh->from).objects,
                                                    sectionsOf(hierarchy, view.mesh->to).objects, view.mesh->origin)));
  };
  world.run(Time::seconds(12));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(checked, 20u);
  size_t base = 0;
  for (size_t i = 0; i < objects.set.size(); ++i)
    base += objects.set.domain(i).topology().base().faceCount() * (i % 2 == 0 ? 1 : 3);
  EXPECT_GT(most, 2 * base);
}

TEST(Objects, AreDrawnAsTheTwoSectionsOfTheScenesRecordsAndWithoutCracks) {
  expectDrawnByAllLaws(makeScene(301, 217, 31), 1);
}

TEST(Objects, AreDrawnOnGlobesByTheSameLaws) { expectDrawnByAllLaws(makeGlobeScene(6, 3, 2), 20); }

TEST(Objects, ResumeAfterTheConnectionWasLost) {
  const auto scene = makeScene(301, 217, 32);
  World world(scene, {}, Duration::milliseconds(4), 2, objectsIn(*scene, 6));
  world.addClient(onKnownTour(*scene, "orbit", 30));
  double t = 1;
  for (int i = 0; i < 8; ++i) {
    world.run(Time::seconds(t += 0.7));
    world.loseConnection(0);
    world.run(Time::seconds(t += 0.1 * (i % 3)));
    world.connectAgain(0);
  }
  world.run(Time::seconds(t + 2));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(world.viewer(0).statistics().resumed, 4u);
  const std::vector<Section> held = heldBy(world.viewer(0));
  size_t nodes = 0;
  for (const Section& section : held) nodes += section.slots.size();
  EXPECT_GT(nodes, 0u);
}

}  // namespace
}  // namespace foreland::test
