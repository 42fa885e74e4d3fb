// A mesh's curve is the uniform B-spline's part over one interval.
#include "client/mesh/weights/spline.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "oracle/reference/order_blend.h"
#include "tests/support/seed.h"

namespace foreland::client {
namespace {

TEST(Spline, ByEndsAndControlsIsTheSplineOfTheKeyframes) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 100; ++trial)
    for (uint32_t order = 1; order <= proto::kMaxOrder; ++order) {
      std::vector<double> values;  // of the keyframes, the newest first
      for (uint32_t i = 0; i <= order; ++i) values.push_back(rng.uniform(-3, 3));
      const double from = splineEnd(order, [&](uint32_t i) { return values[i + 1]; }),
                   to = splineEnd(order, [&](uint32_t i) { return values[i]; });
      const auto [a, b] = splineControls(order, from, to, [&](uint32_t i) { return values[i]; });
      for (double u : {0.0, 0.25, 0.7, 1.0}) {
        const double v = 1 - u;
        double expected = 0;
        const std::vector<double> weights = oracle::basisWeights(oracle::Basis::kBSpline, static_cast<int>(order), u);
        for (uint32_t i = 0; i <= order; ++i) expected += weights[i] * values[order - i];
        EXPECT_NEAR(v * v * v * from + 3 * u * v * v * a + 3 * u * u * v * b + u * u * u * to, expected, 1e-12);
      }
    }
}

TEST(Spline, OfEqualValuesIsThatValueExactly) {
  for (uint32_t order = 1; order <= proto::kMaxOrder; ++order)
    for (double value : {0.0, 1.0}) {
      const auto at = [&](uint32_t) { return value; };
      EXPECT_EQ(splineEnd(order, at), value);
      EXPECT_EQ(splineControls(order, value, value, at), (std::array{value, value}));
    }
}

}  // namespace
}  // namespace foreland::client
