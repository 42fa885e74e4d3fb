// A block that is called hidden cannot be seen: neither its true surface nor anything that may be drawn of it, from any
// eye of the capsule, by marching along lines of sight.
#include "server/occlusion/block_test.h"

#include <gtest/gtest.h>

#include <array>

#include "oracle/epoch_shares.h"
#include "tests/support/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"

namespace foreland::server {
namespace {

using proto::BlockId;

glm::dvec3 inBall(Rng& rng) {
  for (;;) {
    const glm::dvec3 p(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (glm::length(p) <= 1) return p;
  }
}

enum class Behind { kRays, kHorizons };

struct Ways {
  proto::FrameKind frame;
  Behind behind;
};

// A scene, and all that a test of its blocks needs.
struct Ground {
  Ground(std::shared_ptr<const terrain::Scene> scene, Behind behind) : hierarchy(std::move(scene)) {
    if (behind == Behind::kHorizons) shared.grid = HorizonGrid::of(hierarchy);
    if (behind == Behind::kRays) shared.occluder = Occluder::create(hierarchy).value();
  }
  bool isHidden(const BlockId& block, const proto::View& view, const EyeCapsule& eyes, uint64_t max_rays = 1000) {
    const Tolerance tolerance{view.lens, view.tau_px};
    if (!shared.grid) return test.isHidden(block, tolerance, eyes, max_rays);
    Horizon horizon(*shared.grid);
    horizon.look(eyes, 3 / view.lens.focalPx());
    return test.isBehind(block, tolerance, horizon);
  }

  const Hierarchy hierarchy;
  SceneOcclusion shared{BlockTops(hierarchy), nullptr, nullptr};
  BlockTest test{hierarchy, shared};
  const foreland::test::HeightField field{hierarchy};
};

class Hidden : public testing::TestWithParam<Ways> {};

TEST_P(Hidden, BlocksCannotBeSeenFromAnywhereInTheSweep) {
  const uint64_t seed = 23;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const auto scene = test::makeScene(257, 257, 7, GetParam().frame);
  Ground ground(scene, GetParam().behind);
  int hidden = 0, tried = 0;
  for (int view_count = 0; view_count < 40; ++view_count) {
    const double x = rng.uniform(20, 236), y = rng.uniform(20, 236);
    proto::View view =
        test::viewAt(ground.hierarchy, x, y, ground.field.at(x, y) + rng.uniform(5, 120), rng.uniform(0, 6.28), 0);
    view.tau_px = 1;
    const EyeCapsule eyes{view.pose.eye, rng.below(4) == 0 ? glm::dvec3(0) : rng.uniform(0, 60) * inBall(rng),
                          rng.uniform(0, 30)};
    for (int i = 0; i < 60; ++i) {
      const auto scale = static_cast<uint8_t>(rng.below(4));
      const uint32_t side = BlockId::kSide << scale;
      const BlockId block{scale, static_cast<uint32_t>(rng.below(256 / side)),
                          static_cast<uint32_t>(rng.below(256 / side))};
      ++tried;
      if (!ground.isHidden(block, view, eyes)) continue;
      ++hidden;
      for (int sample = 0; sample < 20; ++sample) {
        const double sx = block.x * side + rng.uniform(0, side), sy = block.y * side + rng.uniform(0, side);
        const double top = ground.field.at(std::min(sx, 256.0), std::min(sy, 256.0));
        const glm::dvec3 point = ground.hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, top}),
                         eye = eyes.eye + rng.uniform() * eyes.way + eyes.radius_m * inBall(rng);
        EXPECT_FALSE(ground.field.isClear(eye, point, 0.5))
            << "block " << int(scale) << " " << block.x << " " << block.y << " at " << sx << " " << sy;
      }
    }
  }
  EXPECT_GT(hidden, tried / 10);
}

// At the height where a block behind a ridge is only just hidden, eyes at the ends of the capsule and on top of its
// ball do not see it.
void lookFromTheMostTellingEyes(Ground& ground) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  int critical = 0, nearly_seen = 0;
  for (int round = 0; round < 60; ++round) {
    const double x = rng.uniform(20, 70), y = rng.uniform(60, 196);
    const auto scale = static_cast<uint8_t>(rng.below(3));
    const uint32_t side = BlockId::kSide << scale;
    const BlockId block{scale, static_cast<uint32_t>((160 + rng.below(60)) / side),
                        static_cast<uint32_t>((y + rng.uniform(-50, 50)) / side)};
    proto::View view = test::viewAt(ground.hierarchy, x, y, 0, 0, 0);
    EyeCapsule eyes{view.pose.eye, rng.uniform(0, 400) * inBall(rng), rng.below(2) * rng.uniform(0, 30)};
    const glm::dvec3 level = eyes.eye;
    const auto isHiddenAt = [&](double height) {
      eyes.eye = level + glm::dvec3(0, 0, height);
      return ground.isHidden(block, view, eyes);
    };
    double low = -1000, high = 3000;
    if (!isHiddenAt(low) || isHiddenAt(high)) continue;
    while (high - low > 0.1) (isHiddenAt(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    ++critical;
    isHiddenAt(low);
    bool seen_from_above = false;
    for (int sample = 0; sample < 40; ++sample) {
      const double sx = side * (block.x + rng.uniform()), sy = side * (block.y + rng.uniform());
      const glm::dvec3 point =
          ground.hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, ground.field.at(sx, sy)});
      const glm::dvec3 out = rng.below(2) ? glm::dvec3(0, 0, 1) : glm::normalize(inBall(rng));
      const glm::dvec3 eye = eyes.eye + static_cast<double>(rng.below(2)) * eyes.way + eyes.radius_m * out;
      EXPECT_FALSE(ground.field.isClear(eye, point, 0.3)) << int(scale) << " " << block.x << " " << block.y;
      seen_from_above |= ground.field.isClear(
          eye + glm::dvec3(0, 0, 40 + 2 * eyes.radius_m + 1.5 * glm::length(eyes.way)), point, 0.3);
    }
    nearly_seen += seen_from_above ? 1 : 0;
  }
  EXPECT_GT(critical, 15);
  EXPECT_GT(nearly_seen, critical / 3);
}

double ridge(uint32_t x, uint32_t y) { return std::max(0.0, 90 - 4 * std::abs(x - 131.0) + 12 * std::sin(0.21 * y)); }

TEST_P(Hidden, BlocksCannotBeSeenFromTheMostTellingEyes) {
  Ground ground(test::makeScene(257, 257, ridge, GetParam().frame), GetParam().behind);
  lookFromTheMostTellingEyes(ground);
}

// The way to these blocks rises, so to fly back from the ridge shows more of them.
TEST_P(Hidden, BlocksOnTheSlopeBehindCannotBeSeenEither) {
  const auto rising = [](uint32_t x, uint32_t y) { return std::max(ridge(x, y), 2.5 * (x - 150.0)); };
  Ground ground(test::makeScene(257, 257, rising, GetParam().frame), GetParam().behind);
  lookFromTheMostTellingEyes(ground);
}

// A ridge that sinks and goes to and fro between two plains, of which the farther one rises.
std::shared_ptr<const terrain::Scene> movingRidge(proto::FrameKind kind, proto::EpochBlend blend) {
  constexpr std::array<double, 5> kSunk{0, 10, 25, 25, 5}, kAlong{0, 4, 2, -4, 0}, kRisen{0, 0, 45, 10, 60};
  const auto ground = [=](size_t epoch) {
    return [=](uint32_t x, uint32_t y) {
      const double ridge = 110 - kSunk[epoch] - 4 * std::abs(x - 131.0 - kAlong[epoch]) + 12 * std::sin(0.21 * y);
      return std::max({0.0, ridge, std::min(kRisen[epoch], x - 150.0)});
    };
  };
  test::FormulaSource base(257, 257, ground(0), kind);
  std::vector<test::FormulaSource> sources;
  std::vector<terrain::EpochRequest> epochs;
  for (size_t i = 0; i < kSunk.size(); ++i) sources.push_back(test::windowSource(base, {90, 0, 160, 257}, ground(i)));
  for (size_t i = 0; i < sources.size(); ++i)
    epochs.push_back({Time::seconds(static_cast<double>(100 * i + 60 * (i % 2))), std::to_string(i), &sources[i]});
  return test::makeScene(base, 0.1, 1, std::move(epochs), blend);
}

TEST_P(Hidden, BlocksOfMovingGroundCannotBeSeenAtAnyTime) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (const auto blend : {proto::EpochBlend::kLinear, proto::EpochBlend::kCatmullRom, proto::EpochBlend::kBSpline}) {
    Ground ground(movingRidge(GetParam().frame, blend), GetParam().behind);
    const proto::Epochs& epochs = ground.hierarchy.epochs().epochs();
    std::vector<Time> dates;
    for (const proto::Epoch& epoch : epochs.all()) dates.push_back(epoch.time);
    int hidden = 0;
    for (int i = 0; i < 2000 && hidden < 16; ++i) {
      const double x = rng.uniform(20, 70), y = rng.uniform(60, 196);
      const BlockId block{0, static_cast<uint32_t>(36 + rng.below(20)), static_cast<uint32_t>(rng.below(64))};
      const proto::View view = test::viewAt(ground.hierarchy, x, y, rng.uniform(30, 110), 0, 0);
      if (!ground.isHidden(block, view, EyeCapsule{view.pose.eye})) continue;
      ++hidden;
      for (int sample = 0; sample < 12; ++sample) {
        const Time at{static_cast<int64_t>(rng.uniform(0, static_cast<double>(epochs.last().us)))};
        const foreland::test::HeightField field(ground.hierarchy, oracle::epochShares(dates, blend, at));
        const double sx = BlockId::kSide * (block.x + rng.uniform()), sy = BlockId::kSide * (block.y + rng.uniform());
        const glm::dvec3 point =
            ground.hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, field.at(sx, sy)});
        EXPECT_FALSE(field.isClear(view.pose.eye, point, 0.3))
            << proto::name(blend) << " block " << block.x << " " << block.y << " at " << at.us;
      }
    }
    EXPECT_EQ(hidden, 16) << proto::name(blend);
  }
}

// A ridge between two plains: what lies behind it is hidden as far as geometry says.
TEST_P(Hidden, BehindARidgeAndNotBeforeIt) {
  const auto scene = test::makeScene(
      257, 257, [](uint32_t x, uint32_t) { return std::max(0.0, 100 - 5 * std::abs(static_cast<double>(x) - 131)); },
      GetParam().frame);
  Ground ground(scene, GetParam().behind);
  const proto::View view = test::viewAt(ground.hierarchy, 64, 128, 50, 0, 0);
  EXPECT_TRUE(ground.isHidden({0, 40, 32}, view, EyeCapsule{view.pose.eye}));
  EXPECT_TRUE(ground.isHidden({1, 24, 16}, view, EyeCapsule{view.pose.eye, {}, 10}));
  EXPECT_FALSE(ground.isHidden({0, 24, 32}, view, EyeCapsule{view.pose.eye}));
  EXPECT_FALSE(ground.isHidden({0, 32, 32}, view, EyeCapsule{view.pose.eye})) << "the ridge itself";
  const proto::View above = test::viewAt(ground.hierarchy, 64, 128, 500, 0, 0);
  EXPECT_FALSE(ground.isHidden({0, 40, 32}, above, EyeCapsule{above.pose.eye}));
  const bool needs_rays = GetParam().behind == Behind::kRays;
  EXPECT_EQ(ground.isHidden({0, 40, 32}, view, EyeCapsule{view.pose.eye}, 0), !needs_rays)
      << "nothing known without rays";
}

// From every side, a wall about the eye hides what is behind it, and a gap in it shows it.
TEST_P(Hidden, BehindAWallOnAllSides) {
  const auto wall = [](uint32_t x, uint32_t y) {
    const double distance = std::max(std::abs(x - 128.0), std::abs(y - 128.0));
    return std::max(0.0, 150 - 6 * std::abs(distance - 42));
  };
  const auto gap = [&](uint32_t x, uint32_t y) { return std::abs(x - 128.0) < 10 ? 0 : wall(x, y); };
  Ground closed(test::makeScene(257, 257, wall, GetParam().frame), GetParam().behind),
      open(test::makeScene(257, 257, gap, GetParam().frame), GetParam().behind);
  const proto::View view = test::viewAt(closed.hierarchy, 128, 128, 30, 0, 0);
  const EyeCapsule eyes{view.pose.eye, {15, 10, 2}, 1};
  for (const auto& [x, y] : {std::pair{2u, 2u}, {2u, 32u}, {32u, 2u}, {32u, 60u}, {60u, 32u}, {60u, 60u}, {10u, 50u}})
    EXPECT_TRUE(closed.isHidden({0, x, y}, view, eyes)) << x << " " << y;
  EXPECT_TRUE(open.isHidden({0, 2, 32}, view, eyes));
  EXPECT_FALSE(open.isHidden({0, 32, 60}, view, eyes)) << "behind the gap";
  EXPECT_FALSE(open.isHidden({0, 32, 2}, view, eyes)) << "behind the other gap";
}

INSTANTIATE_TEST_SUITE_P(Ways, Hidden,
                         testing::Values(Ways{proto::FrameKind::kPlanar, Behind::kHorizons},
                                         Ways{proto::FrameKind::kPlanar, Behind::kRays},
                                         Ways{proto::FrameKind::kGeographic, Behind::kHorizons},
                                         Ways{proto::FrameKind::kGeographic, Behind::kRays}));

TEST(Tops, BoundTheHeightsOfTheirSquares) {
  const auto scene = test::makeScene(65, 49, 3);
  const Hierarchy hierarchy(scene);
  const BlockTops tops(hierarchy);
  for (uint32_t scale = 0; scale < hierarchy.grid().shape().root_log2; ++scale) {
    const uint32_t side = 2u << scale;
    for (uint32_t j = 0; j < tops.rows(scale); ++j)
      for (uint32_t i = 0; i < tops.columns(scale); ++i) {
        const BlockTops::Square& square = tops.square(scale, i, j);
        int32_t highest = scene->height(proto::NodeId::at(i * side, j * side)), lowest = highest;
        double least = 1e9;  // of the plane over the terrain
        for (uint32_t y = 0; y <= side; ++y)
          for (uint32_t x = 0; x <= side; ++x) {
            const int32_t height = scene->height(proto::NodeId::at(i * side + x, j * side + y));
            highest = std::max(highest, height);
            lowest = std::min(lowest, height);
            least = std::min(least, square.height + square.tilt_x * (2.0 * x / side - 1) +
                                        square.tilt_y * (2.0 * y / side - 1) - height);
          }
        ASSERT_EQ(square.top, highest) << scale << " " << i << " " << j;
        ASSERT_EQ(square.bottom, lowest) << scale << " " << i << " " << j;
        ASSERT_NEAR(least, 0, 0.01 + 1e-6 * std::abs(highest)) << scale << " " << i << " " << j;
      }
  }
}

}  // namespace
}  // namespace foreland::server
