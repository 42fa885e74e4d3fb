// The judgement on a scene with a ridge: it finds nothing wrong with what the server leaves out, and much with a
// visibility that is rigged to hide everything.
#include "lab/occlusion/judge.h"

#include <gtest/gtest.h>

#include "lab/occlusion/predicted_views.h"
#include "lab/tests/occlusion/ridge.h"
#include "server/occlusion/viewer_occlusion.h"
#include "tests/support/block_by_block.h"

namespace foreland::lab {
namespace {

class HidesEverything final : public foreland::test::BlockByBlock {
 public:
  void begin(const proto::View&) override {}
  bool isHidden(const proto::BlockId&) override { return true; }
  bool isStillHidden(const proto::BlockId&, bool) override { return true; }
};

class OcclusionJudge : public testing::Test {
 protected:
  OcclusionJudgement judge(proto::BlockVisibility& visibility) {
    const FlightOptions options = test::ridgeOptions(2);
    const auto views = keyframeViews(path_, options, Guarantee::kEveryFrame);
    return judgeOcclusion(hierarchy_, {visibility}, views, path_, options, {.keyframes = 2}).value();
  }

  server::Hierarchy hierarchy_{test::ridgeScene()};
  proto::Path path_ = test::ridgeFlight(hierarchy_, 2);
};

TEST_F(OcclusionJudge, FindsNothingWrongWithTheServer) {
  const auto shared = server::SceneOcclusion::create(hierarchy_).value();
  server::ViewerOcclusion visibility(hierarchy_, *shared);
  const PredictedFlight flight = predictedFlight(path_, test::ridgeOptions(2), proto::Predictor::kKnownPath);
  Foresight foresight(visibility, flight);
  const OcclusionJudgement found = judge(foresight);
  EXPECT_EQ(found.judged_keyframes, 3u);
  EXPECT_EQ(found.judged_frames, 2u);
  EXPECT_EQ(found.keyframes.pixels, 3u * 320 * 180);
  EXPECT_EQ(found.keyframes.visible_over_tau, 0u);
  EXPECT_EQ(found.frames.visible_over_tau, 0u);
  EXPECT_EQ(found.keyframes.drawn_over_tau_hidden + found.frames.drawn_over_tau_hidden, 0u);
  EXPECT_GT(found.keyframes.max_px, 0);
  EXPECT_EQ(found.late_reveals, 0u);
  EXPECT_GT(found.possible.all, 1.5 * found.nodes_with);
  EXPECT_GE(found.nodes_with, found.possible.supports);
}

TEST_F(OcclusionJudge, FindsWhatIsWronglyHidden) {
  HidesEverything visibility;
  const OcclusionJudgement found = judge(visibility);
  EXPECT_GT(found.keyframes.visible_over_tau_hidden, 100u);
  EXPECT_GT(found.frames.visible_over_tau_hidden, 100u);
  EXPECT_GT(found.keyframes.drawn_over_tau_hidden, 100u);
  EXPECT_EQ(found.keyframes.visible_over_tau_without, 0u);
  EXPECT_GT(found.late_reveals, 100u);
  EXPECT_GT(found.keyframes.max_px, 1);
}

// What it hides is what the ridge does; but the ridge's own coarse blocks are never asked for.
class HidesBehindTheRidge final : public foreland::test::BlockByBlock {
 public:
  explicit HidesBehindTheRidge(uint32_t first_x) : first_x_(first_x) {}
  void begin(const proto::View&) override {}
  bool isHidden(const proto::BlockId& b) override { return b.x * (proto::BlockId::kSide << b.scale) >= first_x_; }
  bool isStillHidden(const proto::BlockId& b, bool) override { return isHidden(b); }

 private:
  uint32_t first_x_;
};

TEST_F(OcclusionJudge, AllowsWhatIsTrulyHidden) {
  HidesBehindTheRidge behind(128), before(64);
  EXPECT_EQ(judge(behind).late_reveals, 0u);
  EXPECT_GT(judge(before).late_reveals, 0u);
}

}  // namespace
}  // namespace foreland::lab
