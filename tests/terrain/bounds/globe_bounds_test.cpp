// Errors and spheres of a globe's nodes by brute force: every vertex of every support, wherever edges of the cube cross
// it; and the file that is made of them is sound.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <vector>

#include "proto/space/frame_grid.h"
#include "terrain/store/verify.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::CubePlace;
using proto::NodeId;

class GlobeBounds : public testing::Test {
 protected:
  const uint64_t seed = test::randomSeed();
  const std::shared_ptr<const Scene> scene = test::makeGlobeScene(5, seed);
  const proto::GridTopology& grid = scene->grid();
  const proto::Cube cube = grid.cube();
  const proto::FrameGrid positions{scene->frame(), grid.maxX(), grid.maxY()};

  glm::dvec3 at(const CubePlace& p) const {
    const NodeId v = cube.name(p);
    return positions.position(v, scene->height(v));
  }
  // Calls visit(true position, position without the node) for every vertex of the node's triangles.
  template <class Visit>
  void forSupport(NodeId n, const Visit& visit) const {
    const auto s = static_cast<int32_t>(1u << grid.scaleLog2(n));
    for (const CubePlace& p : cube.placesOf(n))
      for (int32_t dy = -s; dy <= s; ++dy)
        for (int32_t dx = -s; dx <= s; ++dx) visitAt(p, s, dx, dy, visit);
  }
  template <class Visit>
  void visitAt(const CubePlace& p, int32_t s, int32_t dx, int32_t dy, const Visit& visit) const {
    const CubePlace q{p.face, p.x + dx, p.y + dy};
    if (!cube.isWithin(q)) return;
    const bool along_x = (p.x & s) != 0, is_centre = along_x && (p.y & s) != 0;
    const bool rises = ((p.x & 2 * s) == 0) == ((p.y & 2 * s) == 0);
    // Half of the edge, and the way to an apex: at right angles.
    const glm::ivec2 e = is_centre ? glm::ivec2(s, rises ? s : -s) : along_x ? glm::ivec2(s, 0) : glm::ivec2(0, s);
    const glm::ivec2 up(-e.y, e.x);
    const double length2 = e.x * e.x + e.y * e.y, u = (dx * e.x + dy * e.y) / length2,
                 v = (dx * up.x + dy * up.y) / length2;
    if (std::fabs(u) + std::fabs(v) > 1) return;
    const int32_t side = v < 0 ? -1 : 1;
    const glm::dvec3 a = at({p.face, p.x - e.x, p.y - e.y}), b = at({p.face, p.x + e.x, p.y + e.y});
    const glm::dvec3 coarse = 0.5 * (a + b) + 0.5 * u * (b - a);
    if (v == 0) return visit(at(q), coarse);
    const glm::dvec3 apex = at({p.face, p.x + side * up.x, p.y + side * up.y});
    visit(at(q), coarse + std::fabs(v) * (apex - 0.5 * (a + b)));
  }
  std::vector<NodeId> nodes() const {
    std::vector<NodeId> all;
    for (proto::Slot slot = 0; slot < grid.slotCount(); ++slot)
      if (const NodeId n = grid.node(slot); !grid.isBase(n)) all.push_back(n);
    return all;
  }
};

TEST_F(GlobeBounds, ErrorsAreExactAndSaturated) {
  std::map<NodeId, proto::QuantisedError> expected;
  const std::vector<NodeId> all = nodes();
  for (auto n = all.rbegin(); n != all.rend(); ++n) {  // children first
    double worst = 0;
    forSupport(*n, [&](const glm::dvec3& truth, const glm::dvec3& coarse) {
      worst = std::max(worst, glm::distance(truth, coarse));
    });
    proto::QuantisedError error = proto::QuantisedError::roundUp(worst);
    for (NodeId child : grid.children(*n)) error = std::max(error, expected.at(child));
    expected[*n] = error;
    // Rounding may lift an error over a step.
    ASSERT_GE(scene->node(*n).error(), error);
    ASSERT_LE(scene->node(*n).error().value, error.value + 1);
  }
}

TEST_F(GlobeBounds, SpheresHoldTheirSupportsTrueAndCoarse) {
  for (NodeId n : nodes()) {
    const NodeRecord& record = scene->node(n);
    const glm::dvec3 centre = positions.position(n, record.middle());
    const double radius = scene->spheres().radius(grid.level(n), record.radius());
    forSupport(n, [&](const glm::dvec3& truth, const glm::dvec3& coarse) {
      ASSERT_LE(glm::distance(truth, centre), radius);
      ASSERT_LE(glm::distance(coarse, centre), radius);
    });
  }
}

TEST_F(GlobeBounds, AFileOfThemIsSound) {
  const test::TemporaryFolder folder;
  for (const uint32_t sparse : {0u, 5u}) {
    const auto report = verifyScene(test::globeFile(folder, 7, seed, sparse), 1);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->faults, 0u) << report->first_faults.front();
    EXPECT_GT(report->nodes, 5000u);
  }
}

}  // namespace
}  // namespace foreland::terrain
