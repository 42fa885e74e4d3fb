// Prices of a server's work: fitted, written and read.
#include "sim/compute_cost.h"

#include <gtest/gtest.h>

#include <fstream>

#include "base/rng.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace foreland::sim {
namespace {

TEST(ComputePrices, AreFoundAgainInTheTimesThatTheyMake) {
  Rng rng(test::randomSeed());
  const ComputePrices truth{"truth", 40'000, 15, 6, 180, 30, 8, 50, 900, 5000, 0, 700};
  std::vector<TimedWork> steps;
  for (int i = 0; i < 2000; ++i) {
    const StepWork work{1,
                        rng.below(20'000),
                        rng.below(60'000),
                        rng.below(9000),
                        rng.below(4) == 0 ? rng.below(90'000) : 0,
                        rng.below(9000),
                        0,
                        rng.below(2) == 0 ? rng.below(2000) : 0,
                        rng.below(60),
                        0,
                        rng.below(3000)};
    const double noise = rng.uniform(0.98, 1.02);
    steps.push_back({work, noise * truth.of(work).toSeconds()});
  }
  const ComputePrices found = fitPrices(steps);
  EXPECT_NEAR(found.keyframe, truth.keyframe, 0.1 * truth.keyframe);
  EXPECT_NEAR(found.tested, truth.tested, 0.1 * truth.tested);
  EXPECT_NEAR(found.changed, truth.changed, 0.1 * truth.changed);
  EXPECT_NEAR(found.measured, truth.measured, 0.1 * truth.measured);
  EXPECT_NEAR(found.block, truth.block, 0.1 * truth.block);
  EXPECT_NEAR(found.segment, truth.segment, 0.2 * truth.segment);
  EXPECT_EQ(found.ray, 0);
  EXPECT_NEAR(found.query, truth.query, 0.2 * truth.query);
  EXPECT_NEAR(found.swept, truth.swept, 0.2 * truth.swept);
}

TEST(ComputePrices, AreNeverNegative) {
  // More tests, less time: the best price without a bound would be negative.
  std::vector<TimedWork> steps;
  for (uint64_t i = 1; i < 50; ++i) steps.push_back({{1, 100 * i, 0, 0, 0}, 1e-3 / static_cast<double>(i)});
  fitPrices(steps).fields([](const char* name, double price) { EXPECT_GE(price, 0) << name; });
}

TEST(ComputePrices, AreReadAsTheyWereWritten) {
  const test::TemporaryFolder folder;
  const ComputePrices prices{"x", 1.5, 2.25, 3, 0, 1e-3, 7, 11, 13.5, 17, 19, 23};
  std::ofstream(folder / "c.json") << prices.toJson();
  const auto read = readPrices(folder / "c.json");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->toJson(), prices.toJson());
  EXPECT_EQ(read->name, "c.json");
}

TEST(ComputePrices, RefusesFilesThatAreNoCalibration) {
  const test::TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    std::ofstream(folder / "c.json") << text;
    const auto read = readPrices(folder / "c.json");
    return read.ok() ? std::string() : read.error().message;
  };
  EXPECT_NE(refusal("nonsense").find("foreland bench calibrate"), std::string::npos);
  EXPECT_NE(refusal("[]").find("foreland bench calibrate"), std::string::npos);
  EXPECT_NE(refusal(R"({"ns_keyframe": 1})").find("'ns_tested'"), std::string::npos);
  EXPECT_NE(refusal(R"({"ns_keyframe": -1})").find("'ns_keyframe'"), std::string::npos);
  EXPECT_FALSE(readPrices(folder / "none.json").ok());
}

}  // namespace
}  // namespace foreland::sim
