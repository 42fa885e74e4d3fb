// Blending of any order: the laws of P's theorem 1, on random sections of still and of moving ground.
#include "oracle/reference/order_blend.h"

#include <gtest/gtest.h>

#include <set>

#include "base/rng.h"
#include "tests/support/crack_checker.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::oracle {
namespace {

using client::KeyframeMesh;
using proto::NodeId;

TEST(Basis, WeightsAreAPartitionOfUnity) {
  for (const Basis basis : {Basis::kBernstein, Basis::kBSpline})
    for (int order = 1; order <= 4; ++order)
      for (double u = 0; u <= 1; u += 0.125) {
        const auto weights = basisWeights(basis, order, u), slopes = basisSlopes(basis, order, u);
        ASSERT_EQ(weights.size(), static_cast<size_t>(order) + 1);
        double sum = 0;
        constexpr double kStep = 1e-6;
        const auto before = basisWeights(basis, order, u - kStep), after = basisWeights(basis, order, u + kStep);
        for (size_t i = 0; i < weights.size(); ++i) {
          EXPECT_GE(weights[i], 0);
          sum += weights[i];
          EXPECT_NEAR(slopes[i], (after[i] - before[i]) / (2 * kStep), 1e-6);
        }
        EXPECT_NEAR(sum, 1, 1e-14);
        if (order == 1) {
          EXPECT_EQ(weights[0], 1 - u);
          EXPECT_EQ(weights[1], u);
        }
      }
}

// Where one keyframe joins the window and another leaves it, weights and slopes continue; from order 2 on.
TEST(Basis, SplinesContinueFromWindowToWindow) {
  for (int order = 1; order <= 4; ++order) {
    const auto end = basisWeights(Basis::kBSpline, order, 1), begin = basisWeights(Basis::kBSpline, order, 0);
    const auto end_slope = basisSlopes(Basis::kBSpline, order, 1), begin_slope = basisSlopes(Basis::kBSpline, order, 0);
    EXPECT_NEAR(end[0], 0, 1e-15);
    EXPECT_NEAR(begin.back(), 0, 1e-15);
    for (size_t i = 0; i + 1 < end.size(); ++i) {
      EXPECT_NEAR(end[i + 1], begin[i], 1e-15);
      if (order > 1) { EXPECT_NEAR(end_slope[i + 1], begin_slope[i], 1e-15); }
    }
  }
}

// A scene with everything that a blend needs, and a reference evaluation that shares no code with the builder.
class Ground {
 public:
  explicit Ground(std::shared_ptr<const terrain::Scene> scene)
      : scene_(std::move(scene)),
        domain_(scene_->grid(), scene_->frame()),
        offsets_(scene_->grid(), scene_->epochs().epochs(), scene_->epochs().baseOffsets()) {
    const auto& epochs = offsets_.epochs();
    for (uint32_t epoch = 0; epoch < epochs.size(); ++epoch)
      for (proto::Slot slot = 0; slot < grid().slotCount(); ++slot)
        if (const NodeId n = grid().node(slot); n != NodeId{} && epochs.mayMove(epoch, n))
          offsets_.set(epoch, n, scene_->epochs().offset(epoch, slot));
  }
  const proto::GridTopology& grid() const { return domain_.grid; }

  // Closed under parents.
  BlendedKeyframe anyKeyframe(Rng& rng) const {
    std::set<proto::Slot> slots;
    const auto add = [&](const auto& self, NodeId n) -> void {
      if (!slots.insert(grid().slot(n)).second) return;
      for (NodeId parent : grid().parents(n)) self(self, parent);
    };
    for (uint64_t i = 1 + rng.below(60); i > 0; --i) {
      const NodeId v = NodeId::at(static_cast<uint32_t>(rng.below(grid().maxX() + 1)),
                                  static_cast<uint32_t>(rng.below(grid().maxY() + 1)));
      if (!grid().isBase(v)) add(add, v);
    }
    BlendedKeyframe keyframe{{{slots.begin(), slots.end()}}, {}};
    if (const auto& epochs = offsets_.epochs(); !epochs.empty())
      keyframe.scene_time =
          epochs.clamp(rng.uniform(static_cast<double>(epochs.first().us), static_cast<double>(epochs.last().us)));
    return keyframe;
  }

  OrderMesh blend(std::span<const BlendedKeyframe> keyframes) const {
    return blendSections(domain_, {scene_->cornerHeights(), scene_->centreHeights()},
                         [this](proto::Slot s) { return scene_->nodes()[s]; },
                         offsets_.epochs().empty() ? nullptr : &offsets_, keyframes, {10, 20, 30});
  }

  // p_b(v) = (p_b(a) + p_b(b)) / 2 + the sum of b_i d_i(v) over the sections that have v; metres.
  double height(NodeId v, std::span<const BlendedKeyframe> keyframes, std::span<const double> weights) const {
    double sum = 0;
    if (grid().isBase(v)) {
      for (size_t i = 0; i < weights.size(); ++i) sum += weights[i] * heightAt(v, keyframes[i].scene_time);
      return sum;
    }
    const auto [a, b] = grid().endpoints(v);
    for (size_t i = 0; i < weights.size(); ++i) {
      if (!proto::contains(keyframes[i].section, grid().slot(v))) continue;
      const Time t = keyframes[i].scene_time;
      sum += weights[i] * (heightAt(v, t) - 0.5 * (heightAt(a, t) + heightAt(b, t)));
    }
    return 0.5 * (height(a, keyframes, weights) + height(b, keyframes, weights)) + sum;
  }

 private:
  double heightAt(NodeId v, Time t) const {
    double quanta = scene_->height(v);
    const auto& all = scene_->epochs().epochs().all();
    for (uint32_t i = 0; i + 1 < all.size(); ++i) {
      if (t < all[i].time || t > all[i + 1].time) continue;
      const double u = (t - all[i].time).toSeconds() / (all[i + 1].time - all[i].time).toSeconds();
      return (quanta + (1 - u) * scene_->epochs().offset(i, grid(), v) +
              u * scene_->epochs().offset(i + 1, grid(), v)) *
             scene_->frame().height_quantum_m;
    }
    return quanta * scene_->frame().height_quantum_m;
  }

  std::shared_ptr<const terrain::Scene> scene_;
  proto::TerrainDomain domain_;
  proto::EpochOffsets offsets_;
};

std::vector<BlendedKeyframe> anyKeyframes(const Ground& ground, Rng& rng, size_t count) {
  std::vector<BlendedKeyframe> keyframes;
  for (size_t i = 0; i < count; ++i) keyframes.push_back(ground.anyKeyframe(rng));
  return keyframes;
}

TEST(OrderBlend, UnionsOfAnySectionsAreWatertightAndWhereTheFormulaHasThem) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (const size_t epochs : {size_t{0}, size_t{4}}) {
    const Ground ground(epochs == 0 ? test::makeScene(70, 53, rng.next())
                                    : test::makeMovingScene(70, 53, rng.next(), epochs));
    const proto::GridShape& shape = ground.grid().shape();
    for (int trial = 0; trial < 12; ++trial) {
      const auto keyframes = anyKeyframes(ground, rng, 2 + rng.below(4));
      const OrderMesh mesh = ground.blend(keyframes);
      ASSERT_EQ(mesh.positions.size(), keyframes.size());
      std::vector<double> weights;
      double sum = 0;
      for (size_t i = 0; i < keyframes.size(); ++i) sum += weights.emplace_back(rng.uniform(0, 1));
      for (double& w : weights) w /= sum;
      KeyframeMesh blended;
      blended.parameters = mesh.parameters;
      blended.indices = mesh.indices;
      size_t judged = 0;
      for (size_t v = 0; v < mesh.parameters.size(); ++v) {
        const glm::dvec4 at = mesh.at(v, weights);
        blended.from_positions.emplace_back(at);
        const NodeId n =
            NodeId::at(static_cast<uint32_t>(mesh.parameters[v].x), static_cast<uint32_t>(mesh.parameters[v].y));
        if (glm::vec2(n.x(), n.y()) != mesh.parameters[v]) continue;  // cut at the data's border
        if (n.x() >= shape.samples_x || n.y() >= shape.samples_y) continue;
        EXPECT_NEAR(at.w, ground.height(n, keyframes, weights), 2e-3);
        ++judged;
      }
      EXPECT_GT(judged, 8u);
      blended.to_positions = blended.from_positions;
      EXPECT_TRUE(test::hasNoCracks(blended, shape));
    }
  }
}

TEST(OrderBlend, OfEqualKeyframesIsThatKeyframeForAnyOrder) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const Ground ground(test::makeMovingScene(70, 53, rng.next(), 3));
  const BlendedKeyframe one = ground.anyKeyframe(rng);
  const OrderMesh linear = ground.blend(std::vector(2, one));
  for (int order = 1; order <= 4; ++order) {
    const OrderMesh mesh = ground.blend(std::vector(static_cast<size_t>(order) + 1, one));
    ASSERT_EQ(mesh.indices, linear.indices);
    for (const Basis basis : {Basis::kBernstein, Basis::kBSpline})
      for (const double u : {0.0, 0.3, 1.0})
        for (size_t v = 0; v < mesh.parameters.size(); ++v)
          EXPECT_LT(glm::distance(mesh.at(v, basisWeights(basis, order, u)), glm::dvec4(linear.positions[0][v])), 1e-3);
  }
}

TEST(OrderBlend, BackwardsIsTheSameInReverse) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const Ground ground(test::makeMovingScene(70, 53, rng.next(), 3));
  for (int order = 1; order <= 3; ++order) {
    auto keyframes = anyKeyframes(ground, rng, static_cast<size_t>(order) + 1);
    const OrderMesh there = ground.blend(keyframes);
    std::reverse(keyframes.begin(), keyframes.end());
    const OrderMesh back = ground.blend(keyframes);
    ASSERT_EQ(there.indices, back.indices);
    for (const Basis basis : {Basis::kBernstein, Basis::kBSpline}) {
      const double u = rng.uniform(0, 1);
      for (size_t v = 0; v < there.parameters.size(); ++v)
        EXPECT_LT(
            glm::distance(there.at(v, basisWeights(basis, order, u)), back.at(v, basisWeights(basis, order, 1 - u))),
            1e-3);
    }
  }
}

}  // namespace
}  // namespace foreland::oracle
