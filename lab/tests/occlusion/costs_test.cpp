#include "lab/occlusion/costs.h"

#include <gtest/gtest.h>

#include "lab/tests/occlusion/ridge.h"

namespace foreland::lab {
namespace {

TEST(OcclusionCosts, AreLessBehindARidge) {
  const server::Hierarchy hierarchy(test::ridgeScene());
  const auto shared = server::SceneOcclusion::create(hierarchy).value();
  const FlightOptions options = test::ridgeOptions(4);
  const proto::Path path = test::ridgeFlight(hierarchy, options.seconds);
  const OcclusionCosts costs = measureOcclusionCosts(
      hierarchy, *shared, predictedFlight(path, options, proto::Predictor::kKnownPath), options.keyframe_interval);
  EXPECT_EQ(costs.keyframes, 21u);
  EXPECT_GT(costs.nodes.without, 1.5 * costs.nodes.with);
  EXPECT_GT(costs.first_nodes.without, 1.5 * costs.first_nodes.with);
  EXPECT_GT(costs.first_bytes.without, 1.2 * costs.first_bytes.with);
  EXPECT_GT(costs.flight_bytes_saving, 1.2);
  EXPECT_GT(costs.first_tests, 0u);
  EXPECT_GT(costs.first_segments, 0u);
  EXPECT_GT(costs.first_hidden_bits, 0);
  EXPECT_GT(costs.first_ray_ms, 0);
  EXPECT_LT(costs.ray_share, 1);
  for (const BothWays& figure : {costs.nodes, costs.bytes, costs.keyframe_ms, costs.first_keyframe_ms, costs.decode_ms,
                                 costs.first_decode_ms, costs.mesh_ms, costs.first_mesh_ms}) {
    EXPECT_GT(figure.without, 0);
    EXPECT_GT(figure.with, 0);
  }
}

}  // namespace
}  // namespace foreland::lab
