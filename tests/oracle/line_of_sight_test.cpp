// Lines of sight against Embree on the full-resolution mesh, which shares nothing with them but the triangles.
#include "oracle/line_of_sight.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "oracle/scene_truth.h"
#include "terrain/render/ray_caster.h"
#include "tests/support/scene.h"

namespace foreland::oracle {
namespace {

constexpr double kFloats_m = 0.05;  // more than Embree's floats err here

class LineOfSightFrames : public testing::TestWithParam<proto::FrameKind> {
 protected:
  static constexpr uint64_t kSeed = 17;

  glm::dvec3 at(double x, double y, double above_m) const {
    const proto::FrameTransform transform(scene_->frame());
    const glm::dvec3 ground = terrain_.pointAt({x, y});
    return ground + above_m * transform.upAt(ground);
  }
  bool castsClear(const glm::dvec3& target, const glm::dvec3& eye) const {
    const double length = glm::distance(target, eye);
    return !caster_.hit({eye, (target - eye) / length, length - 1e-3}).has_value();
  }

  std::shared_ptr<const terrain::Scene> scene_ = test::makeScene(150, 97, test::hills(kSeed), GetParam());
  terrain::RayCaster caster_ = terrain::RayCaster::ofScene(scene_).value();
  LineOfSight terrain_{truthOf(scene_)};
};

// Where Embree itself says one thing a little higher and another a little lower, either is right.
TEST_P(LineOfSightFrames, AgreesWithEmbree) {
  Rng rng(kSeed);
  int clear = 0, blocked = 0, doubtful = 0;
  for (int i = 0; i < 20000; ++i) {
    const double above_m = rng.uniform(1, 200), height_m = rng.uniform(1, 400);
    const double x = rng.uniform(0.01, 148.9), y = rng.uniform(0.01, 95.9), eye_x = rng.uniform(0.01, 148.9),
                 eye_y = rng.uniform(0.01, 95.9);
    const glm::dvec3 eye = at(eye_x, eye_y, height_m), target = at(x, y, above_m);
    const bool lower = castsClear(at(x, y, above_m - kFloats_m), eye),
               higher = castsClear(at(x, y, above_m + kFloats_m), eye);
    doubtful += lower != higher ? 1 : 0;
    if (lower != higher) continue;
    (lower ? clear : blocked) += 1;
    ASSERT_EQ(terrain_.isClear(target, eye), lower) << "seed " << kSeed << " line " << i;
  }
  EXPECT_GT(clear, 2000);
  EXPECT_GT(blocked, 2000);
  EXPECT_LT(doubtful, 200);
}

TEST_P(LineOfSightFrames, SeesVerticesThatEmbreeSees) {
  Rng rng(kSeed + 1);
  int clear = 0, blocked = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto x = static_cast<double>(rng.below(149)), y = static_cast<double>(rng.below(96));
    const glm::dvec3 eye = at(rng.uniform(1, 148), rng.uniform(1, 95), rng.uniform(20, 600));
    const bool is_clear = terrain_.isClear(at(x, y, 0), eye);
    (is_clear ? clear : blocked) += 1;
    ASSERT_TRUE(!is_clear || castsClear(at(x, y, 2 * kFloats_m), eye)) << i;
    ASSERT_TRUE(!castsClear(at(x, y, kFloats_m), eye) || terrain_.isClear(at(x, y, 3 * kFloats_m), eye)) << i;
  }
  EXPECT_GT(clear, 500);
  EXPECT_GT(blocked, 2000);
}

TEST_P(LineOfSightFrames, PutsPointsOnTheTriangles) {
  Rng rng(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const double x = rng.uniform(0.01, 148.9), y = rng.uniform(0.01, 95.9);
    const glm::dvec3 eye = at(x, y, 500);
    const auto hit = caster_.hit({eye, -proto::FrameTransform(scene_->frame()).upAt(eye)});
    ASSERT_TRUE(hit.has_value());
    EXPECT_LT(glm::distance(terrain_.pointAt(hit->parameter), hit->position), 2e-3) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Both, LineOfSightFrames,
                         testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

// One sample of 50 m on a plain: lines beside it pass, lines at it do not, along rows, columns and diagonals.
TEST(LineOfSight, IsBlockedByASingleSample) {
  const auto scene = test::makeScene(33, 33, [](uint32_t x, uint32_t y) { return x == 16 && y == 16 ? 50.0 : 0.0; });
  const LineOfSight terrain(truthOf(scene));
  const proto::FrameTransform transform(scene->frame());
  const auto at = [&](double x, double y, double z) { return transform.toScene(proto::LatticePosition{x, y, z}); };
  for (const glm::dvec2& step : {glm::dvec2(1, 0), {0, 1}, {1, 1}, {1, -1}, {1, 0.3}}) {
    const glm::dvec2 a = glm::dvec2(16) - 10.0 * step, b = glm::dvec2(16) + 10.0 * step;
    EXPECT_FALSE(terrain.isClear(at(a.x, a.y, 49), at(b.x, b.y, 49)));
    EXPECT_TRUE(terrain.isClear(at(a.x, a.y, 51), at(b.x, b.y, 51)));
    const glm::dvec2 aside(-2 * step.y, 2 * step.x);
    EXPECT_TRUE(terrain.isClear(at(a.x + aside.x, a.y + aside.y, 1), at(b.x + aside.x, b.y + aside.y, 1)));
  }
}

}  // namespace
}  // namespace foreland::oracle
