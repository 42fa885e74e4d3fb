// The occluder lies below the terrain everywhere, is no steeper than it says, and blocks what a ridge blocks.
#include "server/occlusion/occluder.h"

#include <gtest/gtest.h>

#include "tests/support/height_field.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

// The height at which a ray from far above meets the surface.
double heightOf(const Occluder& occluder, glm::dvec3 at) {
  double low = -5000, high = 5000;
  while (high - low > 0.01) {
    const double middle = 0.5 * (low + high);
    (occluder.blocks({at.x, at.y, 6000}, {0, 0, middle - 6000}) ? low : high) = middle;
  }
  return low;
}

class Strides : public testing::TestWithParam<std::tuple<proto::FrameKind, size_t>> {};

TEST_P(Strides, LieBelowTheTerrainAndAreNotSteep) {
  const auto [kind, max_vertices] = GetParam();
  const auto scene = test::makeScene(129, 97, 5, kind);
  const Hierarchy hierarchy(scene);
  const auto occluder = Occluder::create(hierarchy, {.max_vertices = max_vertices});
  ASSERT_TRUE(occluder.ok());
  const test::HeightField field(hierarchy);
  const uint64_t seed = 11;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  double steepest = 0, loss = 0;
  for (int i = 0; i < 1500; ++i) {
    const double x = rng.uniform(2, 120), y = rng.uniform(2, 90), dx = rng.uniform(-2, 2), dy = rng.uniform(-2, 2);
    const auto place = [&](double lx, double ly) {
      return hierarchy.frame().transform().toScene(proto::LatticePosition{lx, ly, field.at(lx, ly)});
    };
    const glm::dvec3 p = place(x, y), q = place(x + dx, y + dy);
    const double at_p = heightOf(**occluder, p), at_q = heightOf(**occluder, q);
    EXPECT_LT(at_p, p.z) << x << " " << y;
    loss += p.z - at_p;
    const double run = glm::distance(glm::dvec2(p), glm::dvec2(q));
    steepest = std::max(steepest, (std::abs(at_p - at_q) - 0.02) / run);
  }
  EXPECT_LE(steepest, (*occluder)->steepness());
  EXPECT_GT(steepest, 0.2);
  EXPECT_LT(loss / 1500, 150);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Strides,
                         testing::Combine(testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic),
                                          testing::Values(size_t{1} << 20, size_t{4000}, size_t{1000})));

// Whatever Embree has no memory for: a buffer, or what makes rays fast.
TEST(Occluder, IsRefusedWithoutTheMemoryForIt) {
  const Hierarchy hierarchy(test::makeScene(129, 97, 5, proto::FrameKind::kPlanar));
  const auto whole = Occluder::create(hierarchy);
  ASSERT_TRUE(whole.ok());
  const size_t bytes = (*whole)->bytes();
  for (const size_t max_bytes : {size_t{0}, size_t{1000}, bytes / 4, bytes / 2}) {
    const auto occluder = Occluder::create(hierarchy, {.max_vertices = 4u << 20, .max_bytes = max_bytes});
    ASSERT_FALSE(occluder.ok()) << max_bytes;
    EXPECT_EQ(occluder.error().code, ErrorCode::kLimit) << occluder.error().message;
    EXPECT_NE(occluder.error().message.find("memory"), std::string::npos);
  }
  EXPECT_TRUE(Occluder::create(hierarchy, {.max_vertices = 4u << 20, .max_bytes = 4 * bytes}).ok());
}

TEST(Occluder, IsRefusedForAPlanet) {
  test::FormulaSource source(65, 65, [](uint32_t, uint32_t) { return 100.0; });
  source.info().frame.axis_x_m = {100e3, 0};
  source.info().frame.axis_y_m = {0, 100e3};
  const auto scene = test::makeScene(source);
  const auto occluder = Occluder::create(Hierarchy(scene));
  ASSERT_FALSE(occluder.ok());
  EXPECT_NE(occluder.error().message.find("400 km"), std::string::npos);
}

}  // namespace
}  // namespace foreland::server
