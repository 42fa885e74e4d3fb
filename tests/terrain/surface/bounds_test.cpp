// Every bound of terrain/surface/bounds.h by brute force: random sections of every kind of surface, every vertex of the
// full resolution, hats and drawn positions from their definitions (THEORY section 2).
#include "terrain/surface/bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <string>

#include "proto/topology/mesh_triangles.h"
#include "tests/support/surfaces.h"

namespace foreland::terrain {
namespace {

using proto::MeshRule;
using proto::MeshTopology;
using proto::NodeId;
using proto::Slot;
using proto::SurfaceRecord;

// All vertices, base vertices first, then nodes level by level.
struct Vertices {
  explicit Vertices(const TrueSurface& surface) : mesh(surface.topology) {
    for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) ids.push_back(proto::baseVertexId(v));
    first_node = ids.size();
    number.assign(mesh.slotCount(), 0);
    forEachNode(mesh, [&](NodeId n, Slot slot) {
      number[slot] = ids.size();
      ids.push_back(n);
    });
  }
  size_t of(NodeId v) const { return mesh.isBase(v) ? proto::baseVertexOf(v) : number[mesh.slot(v)]; }
  // Values at the base vertices given: sums of hats with these coefficients.
  template <class Value>
  std::vector<Value> expand(std::vector<Value> values, const auto& coefficient) const {
    for (size_t v = first_node; v < ids.size(); ++v) {
      const auto [a, b] = mesh.endpoints(ids[v]);
      values.push_back((values[of(a)] + values[of(b)]) * 0.5 + coefficient(v));
    }
    return values;
  }

  const MeshTopology& mesh;
  std::vector<NodeId> ids;
  size_t first_node = 0;
  std::vector<size_t> number;
};

class Checker {
 public:
  Checker(const TrueSurface& surface, ErrorShape kind, std::vector<SurfaceRecord> records)
      : surface_(surface), mesh_(surface.topology), kind_(kind), records_(std::move(records)), all_(surface) {
    const auto normal = [&](NodeId a, NodeId b, NodeId c) {
      const glm::dvec3 n =
          glm::cross(surface.position(b) - surface.position(a), surface.position(c) - surface.position(a));
      normals_.resize(all_.ids.size());
      for (NodeId v : {a, b, c})
        if (glm::length(n) > 0) normals_[all_.of(v)].push_back(n / glm::length(n));
    };
    proto::forEachTriangle(
        mesh_, [](NodeId) { return true; }, normal);
  }

  // Every vertex, against every missing node of the coarsest level at which one reaches it.
  void expectHolds(const std::vector<bool>& section) {
    if (hats_.empty()) spreadHats();
    std::vector<glm::dvec3> base;
    for (size_t v = 0; v < all_.first_node; ++v) base.push_back(surface_.position(all_.ids[v]));
    const auto drawn = all_.expand(base, [&](size_t v) {
      const auto [a, b] = mesh_.endpoints(all_.ids[v]);
      const glm::dvec3 d = surface_.position(all_.ids[v]) - 0.5 * (surface_.position(a) + surface_.position(b));
      return section[v] ? d : glm::dvec3(0);
    });
    for (size_t v = 0; v < all_.ids.size(); ++v) {
      int coarsest = mesh_.maxLevel() + 1;
      for (size_t n = all_.first_node; n < all_.ids.size(); ++n)
        if (!section[n] && hats_[n - all_.first_node][v] > 0) coarsest = std::min(coarsest, mesh_.level(all_.ids[n]));
      if (coarsest > mesh_.maxLevel()) { EXPECT_LT(glm::length(drawn[v] - surface_.position(all_.ids[v])), 1e-12); }
      for (size_t n = all_.first_node; n < all_.ids.size(); ++n)
        if (!section[n] && hats_[n - all_.first_node][v] > 0 && mesh_.level(all_.ids[n]) == coarsest)
          expectHolds(records_[mesh_.slot(all_.ids[n])], v, drawn[v]);
    }
  }

  void expectNested() const {
    for (size_t n = all_.first_node; n < all_.ids.size(); ++n) {
      const SurfaceRecord& parent = records_[mesh_.slot(all_.ids[n])];
      for (NodeId child : mesh_.children(all_.ids[n])) expectNested(parent, records_[mesh_.slot(child)]);
    }
  }

  std::vector<bool> randomSection(uint64_t one_in, Rng& rng) const {
    std::vector<bool> section(all_.ids.size(), false);
    const auto close = [&](auto& self, NodeId n) -> void {
      if (section[all_.of(n)]) return;
      section[all_.of(n)] = true;
      for (NodeId parent : mesh_.parents(n)) self(self, parent);
    };
    for (size_t n = all_.first_node; n < all_.ids.size(); ++n)
      if (rng.below(one_in) == 0) close(close, all_.ids[n]);
    return section;
  }

 private:
  void spreadHats() {
    for (size_t n = all_.first_node; n < all_.ids.size(); ++n)
      hats_.push_back(
          all_.expand(std::vector<double>(all_.first_node, 0.0), [n](size_t v) { return v == n ? 1.0 : 0.0; }));
  }
  Extent shapeOf(const SurfaceRecord& r) const { return {r.error_along.metres(), r.error_across.metres()}; }
  glm::dvec3 positionOf(const SurfaceRecord& r) const { return glm::dvec3(r.position) * surface_.quantum_m; }

  void expectHolds(const SurfaceRecord& r, size_t v, const glm::dvec3& drawn) const {
    const glm::dvec3 truth = surface_.position(all_.ids[v]), error = drawn - truth, normal = r.normal.unpack();
    const double along = glm::dot(error, normal), slack = 1 + 1e-9;
    if (glm::length(error) > 1e-12) {
      EXPECT_LE(gauge(kind_, shapeOf(r), {std::fabs(along), glm::length(error - along * normal)}), slack);
    }
    EXPECT_LE(glm::length(truth - positionOf(r)), r.radius.metres());
    EXPECT_LE(glm::length(drawn - positionOf(r)), r.radius.metres());
    for (const glm::dvec3& m : normals_[v]) {
      if (!r.cone_sine.isFull()) {
        EXPECT_LE(std::acos(std::min(1.0, glm::dot(m, normal))), std::asin(r.cone_sine.value()));
      }
      EXPECT_LE(std::fabs(glm::dot(m, truth - positionOf(r))), r.bulge.value() * r.radius.metres());
    }
  }

  void expectNested(const SurfaceRecord& parent, const SurfaceRecord& child) const {
    const double apart = glm::length(positionOf(parent) - positionOf(child)), slack = 1 + 1e-9;
    EXPECT_LT(apart + child.radius.metres(), parent.radius.metres());
    const double turned = std::acos(std::clamp(glm::dot(parent.normal.unpack(), child.normal.unpack()), -1.0, 1.0));
    if (!parent.cone_sine.isFull()) {
      EXPECT_LT(std::asin(child.cone_sine.value()) + turned, std::asin(parent.cone_sine.value()));
    }
    // Shapes: as seen from any direction.
    Rng rng(parent.radius.bits);
    for (int i = 0; i < 50; ++i) {
      const glm::dvec3 u = glm::normalize(glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.01, 1)));
      EXPECT_LE(reach(child, u), reach(parent, u) * slack + 1e-15);
    }
  }
  // How far the shape reaches in a direction.
  double reach(const SurfaceRecord& r, const glm::dvec3& u) const {
    const double c = std::fabs(glm::dot(r.normal.unpack(), u)), s = std::sqrt(std::max(0.0, 1 - c * c));
    const Extent e = shapeOf(r);
    return kind_ == ErrorShape::kHoppe ? std::max(e.across, e.along * c) : std::hypot(e.along * c, e.across * s);
  }

  const TrueSurface& surface_;
  const MeshTopology& mesh_;
  ErrorShape kind_;
  std::vector<SurfaceRecord> records_;
  Vertices all_;
  std::vector<std::vector<double>> hats_;         // by node, by vertex
  std::vector<std::vector<glm::dvec3>> normals_;  // of the triangles at each vertex
};

using Case = std::tuple<MeshRule, ErrorShape, ErrorFit>;
class SurfaceBoundsOf : public testing::TestWithParam<Case> {};

TEST_P(SurfaceBoundsOf, EveryNodeHoldsWhatAnySectionWithoutItDraws) {
  const auto& [rule, kind, fit] = GetParam();
  for (const test::NamedSurface& named : test::surfaces(rule, 3)) {
    SCOPED_TRACE(named.name);
    Checker checker(named.surface, kind, computeBounds(named.surface, {.shape = kind, .fit = fit, .threads = 1}));
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      Rng rng(seed);
      checker.expectHolds(checker.randomSection(1 + rng.below(40), rng));
    }
  }
}

TEST_P(SurfaceBoundsOf, ParentsHoldTheirChildren) {
  const auto& [rule, kind, fit] = GetParam();
  for (const test::NamedSurface& named : test::surfaces(rule, 4)) {
    SCOPED_TRACE(named.name);
    Checker(named.surface, kind, computeBounds(named.surface, {.shape = kind, .fit = fit, .threads = 1}))
        .expectNested();
  }
}

// A mix of the poses, exactly: in quanta that are smaller by kShares, by weights that are multiples of 1 / kShares.
constexpr int32_t kShares = 64;
TrueSurface mixed(const TrueSurface& surface, Rng& rng) {
  const auto first = static_cast<int32_t>(rng.below(kShares + 1)),
             second = static_cast<int32_t>(rng.below(kShares + 1 - static_cast<uint64_t>(first)));
  const std::array<int32_t, 3> weights{first, second, kShares - first - second};
  TrueSurface mix = surface;
  mix.quantum_m /= kShares;
  for (size_t v = 0; v < mix.base.size(); ++v)
    mix.base[v] =
        weights[0] * surface.base[v] + weights[1] * surface.poses[0].base[v] + weights[2] * surface.poses[1].base[v];
  for (size_t n = 0; n < mix.nodes.size(); ++n)
    mix.nodes[n] =
        weights[0] * surface.nodes[n] + weights[1] * surface.poses[0].nodes[n] + weights[2] * surface.poses[1].nodes[n];
  mix.poses.clear();
  return mix;
}

TEST_P(SurfaceBoundsOf, HoldInEveryMixOfPoses) {
  const auto& [rule, kind, fit] = GetParam();
  for (test::NamedSurface& named : test::surfaces(rule, 3)) {
    SCOPED_TRACE(named.name);
    test::addPoses(named.surface, 2, 0.4, 0.1, 5);
    auto records = computeBounds(named.surface, {.shape = kind, .fit = fit, .threads = 1});
    for (SurfaceRecord& record : records) record.position *= kShares;
    for (uint64_t seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      Rng rng(seed);
      const TrueSurface mix = mixed(named.surface, rng);
      Checker checker(mix, kind, records);
      checker.expectHolds(checker.randomSection(1 + rng.below(40), rng));
      if (seed == 1) checker.expectNested();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, SurfaceBoundsOf,
                         testing::Combine(testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection),
                                          testing::Values(ErrorShape::kSpheroid, ErrorShape::kHoppe),
                                          testing::Values(ErrorFit::kSmallest, ErrorFit::kByLargest)));

TEST(SurfaceBoundsPass, DoesNotDependOnTheNumberOfThreads) {
  const TrueSurface sphere = *makeSphere(3, {});
  const auto one = computeBounds(sphere, {.threads = 1}), four = computeBounds(sphere, {.threads = 4});
  ASSERT_EQ(one.size(), four.size());
  EXPECT_EQ(std::memcmp(one.data(), four.data(), one.size() * sizeof(SurfaceRecord)), 0);
}

TEST(SurfaceBoundsPass, StopsWhenTold) {
  const TrueSurface sphere = *makeSphere(1, {});
  double last = 0;
  const auto stopped = computeBounds(sphere, {.threads = 1, .onProgress = [&](double done) {
                                                EXPECT_GE(done, last);
                                                last = done;
                                                return done < 0.5;
                                              }});
  EXPECT_TRUE(stopped.empty());
  EXPECT_FALSE(computeBounds(sphere, {.threads = 1}).empty());
}

// On a sphere a node's own displacement is the whole error of the finest level, and radial.
TEST(SurfaceBoundsPass, AreTightWhereTheErrorIsKnown) {
  const TrueSurface sphere = *makeSphere(1, {});
  const auto records = computeBounds(sphere);
  forEachNode(sphere.topology, [&](NodeId n, Slot slot) {
    if (sphere.topology.level(n) < sphere.topology.maxLevel()) return;
    const auto [a, b] = sphere.topology.endpoints(n);
    const double sagitta = 1 - 0.5 * glm::length(sphere.position(a) + sphere.position(b));
    EXPECT_LT(records[slot].error_along.metres(), 1.05 * sagitta);
    EXPECT_LT(records[slot].error_across.metres(), 0.3 * sagitta);
  });
}

}  // namespace
}  // namespace foreland::terrain
