// The height look-up of a replica that a server feeds: equal to the surface that is drawn, everywhere.
#include "client/replica.h"

#include <gtest/gtest.h>

#include "tests/support/lattice_surface.h"
#include "tests/support/scene.h"
#include "tests/world/world.h"

namespace foreland::test {
namespace {

using client::Replica;

TEST(HeightAt, IsTheDrawnSurfaceAtEverySampleAndLinearBetween) {
  const auto scene = makeScene(201, 151, 41);
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(onKnownTour(*scene, "canyon", 30));
  world.run(Time::seconds(4));
  ASSERT_EQ(world.report(), "");
  const Replica& replica = *world.viewer(0).replica();
  ASSERT_GT(replica.section().slots.size(), 500u);
  const LatticeSurface drawn(replica.buildMesh(), 1, scene->grid().shape());
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
