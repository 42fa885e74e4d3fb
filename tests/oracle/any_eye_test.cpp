// The guarantee holds for eyes anywhere that look anywhere: below the ground, far above it, beside it.
#include <gtest/gtest.h>

#include "apps/exact_sections.h"
#include "base/rng.h"
#include "client/fly/exaggeration.h"
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

// A truth whose heights are so many times as tall.
oracle::Truth tall(oracle::Truth truth, double factor) {
  truth.frame.height_quantum_m *= factor;
  return truth;
}

client::KeyframeMesh tall(client::KeyframeMesh mesh, double factor) {
  mesh.origin.z *= factor;
  for (auto* positions : {&mesh.from_positions, &mesh.to_positions})
    for (glm::vec4& p : *positions) p.z *= static_cast<float>(factor);
  return mesh;
}

TEST(AnyEye, SeesAStretchedSceneAsItWouldSeeOneThatIsTaller) {
  Rng rng(test::randomSeed());
  const auto scene = test::makeScene(180, 150, 3, proto::FrameKind::kPlanar);
  const oracle::SectionAt section_at = exactSections(scene);
  for (const double factor : {0.5, 3.0}) {
    oracle::Oracle stretched(oracle::truthOf(scene)), of_tall(tall(oracle::truthOf(scene), factor));
    stretched.setStretch({factor});
    uint64_t samples = 0;
    for (int i = 0; i < 30; ++i) {
      const glm::dvec3 forward(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 0.2));
      proto::Pose pose{{rng.uniform(-2000, 2000), rng.uniform(-2000, 2000), rng.uniform(0, 5000)},
                       proto::lookAlong(forward, {0, 0, 1})};
      const proto::Lens lens{.width_px = 640, .height_px = 360};
      const auto mesh = section_at({.pose = pose, .lens = lens, .tau_px = 3});
      const client::KeyframeMesh tall_mesh = tall(*mesh, factor);
      const oracle::DrawnShare drawn{.mesh = mesh.get()}, drawn_tall{.mesh = &tall_mesh};
      const oracle::Deviation found = stretched.error({&drawn, 1}, pose, lens);
      pose.eye.z *= factor;
      const oracle::Deviation plain = of_tall.error({&drawn_tall, 1}, pose, lens);
      EXPECT_NEAR(found.max_px, plain.max_px, 1e-3 + 1e-3 * plain.max_px) << i;
      EXPECT_NEAR(static_cast<double>(found.samples), static_cast<double>(plain.samples), 2) << i;
      samples += found.samples;
    }
    EXPECT_GT(samples, 10'000u);
  }
}

TEST(AnyEye, SeesNoMoreThanTheToleranceWhereHeightsAreTaller) {
  Rng rng(test::randomSeed());
  const proto::Lens lens{.width_px = 640, .height_px = 360};
  for (const double factor : {0.5, 3.0}) {
    const auto scene = test::makeScene(180, 150, 3, proto::FrameKind::kGeographic);
    const server::Hierarchy hierarchy(scene);
    const oracle::SectionAt section_at = exactSections(scene);
    const client::Exaggeration heights = client::Exaggeration::of(factor, lens);
    oracle::Oracle oracle(oracle::truthOf(scene));
    oracle.setStretch({factor});
    double worst = 0;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 eye = hierarchy.frame().position(
          proto::NodeId::at(static_cast<uint32_t>(rng.uniform(0, 179)), static_cast<uint32_t>(rng.uniform(0, 149))),
          rng.uniform(-30000, 40000));
      const glm::dvec3 forward(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const proto::Pose drawn_pose{eye, proto::lookAlong(forward, {0, 0, 1})};
      const auto mesh =
          section_at({.pose = heights.askedPose(drawn_pose), .lens = heights.asked, .tau_px = 1 / heights.finer});
      const oracle::DrawnShare drawn{.mesh = mesh.get()};
      const oracle::Deviation found = oracle.error({&drawn, 1}, drawn_pose, lens);
      EXPECT_LE(found.max_px, 1 + 1e-3) << i;
      worst = std::max(worst, found.max_px);
    }
    EXPECT_GT(worst, 0.08) << "a bound that is never approached is not tested";  // it is one for all directions
  }
}

}  // namespace
}  // namespace foreland::apps
