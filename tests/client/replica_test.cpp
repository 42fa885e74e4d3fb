// A replica that a server feeds: the first mesh is whole at both ends, and the height look-up equals the surface that
// is drawn, everywhere.
#include "client/replica.h"

#include <gtest/gtest.h>

#include "oracle/reference/whole_mesh.h"
#include "server/section/sender.h"
#include "server/session/world.h"
#include "sim/world.h"
#include "tests/support/lattice_surface.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using sim::onKnownTour;
using sim::World;

using client::Replica;

// The base mesh is never shown in place of the section, not even for the moment that a late mesh takes: both ends are
// the keyframe's, as `from` claims. The same after a restart, when the server sends a keyframe that starts from
// nothing.
TEST(FirstMesh, ShowsTheKeyframesSectionsAtBothEnds) {
  const auto scene = makeScene(150, 110, 41);
  const server::Hierarchy hierarchy(scene, proto::ErrorBound::kSpheroid, objectsIn(*scene, 6));
  server::SendScratch scratch;
  for (client::Blend blend : {client::Blend::kKeyframe, client::Blend::kGeomorph}) {
    Replica replica(server::welcomeTo(hierarchy));
    for (int start = 0; start < 2; ++start) {
      server::SectionSender sender(hierarchy);
      for (int i = 0; i < 3; ++i) {
        Bytes message;
        sender.send(viewAt(hierarchy, 75 + i, 55, 1200, 0.3, -1), Time::seconds(1 + i), scratch, message);
        ASSERT_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes()), blend).ok());
        if (i > 0) continue;
        const client::KeyframeMesh mesh = oracle::wholeMesh(replica);
        EXPECT_EQ(mesh.from.index, mesh.to.index);
        EXPECT_GT(mesh.from_nodes, 100u);
        EXPECT_EQ(mesh.from_positions, mesh.to_positions);
        EXPECT_EQ(mesh.from_normals, mesh.to_normals);
        EXPECT_GT(mesh.objects.triangleCount(), 1000u);
        EXPECT_EQ(mesh.objects.from_positions, mesh.objects.to_positions);
        EXPECT_EQ(mesh.objects.from_normals, mesh.objects.to_normals);
      }
    }
  }
}

// Cut short anywhere, a keyframe that starts from nothing changes nothing that is drawn, but what it was sent over has
// to begin anew.
TEST(Restart, LeavesWhatIsDrawnWhereItsKeyframeIsMalformed) {
  const auto scene = makeScene(150, 110, 41);
  const server::Hierarchy hierarchy(scene, proto::ErrorBound::kSpheroid, objectsIn(*scene, 6));
  server::SendScratch scratch;
  Replica replica(server::welcomeTo(hierarchy));
  server::SectionSender sender(hierarchy);
  Bytes message;
  for (int i = 0; i < 3; ++i) {
    message.clear();
    sender.send(viewAt(hierarchy, 75 + i, 55, 1200, 0.3, -1), Time::seconds(1 + i), scratch, message);
    ASSERT_TRUE(replica.apply(sender.keyframe(), ByteSpan(message).subspan(sender.headerBytes())).ok());
  }
  const client::KeyframeMesh before = oracle::wholeMesh(replica);
  server::SectionSender anew(hierarchy);
  message.clear();
  anew.send(viewAt(hierarchy, 20, 30, 900, 0.3, -1), Time::seconds(9), scratch, message);
  const ByteSpan delta = ByteSpan(message).subspan(anew.headerBytes());
  for (size_t kept : {size_t{0}, delta.size() / 3, delta.size() - 1}) {
    ASSERT_FALSE(replica.apply(anew.keyframe(), delta.first(kept)).ok()) << kept;
    const client::KeyframeMesh after = oracle::wholeMesh(replica);
    EXPECT_EQ(after.to.index, before.to.index);
    EXPECT_EQ(after.from_positions, before.from_positions);
    EXPECT_EQ(after.to_positions, before.to_positions);
    EXPECT_EQ(after.indices, before.indices);
    EXPECT_EQ(after.objects.to_positions, before.objects.to_positions);
    EXPECT_EQ(replica.makeResume(server::welcomeTo(hierarchy)), std::nullopt);
  }
  ASSERT_TRUE(replica.apply(anew.keyframe(), delta).ok());
  EXPECT_EQ(replica.newest().index, anew.keyframe().index);
}

TEST(HeightAt, IsTheDrawnSurfaceAtEverySampleAndLinearBetween) {
  const auto scene = makeScene(201, 151, 41);
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(onKnownTour(*scene, "canyon", 30));
  world.run(Time::seconds(4));
  ASSERT_EQ(world.report(), "");
  const Replica& replica = *world.viewer(0).replica();
  ASSERT_GT(replica.section().slots.size(), 500u);
  const LatticeSurface drawn(oracle::wholeMesh(replica), 1, scene->grid().shape());
  constexpr double kRounding_m = 2e-3;  // positions of meshes are floats, kilometres from their origin
  for (uint32_t y = 0; y < 151; ++y)
    for (uint32_t x = 0; x < 201; ++x) {
      const auto height = replica.heightAt(x, y);
      ASSERT_TRUE(height) << x << ' ' << y;
      ASSERT_NEAR(*height, drawn.at(x, y).z, kRounding_m) << x << ' ' << y;
    }
  // Every triangle has its corners on samples and its edges along axes or diagonals, so an edge of a lattice square
  // that runs along an axis lies in one triangle or on its border.
  for (uint32_t y = 0; y < 151; ++y)
    for (uint32_t x = 0; x < 200; ++x)
      ASSERT_NEAR(*replica.heightAt(x + 0.25, y), 0.75 * drawn.at(x, y).z + 0.25 * drawn.at(x + 1, y).z, kRounding_m);
}

TEST(HeightAt, IsNothingOutsideTheDataAndBeforeTheFirstKeyframe) {
  const auto scene = makeScene(201, 151, 41);
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(onKnownTour(*scene, "canyon", 30));
  world.run(Time::seconds(2));
  const Replica& replica = *world.viewer(0).replica();
  EXPECT_TRUE(replica.heightAt(0, 0));
  EXPECT_TRUE(replica.heightAt(200, 150));
  for (const auto& [x, y] : {std::pair(-0.01, 5.0), {5.0, -0.01}, {200.01, 5.0}, {5.0, 150.01}, {std::nan(""), 5.0}})
    EXPECT_FALSE(replica.heightAt(x, y)) << x << ' ' << y;
  EXPECT_FALSE(Replica(*world.viewer(0).welcome()).heightAt(5, 5));
}

}  // namespace
}  // namespace foreland::test
