// The guarantee holds for eyes anywhere that look anywhere: below the ground, far above it, beside it.
#include <gtest/gtest.h>

#include "apps/exact_sections.h"
#include "base/rng.h"
#include "oracle/oracle.h"
#include "oracle/scene_truth.h"
#include "server/section/hierarchy.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::apps {
namespace {

TEST(AnyEye, SeesNoMoreThanTheTolerance) {
  Rng rng(test::randomSeed());
  for (const proto::FrameKind kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const auto scene = test::makeScene(180, 150, 3, kind);
    const server::Hierarchy hierarchy(scene);
    const oracle::SectionAt section_at = exactSections(scene);
    oracle::Oracle oracle(oracle::truthOf(scene));
    int below = 0;
    double worst = 0;
    for (int i = 0; i < 200; ++i) {
      const glm::dvec3 eye = hierarchy.frame().position(
          proto::NodeId::at(static_cast<uint32_t>(rng.uniform(0, 179)), static_cast<uint32_t>(rng.uniform(0, 149))),
          rng.uniform(-30000, 40000));
      const glm::dvec3 forward(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const oracle::SectionRequest wanted{.pose = {eye, proto::lookAlong(forward, {0, 0, 1})},
                                          .lens = {.width_px = 640, .height_px = 360},
                                          .tau_px = rng.uniform(0.5, 4)};
      const auto mesh = section_at(wanted);
      const oracle::DrawnShare drawn{.mesh = mesh.get()};
      const oracle::Deviation found = oracle.error({&drawn, 1}, wanted.pose, wanted.lens);
      EXPECT_LE(found.max_px, wanted.tau_px + 1e-3) << i;
      below += found.samples > 0 && eye.z < 0;
      worst = std::max(worst, found.max_px / wanted.tau_px);
    }
    EXPECT_GT(below, 5);
    EXPECT_GT(worst, 0.5) << "a bound that is never approached is not tested";
  }
}

}  // namespace
}  // namespace foreland::apps
