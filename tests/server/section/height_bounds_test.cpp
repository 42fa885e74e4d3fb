#include "server/section/height_bounds.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "oracle/epoch_shares.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr uint32_t kWidth = 61, kHeight = 47;

std::vector<Time> datesOf(const Hierarchy& hierarchy) {
  std::vector<Time> dates;
  for (const proto::Epoch& epoch : hierarchy.epochs().epochs().all()) dates.push_back(epoch.time);
  return dates;
}

double heightAt(const Hierarchy& hierarchy, std::span<const double> shares, proto::NodeId v) {
  double quanta = hierarchy.table().height(v);
  for (uint32_t epoch = 0; epoch < shares.size(); ++epoch)
    quanta += shares[epoch] * hierarchy.epochs().offset(epoch, hierarchy.grid(), v);
  return quanta;
}

std::string nameOf(proto::EpochBlend blend) {
  constexpr std::array kNames{"Linear", "CatmullRom", "BSpline"};
  return kNames[static_cast<size_t>(blend)];
}

class Bounds : public testing::TestWithParam<proto::EpochBlend> {};

// Everywhere and always, beyond the data as well; no wider than the epochs by more than a quarter of what these span.
TEST_P(Bounds, HoldTheGroundAtAllTimes) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const Hierarchy hierarchy(
      test::makeMovingScene(kWidth, kHeight, seed, 2 + rng.below(5), proto::FrameKind::kPlanar, GetParam()));
  const HeightBounds bounds(hierarchy);
  const std::vector<Time> dates = datesOf(hierarchy);
  std::vector<std::vector<double>> times, epochs;
  for (int i = 0; i < 40; ++i)
    times.push_back(oracle::epochShares(
        dates, GetParam(), Time{static_cast<int64_t>(rng.uniform(0, static_cast<double>(dates.back().us)))}));
  for (const Time date : dates) epochs.push_back(oracle::epochShares(dates, proto::EpochBlend::kLinear, date));
  uint64_t moving = 0, outside = 0, loose = 0;
  for (uint32_t y = 0; y <= hierarchy.grid().maxY(); ++y)
    for (uint32_t x = 0; x <= hierarchy.grid().maxX(); ++x) {
      const proto::NodeId v = proto::NodeId::at(x, y);
      const double lowest = bounds.lowest(v), highest = bounds.highest(v);
      double least = heightAt(hierarchy, epochs[0], v), most = least;
      for (const auto& shares : epochs) {
        least = std::min(least, heightAt(hierarchy, shares, v));
        most = std::max(most, heightAt(hierarchy, shares, v));
      }
      for (const auto& shares : times) {
        const double height = heightAt(hierarchy, shares, v);
        outside += height < lowest - 1e-6 || height > highest + 1e-6 ? 1 : 0;
      }
      const double more = (GetParam() == proto::EpochBlend::kCatmullRom ? 0.5 * (most - least) : 0) + 1;
      loose += lowest < least - more || highest > most + more ? 1 : 0;
      moving += highest > lowest ? 1 : 0;
    }
  EXPECT_EQ(outside, 0u);
  EXPECT_EQ(loose, 0u);
  EXPECT_GT(moving, 0u);
}

INSTANTIATE_TEST_SUITE_P(Blends, Bounds,
                         testing::Values(proto::EpochBlend::kLinear, proto::EpochBlend::kCatmullRom,
                                         proto::EpochBlend::kBSpline),
                         [](const auto& instance) { return nameOf(instance.param); });

TEST(HeightBounds, AreTheHeightsWhereNothingMoves) {
  const Hierarchy hierarchy(test::makeScene(kWidth, kHeight, 3));
  const HeightBounds bounds(hierarchy);
  for (uint32_t y = 0; y <= hierarchy.grid().maxY(); ++y)
    for (uint32_t x = 0; x <= hierarchy.grid().maxX(); ++x) {
      const proto::NodeId v = proto::NodeId::at(x, y);
      ASSERT_EQ(bounds.lowest(v), hierarchy.table().height(v));
      ASSERT_EQ(bounds.highest(v), hierarchy.table().height(v));
    }
}

}  // namespace
}  // namespace foreland::server
