// What rivals pull of the whole earth: everything in view, wherever they are, and nothing behind the horizon.
#include "lab/drape/tile_puller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "base/rng.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

constexpr double kDegree = 0.017453292519943295;

std::shared_ptr<const terrain::Scene> wholeEarth() {
  test::FormulaSource source(
      721, 360, [](uint32_t x, uint32_t y) { return 4000 * std::sin(x / 9.0) * std::cos(y / 7.0); },
      proto::FrameKind::kGeographic);
  proto::Frame& frame = source.info().frame;
  frame.longitude_step_rad = frame.latitude_step_rad = 0.5 * kDegree;
  frame.longitude0_rad = 20 * kDegree, frame.latitude0_rad = -89.75 * kDegree;
  frame.origin = {0, 200 * kDegree, 0};
  return test::makeScene(source);
}

proto::Pose somePose(Rng& rng, const proto::FrameTransform& frame) {
  const double altitude_m = std::exp(rng.uniform(std::log(1e5), std::log(2e7)));
  proto::Pose pose;
  pose.eye =
      frame.toScene(proto::Geodetic{rng.uniform(-80, 80) * kDegree, rng.uniform(25, 375) * kDegree, altitude_m + 4000});
  // From straight down to the horizon.
  const glm::dvec3 up = frame.upAt(pose.eye), side = glm::normalize(glm::cross(up, glm::dvec3(0.1, 0.2, 0.97)));
  const double dip = std::acos(6.37e6 / (6.37e6 + altitude_m)), pitch = rng.uniform(dip, 1.5);
  pose.orientation = proto::lookAlong(side * std::cos(pitch) - up * std::sin(pitch), up);
  return pose;
}

TEST(TilePuller, DrawsAllThatIsInViewOfTheWholeEarthAndNoMore) {
  const auto scene = wholeEarth();
  const proto::Lens lens{1.0471975511965976, 480, 360};
  Rng rng(test::randomSeed());
  const auto pulled = [&](const proto::Pose& pose) {
    TilePuller puller(scene, 0, lens, {.rule = TileRule::kDistance, .texel_px = 0.01});
    for (Time now; now < Time::seconds(3); now = now + Duration::milliseconds(100)) puller.frame(now, pose);
    return puller.drawn();
  };
  std::vector<proto::Pose> poses;
  for (int i = 0; i < 10; ++i) poses.push_back(somePose(rng, proto::FrameTransform(scene->frame())));
  auto judge = DrapeJudge::create(scene, lens, poses, 1);
  ASSERT_TRUE(judge.ok()) << judge.error().message;
  LayerImage image(scene, 0);
  const proto::TileLayer& layer = image.layer();
  ASSERT_EQ(layer.levels(), 3u);
  size_t tiles = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    const sim::DrawnTiles drawn = pulled(poses[i]);
    tiles += drawn.size();
    judge->judge(i, image, drawn, std::numeric_limits<double>::infinity());
    const DrapeQuality quality = judge->take();
    EXPECT_LE(quality.not_drawn, 40u) << i;  // of 442,368 samples: at the limb a cell is culled by its corners
    // From far away the judge, as a graphics card, takes no finer tiles than have four texels across a pixel's part.
    EXPECT_LE(quality.texel_px_max, 0.25) << "finer tiles that were not asked for, in view " << i;
  }
  EXPECT_LT(tiles, poses.size() * 3 / 4 * (1 + 4 + 6)) << "what lies behind the earth";
}

}  // namespace
}  // namespace foreland::lab
