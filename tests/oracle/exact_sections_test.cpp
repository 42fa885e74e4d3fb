#include "apps/exact_sections.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "client/replica.h"
#include "oracle/reference/whole_mesh.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "tests/support/same_mesh.h"
#include "tests/support/scene.h"

namespace foreland::apps {
namespace {

// What a viewer holds after its first keyframe.
client::KeyframeMesh sentFor(const server::Hierarchy& hierarchy, const oracle::SectionRequest& wanted) {
  server::SectionSender sender(hierarchy);
  server::SendScratch scratch;
  Bytes message;
  sender.send({wanted.pose, wanted.lens, wanted.tau_px, wanted.region_radius_m, wanted.region_angle_rad}, Time{},
              scratch, message);
  client::Replica replica(server::welcomeTo(hierarchy));
  EXPECT_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes())).ok());
  return oracle::wholeMesh(replica);
}

TEST(ExactSections, AreToTheBitWhatANewViewerIsSent) {
  for (const proto::FrameKind kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const auto scene = test::makeScene(180, 150, 3, kind);
    const server::Hierarchy hierarchy(scene);
    const oracle::SectionAt section_at = exactSections(scene);
    Rng rng(4);
    for (int i = 0; i < 8; ++i) {
      const glm::dvec3 eye = hierarchy.frame().position(
          proto::NodeId::at(static_cast<uint32_t>(rng.uniform(0, 179)), static_cast<uint32_t>(rng.uniform(0, 149))),
          rng.uniform(8000, 40000));
      const glm::dvec3 forward(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 0));
      const oracle::SectionRequest wanted{.pose = {eye, proto::lookAlong(forward, {0, 0, 1})},
                                          .lens = {.width_px = 640, .height_px = 360},
                                          .tau_px = rng.uniform(0.5, 3),
                                          .region_radius_m = i % 2 * rng.uniform(0, 30),
                                          .region_angle_rad = i % 2 * rng.uniform(0, 0.1)};
      const auto mesh = section_at(wanted);
      const client::KeyframeMesh sent = sentFor(hierarchy, wanted);
      EXPECT_TRUE(test::isSameMesh(*mesh, sent)) << "seed 4, " << i;
      EXPECT_EQ(mesh->parameters, sent.parameters);
      EXPECT_EQ(mesh->indices, sent.indices);
      EXPECT_EQ(mesh->origin, sent.origin);
      EXPECT_GT(mesh->triangleCount(), 100u);
    }
  }
}

}  // namespace
}  // namespace foreland::apps
