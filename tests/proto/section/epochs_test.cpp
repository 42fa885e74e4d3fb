#include "proto/section/epochs.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "proto/section/epoch_offsets.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

constexpr GridShape kShape{2, 1, 4, 30, 17};

Epochs anyEpochs(Rng& rng, size_t count) {
  std::vector<Epoch> epochs;
  int64_t t = static_cast<int64_t>(rng.below(1000)) - 500;
  for (size_t i = 0; i < count; ++i) {
    t += 1 + static_cast<int64_t>(rng.below(1000));
    epochs.push_back({Time{t}, i == 0 ? LatticeWindow{} : LatticeWindow{2, 3, 20, 14}});
  }
  return Epochs::create(kShape, epochs).value();
}

// A quantity that is linear between epochs: by brute force.
double valueAt(const Epochs& epochs, std::span<const double> values, Time t) {
  if (t <= epochs.first()) return values.front();
  for (size_t i = 1; i < epochs.size(); ++i)
    if (t <= epochs[i].time)
      return values[i - 1] + (values[i] - values[i - 1]) * static_cast<double>(t.us - epochs[i - 1].time.us) /
                                 static_cast<double>(epochs[i].time.us - epochs[i - 1].time.us);
  return values.back();
}

TEST(Epochs, BlendLinearly) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 50; ++trial) {
    const Epochs epochs = anyEpochs(rng, 1 + rng.below(6));
    std::vector<double> values;
    for (size_t i = 0; i < epochs.size(); ++i) values.push_back(rng.uniform(-1, 1));
    for (int64_t us = epochs.first().us - 3; us <= epochs.last().us + 3; ++us) {
      const EpochWeights w = epochs.weightsAt(Time{us});
      double sum = 0, value = 0;
      for (uint32_t i = 0; i < w.count; ++i) {
        EXPECT_GT(w.weight[i], 0);
        sum += w.weight[i];
        value += w.weight[i] * values[w.epoch[i]];
      }
      EXPECT_NEAR(sum, 1, 1e-15);
      EXPECT_NEAR(value, valueAt(epochs, values, Time{us}), 1e-12);
    }
  }
}

// Steps towards a time come to it, and pass no epoch without stopping at it.
TEST(Epochs, AreNotPassedByASingleStep) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 200; ++trial) {
    const Epochs epochs = anyEpochs(rng, 2 + rng.below(6));
    const auto any = [&] {
      return Time{epochs.first().us +
                  static_cast<int64_t>(rng.below(static_cast<uint64_t>(epochs.last().us - epochs.first().us + 1)))};
    };
    Time at = any();
    const Time wanted = any();
    for (size_t steps = 0; at != wanted; ++steps) {
      ASSERT_LE(steps, epochs.size());
      const Time next = epochs.towards(at, wanted);
      EXPECT_NE(next, at);
      for (const Epoch& epoch : epochs.all())
        EXPECT_FALSE(std::min(at, next) < epoch.time && epoch.time < std::max(at, next));
      at = next;
    }
  }
}

TEST(Epochs, AreCheckedOneByOne) {
  const auto message = [](std::vector<Epoch> epochs) {
    const auto made = Epochs::create(kShape, std::move(epochs));
    return made ? std::string() : made.error().message;
  };
  EXPECT_EQ(message({}), "");
  EXPECT_EQ(message({{Time{1}, {}}, {Time{2}, {0, 0, 30, 17}}}), "");
  EXPECT_EQ(message({{Time{1}, {}}, {Time{1}, {}}}), "epoch 2 is not later than the one before it");
  EXPECT_EQ(message({{Time{1}, {}}, {Time{2}, {1, 0, 30, 17}}}), "epoch 2 reaches beyond the data");
  EXPECT_EQ(message({{Time{1}, {}}, {Time{2}, {0xffffffff, 0, 2, 1}}}), "epoch 2 reaches beyond the data");
  EXPECT_EQ(message({{Time{1}, {0, 0, 1, 1}}}), "epoch 1 differs from itself");
  EXPECT_EQ(message({{Time{INT64_MAX}, {}}}), "epoch 1 has an absurd date");
  EXPECT_NE(message(std::vector<Epoch>(2000)), "");
}

TEST(Epochs, HullsHoldBothWindows) {
  const LatticeWindow a{3, 4, 5, 6}, b{1, 8, 2, 9}, both = LatticeWindow::hull(a, b);
  EXPECT_EQ(both, (LatticeWindow{1, 4, 7, 13}));
  EXPECT_EQ(LatticeWindow::hull(a, {}), a);
  EXPECT_EQ(LatticeWindow::hull({}, b), b);
}

TEST(SceneClock, StandsUntilItsTimeAndStaysWithinTheEpochs) {
  const Epochs epochs = Epochs::create(kShape, {{Time{1000}, {}}, {Time{9000}, {}}}).value();
  const SceneClock clock{Time{50}, Time{2000}, 3};
  EXPECT_EQ(clock.timeAt(epochs, Time{-100}), Time{2000});
  EXPECT_EQ(clock.timeAt(epochs, Time{50}), Time{2000});
  EXPECT_EQ(clock.timeAt(epochs, Time{150}), Time{2300});
  EXPECT_EQ(clock.timeAt(epochs, Time{1'000'000}), Time{9000});
  EXPECT_EQ((SceneClock{Time{0}, Time{8000}, -1e12}.timeAt(epochs, Time{INT64_MAX})), Time{1000});
}

// Offsets that are not known are those of the nearest epoch at which they are.
TEST(EpochOffsets, KnowWhatWasSet) {
  const GridTopology grid = GridTopology::create(kShape).value();
  const Epochs epochs =
      Epochs::create(kShape,
                     {{Time{0}, {}}, {Time{1}, {2, 3, 20, 14}}, {Time{2}, {2, 3, 20, 14}}, {Time{3}, {0, 0, 30, 17}}})
          .value();
  const std::vector<BaseOffset> base{{2, baseVertexNumber(grid, NodeId::at(16, 16)), 77}};
  EpochOffsets offsets(grid, epochs, base);
  const NodeId n = NodeId::at(7, 9), outside = NodeId::at(1, 1);
  EXPECT_TRUE(offsets.knows(0, n));
  EXPECT_FALSE(offsets.knows(1, n));
  EXPECT_TRUE(offsets.knows(1, outside));
  EXPECT_FALSE(offsets.knows(3, outside));
  EXPECT_EQ(offsets.at(2, n), 0);
  EXPECT_EQ(offsets.at(2, NodeId::at(16, 16)), 77);
  EXPECT_EQ(offsets.at(1, NodeId::at(16, 16)), 0);
  offsets.set(2, n, -31);
  EXPECT_TRUE(offsets.knows(2, n));
  EXPECT_EQ(offsets.at(2, n), -31);
  EXPECT_EQ(offsets.at(3, n), -31) << "the nearest";
  EXPECT_EQ(offsets.nearestKnown(3, n), 2u);
  EXPECT_EQ(offsets.at(epochs.weightsAt(Time{2}), n), -31);
  offsets.forget();
  EXPECT_FALSE(offsets.knows(2, n));
  EXPECT_EQ(offsets.at(2, n), -31) << "it is still held";
  offsets.clear();
  EXPECT_EQ(offsets.at(2, n), 0);
  EXPECT_EQ(offsets.blockCount(), 0u);
}

}  // namespace
}  // namespace foreland::proto
