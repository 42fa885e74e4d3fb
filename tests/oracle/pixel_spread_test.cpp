#include "oracle/pixel_spread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "base/quantile.h"
#include "base/rng.h"

namespace foreland::oracle {
namespace {

TEST(PixelSpread, GivesQuantilesThatAreTooLargeByA4096thAtMost) {
  Rng rng(5);
  PixelSpread spread;
  std::vector<double> all;
  for (int i = 0; i < 5000; ++i) {
    all.push_back(std::exp(rng.uniform(-12, 5)));
    spread.add(all.back());
  }
  for (const double q : {0.0, 0.25, 0.5, 0.99, 0.999, 1.0}) {
    const double exact = quantile(all, q);
    EXPECT_GE(spread.quantile(q), exact * (1 - 1e-7)) << q;  // of a float
    EXPECT_LE(spread.quantile(q), exact * (1 + 1.0 / 4096)) << q;
  }
}

TEST(PixelSpread, HasNothingToSayOfNothing) {
  EXPECT_EQ(PixelSpread().quantile(0.99), 0);
  PixelSpread still;
  for (int i = 0; i < 10; ++i) still.add(0);
  EXPECT_EQ(still.quantile(1), 0);
}

TEST(PixelSpread, SurvivesWhatIsNoNumber) {
  PixelSpread spread;
  for (const double sign : {1.0, -1.0}) spread.add(std::copysign(std::numeric_limits<double>::quiet_NaN(), sign));
  spread.add(1);
  EXPECT_NEAR(spread.quantile(0), 1, 1.0 / 4096);
}

}  // namespace
}  // namespace foreland::oracle
