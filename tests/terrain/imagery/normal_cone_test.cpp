#include "terrain/imagery/normal_cone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <vector>

#include "base/rng.h"
#include "terrain/imagery/ground_bounds.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

glm::dvec3 randomUnit(Rng& rng) {
  for (;;) {
    const glm::dvec3 v(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (const double length = glm::length(v); length > 0.1 && length <= 1) return v / length;
  }
}

TEST(NormalCone, HoldsTheNormalsThatItIsMadeOf) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 middle = randomUnit(rng);
    const double spread = rng.uniform(0, 1.2);
    std::vector<glm::dvec3> normals;
    for (int k = 0; k < 20; ++k) normals.push_back(glm::normalize(middle + spread * randomUnit(rng) * 0.8));
    const auto axis = quantisedAxis(middle);
    double least = 1;
    for (const glm::dvec3& n : normals) least = std::min(least, glm::dot(n, NormalCone{axis, 0}.unitAxis()));
    const NormalCone cone = coneOf(axis, least);
    for (const glm::dvec3& n : normals) EXPECT_TRUE(cone.holds(n));
    EXPECT_FALSE(!cone.isEverything() && cone.half_angle > 3 && cone.holds(-middle));
  }
}

TEST(NormalCone, AUnionHoldsItsPartsAndWhatTheyHold) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 middle = randomUnit(rng);
    std::vector<NormalCone> parts;
    for (uint64_t k = 0; k < 1 + rng.below(4); ++k)
      parts.push_back({quantisedAxis(middle + 0.3 * randomUnit(rng)), static_cast<uint8_t>(rng.below(120))});
    const NormalCone all = unionOf(parts);
    for (const NormalCone& part : parts) {
      EXPECT_TRUE(all.holds(part));
      const glm::dvec3 n = glm::normalize(part.unitAxis() + 0.3 * randomUnit(rng));
      EXPECT_TRUE(!part.holds(n) || all.holds(n));
    }
  }
}

TEST(NormalCone, OppositeNormalsNeedEveryDirection) {
  const NormalCone up{{0, 0, 127}, 1}, down{{0, 0, -127}, 1};
  EXPECT_TRUE(unionOf(std::vector{up, down}).isEverything());
  EXPECT_TRUE(coneOf({0, 0, 127}, -0.1).isEverything());
  EXPECT_FALSE(up.holds(NormalCone::everything()));
}

// Heights and normals between the samples, by a bilinear surface, wherever they are looked up.
TEST(GroundBounds, HoldTheGroundBetweenTheSamples) {
  Rng rng(test::randomSeed());
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    constexpr uint32_t kWidth = 40, kHeight = 31;
    std::vector<int32_t> quanta;
    for (uint32_t i = 0; i < kWidth * kHeight; ++i) quanta.push_back(static_cast<int32_t>(rng.below(2000)));
    const Heights heights{quanta, kWidth, kHeight};
    const proto::Frame frame = test::makeFrame(kind, kWidth, kHeight);
    const proto::FrameTransform transform(frame);
    const GroundBounds ground(HeightsByWindow::of(heights), frame);
    const glm::dvec2 low(rng.uniform(-0.5, 20), rng.uniform(-0.5, 15)), high = low + glm::dvec2(12.3, 9.1);
    std::vector<glm::dvec3> scratch;
    const proto::TileBounds bounds = ground.over({low, high}, scratch).value();
    const auto cone = NormalCone::of(bounds);
    const auto at = [&](double x, double y) {
      const double cx = std::clamp(x, 0.0, kWidth - 1.0), cy = std::clamp(y, 0.0, kHeight - 1.0);
      const auto x0 = std::min(static_cast<uint32_t>(cx), kWidth - 2),
                 y0 = std::min(static_cast<uint32_t>(cy), kHeight - 2);
      const double u = cx - x0, v = cy - y0;
      const double south = heights.row(y0)[x0] * (1 - u) + heights.row(y0)[x0 + 1] * u,
                   north = heights.row(y0 + 1)[x0] * (1 - u) + heights.row(y0 + 1)[x0 + 1] * u;
      return (south * (1 - v) + north * v) * frame.height_quantum_m;
    };
    for (int i = 0; i < 2000; ++i) {
      const double x = rng.uniform(std::max(low.x, 0.0), high.x), y = rng.uniform(std::max(low.y, 0.0), high.y);
      const double d = 1e-3;
      EXPECT_LE(bounds.lowest_m, at(x, y));
      EXPECT_GE(bounds.highest_m, at(x, y));
      const auto point = [&](double px, double py) {
        return transform.toScene(proto::LatticePosition{px, py, at(px, py)});
      };
      // Within one cell, so that the difference is the surface's own slope.
      if (std::floor(x) != std::floor(x + d) || std::floor(y) != std::floor(y + d)) continue;
      const glm::dvec3 n = glm::normalize(glm::cross(point(x + d, y) - point(x, y), point(x, y + d) - point(x, y)));
      EXPECT_TRUE(cone.holds(n)) << x << ' ' << y;
    }
  }
}

// However many samples are held at a time, bounds are the same, to the bit; no more are read at once than that.
TEST(GroundBounds, DoNotDependOnHowManySamplesAreHeld) {
  Rng rng(test::randomSeed());
  constexpr uint32_t kWidth = 61, kHeight = 47;
  std::vector<int32_t> quanta;
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) quanta.push_back(static_cast<int32_t>(rng.below(300)));
  const HeightsByWindow all = HeightsByWindow::of({quanta, kWidth, kHeight});
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const proto::Frame frame = test::makeFrame(kind, kWidth, kHeight);
    for (int i = 0; i < 40; ++i) {
      const glm::dvec2 low(rng.uniform(-0.5, kWidth), rng.uniform(-0.5, kHeight)),
          high = low + glm::dvec2(rng.uniform(0, kWidth), rng.uniform(0, kHeight));
      std::vector<glm::dvec3> scratch;
      const proto::TileBounds whole = GroundBounds(all, frame).over({low, high}, scratch).value();
      for (const uint32_t most : {1u, 150u, 700u}) {
        const auto read = [&](const SampleWindow& w, std::span<int32_t> out) {
          EXPECT_TRUE(w.height <= 2 || w.width * w.height <= most) << w.width << " x " << w.height;
          return all.read(w, out);
        };
        const auto strips = GroundBounds({kWidth, kHeight, read}, frame, most).over({low, high}, scratch).value();
        EXPECT_TRUE(strips == whole) << most << " samples at once";
      }
    }
  }
  const auto failing = [](const SampleWindow&, std::span<int32_t>) { return Status(Error{ErrorCode::kIo, "gone"}); };
  std::vector<glm::dvec3> scratch;
  EXPECT_EQ(GroundBounds({kWidth, kHeight, failing}, {}).over({{0, 0}, {9, 9}}, scratch).error().message, "gone");
}

}  // namespace
}  // namespace foreland::terrain
