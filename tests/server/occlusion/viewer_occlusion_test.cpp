// Along a flight, whatever a viewer's server calls hidden at a keyframe is hidden from the keyframe's whole region,
// however long ago it was found out; and most of it is not found out anew.
#include "server/occlusion/viewer_occlusion.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/server/occlusion/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"

namespace foreland::server {
namespace {

using proto::BlockId;

constexpr uint32_t kSide = BlockId::kSide;

Time at(int keyframe) { return Time::seconds(1) + Duration::milliseconds(200) * keyframe; }

TEST(ViewerOcclusion, CallsHiddenWhatIsHiddenFromTheWholeRegion) {
  const uint64_t seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const auto scene = test::makeScene(257, 257, 7);
  const Hierarchy hierarchy(scene);
  const auto shared = SceneOcclusion::create(hierarchy).value();
  ViewerOcclusion viewer(hierarchy, *shared);
  const test::HeightField field(hierarchy);
  std::map<std::pair<uint32_t, uint32_t>, bool> blocks;
  uint64_t hidden = 0, first_rays = 0;
  proto::Path path{at(-1), at(1) - at(0), {}};
  const auto poseAt = [&](int keyframe) {
    const double x = 40 + 0.4 * keyframe, y = 128 + 10 * std::sin(0.05 * keyframe);
    return test::viewAt(hierarchy, x, y, field.at(x, y) + 60, 0, 0);
  };
  for (int keyframe = -1; keyframe <= 61; ++keyframe) path.poses.push_back(poseAt(keyframe).pose);
  for (int keyframe = 0; keyframe < 60; ++keyframe) {
    proto::View view = poseAt(keyframe);
    const double x = 40 + 0.4 * keyframe, y = 128 + 10 * std::sin(0.05 * keyframe);
    view.tau_px = 1;
    view.region_radius_m = 5;
    viewer.expect(
        ViewerOcclusion::sweepsAhead(ExpectedMotion(path), at(keyframe - 1), at(keyframe + 1), at(1) - at(0), 0.01));
    viewer.begin(view);
    for (uint32_t j = 0; j < 256 / kSide; ++j)
      for (uint32_t i = 0; i < 256 / kSide; ++i) {
        const BlockId block{0, i, j};
        const auto known = blocks.find({i, j});
        const bool is_hidden =
            known == blocks.end() ? viewer.isHidden(block) : viewer.isStillHidden(block, known->second);
        blocks[{i, j}] = is_hidden;
        if (!is_hidden || kSide * i < x + 30 || std::abs(kSide * (j + 0.5) - y) > 0.3 * (kSide * i - x)) continue;
        ++hidden;
        const double sx = kSide * (i + rng.uniform()), sy = kSide * (j + rng.uniform());
        const glm::dvec3 point =
            hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, field.at(sx, sy)});
        const auto share = Duration{static_cast<int64_t>(rng.below(400'000))};
        const glm::dvec3 eye = path.at(at(keyframe - 1) + share).eye;
        EXPECT_FALSE(field.isClear(eye, point, 0.5)) << "keyframe " << keyframe << " block " << i << " " << j;
      }
    if (keyframe == 0) first_rays = viewer.statistics().rays;
  }
  EXPECT_GT(hidden, 400u);
  EXPECT_LT((viewer.statistics().rays - first_rays) / 59, first_rays / 3);
}

}  // namespace
}  // namespace foreland::server
