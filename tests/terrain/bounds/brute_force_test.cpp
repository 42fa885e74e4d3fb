// Errors and spheres straight from their definitions, point by point and without the builder's arithmetic, against the
// scene file.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>
#include <vector>

#include "proto/space/frame.h"
#include "tests/support/scene.h"

namespace foreland::terrain {
namespace {

using proto::FrameKind;
using proto::NodeId;
using proto::QuantisedError;

constexpr double kErrorRounding = 1.41422, kRadiusRounding = 1.18921;  // the steps between classes

struct Case {
  uint32_t width, height;
  FrameKind kind;
  uint64_t seed;
  bool rough;
};

class BruteForce {
 public:
  explicit BruteForce(const Scene& scene) : scene_(scene), grid_(scene.grid()), transform_(scene.frame()) {
    for (uint32_t y = 0; y <= grid_.maxY(); ++y)
      for (uint32_t x = 0; x <= grid_.maxX(); ++x) positions_.push_back(compute(NodeId::at(x, y)));
  }

  // Lattice points of the closed triangle (a, b, c), data or not.
  static bool inside(NodeId a, NodeId b, NodeId c, NodeId q, double (&weight)[3]) {
    const auto cross = [](NodeId o, NodeId u, NodeId v) {
      const auto x = [&](NodeId w) { return int64_t{w.x()} - o.x(); };
      const auto y = [&](NodeId w) { return int64_t{w.y()} - o.y(); };
      return static_cast<double>(x(u) * y(v) - y(u) * x(v));
    };
    const double area = cross(a, b, c);
    weight[0] = cross(q, b, c) / area, weight[1] = cross(q, c, a) / area, weight[2] = cross(q, a, b) / area;
    return weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0;
  }

  glm::dvec3 position(NodeId v) const { return positions_[static_cast<size_t>(v.y()) * (grid_.maxX() + 1) + v.x()]; }

  glm::dvec3 compute(NodeId v) const {
    return transform_.toScene(proto::LatticePosition{static_cast<double>(v.x()), static_cast<double>(v.y()),
                                                     scene_.height(v) * scene_.frame().height_quantum_m});
  }

  template <class Visit>
  void forEachSupportPoint(NodeId n, const Visit& visit) const {
    const auto [a, b] = grid_.endpoints(n);
    for (NodeId c : grid_.apexes(n))
      for (uint32_t y = std::min({a.y(), b.y(), c.y()}); y <= std::max({a.y(), b.y(), c.y()}); ++y)
        for (uint32_t x = std::min({a.x(), b.x(), c.x()}); x <= std::max({a.x(), b.x(), c.x()}); ++x) {
          double w[3];
          const NodeId q = NodeId::at(x, y);
          if (inside(a, b, c, q, w)) visit(q, w[0] * position(a) + w[1] * position(b) + w[2] * position(c));
        }
  }

  // Of a node's sphere.
  glm::dvec3 middle(NodeId n) const {
    const auto [a, b] = grid_.endpoints(n);
    const double steps = std::floor((1.0 * scene_.height(a) + scene_.height(b)) / 2);
    return transform_.toScene(proto::LatticePosition{static_cast<double>(n.x()), static_cast<double>(n.y()),
                                                     steps * scene_.frame().height_quantum_m});
  }
  double radius(NodeId n) const { return scene_.spheres().radius(grid_.level(n), scene_.node(n).radius()); }

  double error(NodeId n) const {
    double worst = 0;
    forEachSupportPoint(n, [&](NodeId q, const glm::dvec3& coarse) {
      if (q.x() < grid_.shape().samples_x && q.y() < grid_.shape().samples_y)
        worst = std::max(worst, glm::distance(position(q), coarse));
    });
    return worst;
  }

  // Over the node and all its descendants.
  double saturatedError(NodeId n) {
    if (const auto known = saturated_.find(n); known != saturated_.end()) return known->second;
    double worst = error(n);
    for (NodeId child : grid_.children(n)) worst = std::max(worst, saturatedError(child));
    return saturated_[n] = worst;
  }

  template <class Visit>
  void forEachNode(const Visit& visit) const {
    for (uint32_t y = 0; y <= grid_.maxY(); ++y)
      for (uint32_t x = 0; x <= grid_.maxX(); ++x)
        if (!grid_.isBase(NodeId::at(x, y))) visit(NodeId::at(x, y));
  }

 private:
  const Scene& scene_;
  const proto::GridTopology& grid_;
  proto::FrameTransform transform_;
  std::vector<glm::dvec3> positions_;
  std::map<NodeId, double> saturated_;
};

class Bounds : public testing::TestWithParam<Case> {
 protected:
  std::shared_ptr<const Scene> scene = test::makeScene(
      GetParam().width, GetParam().height,
      GetParam().rough ? test::noise(GetParam().seed, 5000) : test::hills(GetParam().seed), GetParam().kind);
  BruteForce brute{*scene};
};

TEST_P(Bounds, ErrorsAreExactAndSaturated) {
  brute.forEachNode([&](NodeId n) {
    const double expected = brute.saturatedError(n), stored = scene->node(n).error().metres();
    // Of this test's own arithmetic: heights in metres are not exact, and geographic coordinates are large.
    const double rounding_m = GetParam().kind == FrameKind::kGeographic ? 2e-8 : 1e-10;
    EXPECT_GE(stored, expected - rounding_m) << n.x() << ", " << n.y();
    EXPECT_LE(stored, std::max<double>(QuantisedError{1}.metres(), (expected + 2e-7) * kErrorRounding))
        << n.x() << ", " << n.y();
    EXPECT_EQ(expected <= rounding_m, scene->node(n).error().value == 0);
  });
}

TEST_P(Bounds, SpheresHoldTheirSupportTrueAndCoarse) {
  brute.forEachNode([&](NodeId n) {
    const glm::dvec3 centre = brute.middle(n);
    const double radius = brute.radius(n);
    brute.forEachSupportPoint(n, [&](NodeId q, const glm::dvec3& coarse) {
      // Beyond the data the scene's heights are the clamped ones.
      EXPECT_LE(glm::distance(centre, brute.position(q)), radius);
      EXPECT_LE(glm::distance(centre, coarse), radius);
    });
  });
}

TEST_P(Bounds, SpheresNestWithSlackAndAreNoLargerThanAPageNeeds) {
  std::map<proto::Slot, double> excess;  // by page: the least stored over needed
  brute.forEachNode([&](NodeId n) {
    double needed = 0;
    for (NodeId child : scene->grid().children(n))
      needed = std::max(needed, glm::distance(brute.middle(n), brute.middle(child)) + brute.radius(child));
    if (scene->grid().children(n).count == 0)
      brute.forEachSupportPoint(n, [&](NodeId q, const glm::dvec3&) {
        needed = std::max(needed, glm::distance(brute.middle(n), brute.position(q)));
      });
    const double stored = brute.radius(n);
    EXPECT_GE(stored, needed + 5e-6);
    const proto::Slot page = scene->grid().slot(n) / proto::kPageSlots;
    const bool is_least = scene->node(n).radius().value == 0;
    const double here = is_least ? 0 : stored / (needed + 2e-5);
    excess[page] = excess.contains(page) ? std::min(excess[page], here) : here;
  });
  for (const auto& [page, ratio] : excess) EXPECT_LE(ratio, kRadiusRounding + 1e-6) << "page " << page;
}

TEST_P(Bounds, HeightsAreTheNearestQuantaAndContinueBeyondTheData) {
  const auto formula = GetParam().rough ? test::noise(GetParam().seed, 5000) : test::hills(GetParam().seed);
  for (uint32_t y = 0; y <= scene->grid().maxY(); ++y)
    for (uint32_t x = 0; x <= scene->grid().maxX(); ++x) {
      const float metres =
          static_cast<float>(formula(std::min(x, GetParam().width - 1), std::min(y, GetParam().height - 1)));
      EXPECT_NEAR(scene->height(NodeId::at(x, y)) * 0.1, metres, 0.0500001);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Terrains, Bounds,
    testing::Values(Case{2, 2, FrameKind::kPlanar, 1, true}, Case{3, 3, FrameKind::kPlanar, 2, true},
                    Case{5, 9, FrameKind::kPlanar, 3, true}, Case{17, 17, FrameKind::kPlanar, 4, false},
                    Case{18, 11, FrameKind::kPlanar, 5, true}, Case{33, 29, FrameKind::kPlanar, 6, false},
                    Case{40, 7, FrameKind::kPlanar, 7, true}, Case{270, 140, FrameKind::kPlanar, 12, true},
                    Case{600, 21, FrameKind::kPlanar, 13, false}, Case{262, 101, FrameKind::kGeographic, 14, false},
                    Case{2, 2, FrameKind::kGeographic, 8, true}, Case{9, 9, FrameKind::kGeographic, 9, false},
                    Case{17, 20, FrameKind::kGeographic, 10, true}, Case{31, 18, FrameKind::kGeographic, 11, false}));

}  // namespace
}  // namespace foreland::terrain
