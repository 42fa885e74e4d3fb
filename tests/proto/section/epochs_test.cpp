#include "proto/section/epochs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "proto/section/epoch_offsets.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

constexpr GridShape kShape{2, 1, 4, 30, 17};

Epochs anyEpochs(Rng& rng, size_t count, EpochBlend blend = EpochBlend::kLinear) {
  std::vector<Epoch> epochs;
  int64_t t = static_cast<int64_t>(rng.below(1000)) - 500;
  for (size_t i = 0; i < count; ++i) {
    t += 1 + static_cast<int64_t>(rng.below(1000));
    epochs.push_back({Time{t}, i == 0 ? LatticeWindow{} : LatticeWindow{2, 3, 20, 14}});
  }
  return Epochs::create(kShape, epochs, blend).value();
}

constexpr EpochBlend kCubic[] = {EpochBlend::kCatmullRom, EpochBlend::kBSpline};

std::vector<int32_t> anyValues(Rng& rng, size_t count) {
  std::vector<int32_t> values;
  for (size_t i = 0; i < count; ++i) values.push_back(static_cast<int32_t>(rng.below(20'001)) - 10'000);
  return values;
}

double blended(const Epochs& epochs, std::span<const int32_t> values, Time t) {
  const EpochWeights w = epochs.weightsAt(t);
  double sum = 0;
  for (uint32_t i = 0; i < w.count; ++i) sum += w.weight[i] * values[w.epoch[i]];
  return sum;
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

// Weights add to 1; a B-spline's are not negative, and of Catmull-Rom's no more than a quarter is.
TEST(Epochs, BlendWithWeightsThatAddToOne) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 50; ++trial)
    for (const EpochBlend blend : kCubic) {
      const Epochs epochs = anyEpochs(rng, 1 + rng.below(7), blend);
      for (int64_t us = epochs.first().us; us <= epochs.last().us; ++us) {
        const EpochWeights w = epochs.weightsAt(Time{us});
        double sum = 0, negative = 0;
        for (uint32_t i = 0; i < w.count; ++i) {
          sum += w.weight[i];
          negative -= std::min(w.weight[i], 0.0);
          EXPECT_LT(w.epoch[i], epochs.size());
          if (i > 0) { EXPECT_EQ(w.epoch[i], w.epoch[i - 1] + 1); }
        }
        EXPECT_NEAR(sum, 1, 1e-14);
        EXPECT_LE(negative, blend == EpochBlend::kBSpline ? 0 : 0.25 + 1e-14);
      }
    }
}

// Catmull-Rom at every date, the B-spline at the first and the last.
TEST(Epochs, AreShownAloneAtTheirDates) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 50; ++trial)
    for (const EpochBlend blend : kCubic) {
      const Epochs epochs = anyEpochs(rng, 1 + rng.below(7), blend);
      for (uint32_t i = 0; i < epochs.size(); ++i) {
        if (blend == EpochBlend::kBSpline && i > 0 && i + 1 < epochs.size()) continue;
        EXPECT_EQ(epochs.weightsAt(epochs[i].time), (EpochWeights{{i}, {1}, 1}));
      }
    }
}

// The value and its slope come to the same at a date from either side; the B-spline's second slope, too.
TEST(Epochs, AreJoinedSmoothly) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 200; ++trial)
    for (const EpochBlend blend : kCubic) {
      const Epochs epochs = anyEpochs(rng, 3 + rng.below(6), blend);
      const std::vector<int32_t> values = anyValues(rng, epochs.size());
      const auto control = [&](const EpochCurve& curve, size_t k) {
        double sum = 0;
        for (uint32_t i = 0; i < curve.count; ++i) sum += curve.controls[k][i] * values[curve.first + i];
        return sum;
      };
      for (uint32_t i = 1; i + 1 < epochs.size(); ++i) {
        const EpochCurve before = epochs.curveAfter(i - 1), after = epochs.curveAfter(i);
        const double rest = static_cast<double>((epochs[i].time - epochs[i - 1].time).us),
                     next = static_cast<double>((epochs[i + 1].time - epochs[i].time).us);
        EXPECT_NEAR(control(before, 3), control(after, 0), 1e-8);
        EXPECT_NEAR(control(after, 0), blended(epochs, values, epochs[i].time), 1e-8);
        EXPECT_NEAR((control(before, 3) - control(before, 2)) / rest, (control(after, 1) - control(after, 0)) / next,
                    1e-7);
        if (blend == EpochBlend::kCatmullRom) {
          EXPECT_NEAR(3 * (control(after, 1) - control(after, 0)) / next,
                      (values[i + 1] - values[i - 1]) / (rest + next), 1e-7);
          continue;
        }
        EXPECT_NEAR((control(before, 3) - 2 * control(before, 2) + control(before, 1)) / (rest * rest),
                    (control(after, 2) - 2 * control(after, 1) + control(after, 0)) / (next * next), 1e-7);
      }
    }
}

// What bounds are made by: range() holds the quantity at all times, a curve's accelerations are at its ends, and a
// quantity differs from the line between two times by no more than the largest of them times the square of the way.
TEST(Epochs, HoldWhatTheyBlend) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int trial = 0; trial < 50; ++trial)
    for (const EpochBlend blend : kCubic) {
      const Epochs epochs = anyEpochs(rng, 2 + rng.below(6), blend);
      const std::vector<int32_t> values = anyValues(rng, epochs.size());
      const auto [least, most] = epochs.range(values);
      for (int64_t us = epochs.first().us; us <= epochs.last().us; ++us) {
        EXPECT_GE(blended(epochs, values, Time{us}), least - 1e-8);
        EXPECT_LE(blended(epochs, values, Time{us}), most + 1e-8);
      }
      double steepest = 0;  // by microseconds
      for (uint32_t i = 0; i + 1 < epochs.size(); ++i) {
        const EpochCurve curve = epochs.curveAfter(i);
        const double span = static_cast<double>((epochs[i + 1].time - epochs[i].time).us);
        for (const auto& weights : curve.accelerations()) {
          double sum = 0;
          for (uint32_t k = 0; k < curve.count; ++k) sum += weights[k] * values[curve.first + k];
          steepest = std::max(steepest, std::fabs(sum) / (span * span));
        }
      }
      const auto any = [&] { return rng.below(static_cast<uint64_t>((epochs.last() - epochs.first()).us) + 1); };
      for (int i = 0; i < 100; ++i) {
        const Time a = epochs.first() + Duration{static_cast<int64_t>(any())},
                   b = epochs.first() + Duration{static_cast<int64_t>(any())};
        const Time middle{(a.us + b.us) / 2};
        if ((b - a).us % 2 != 0) continue;
        const double way = static_cast<double>((b - a).us);
        const double line = 0.5 * (blended(epochs, values, a) + blended(epochs, values, b));
        EXPECT_LE(std::fabs(blended(epochs, values, middle) - line), steepest * way * way / 8 + 1e-7);
      }
    }
}

// Motion that is steady is drawn so by Catmull-Rom, whatever the dates.
TEST(Epochs, KeepSteadyMotionSteady) {
  const Epochs epochs =
      Epochs::create(kShape, {{Time{0}, {}}, {Time{30}, {}}, {Time{40}, {}}, {Time{100}, {}}}, EpochBlend::kCatmullRom)
          .value();
  const std::vector<int32_t> values{0, 300, 400, 1000};
  for (int64_t us = 0; us <= 100; ++us)
    EXPECT_NEAR(blended(epochs, values, Time{us}), 10.0 * static_cast<double>(us), 1e-10);
}

TEST(Epochs, AreBlendedInKnownWaysOnly) {
  for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(static_cast<uint32_t>(epochBlendOf(i).value()), i);
  EXPECT_FALSE(epochBlendOf(3).has_value());
  EXPECT_FALSE(epochBlendOf(0xffffffff).has_value());
}

TEST(Epochs, NumberBaseVertices) {
  const GridTopology grid = GridTopology::create({3, 2, 4, 48, 32}).value();
  for (uint32_t number = 0; number < 4 * 3 + 3 * 2; ++number)
    EXPECT_EQ(baseVertexNumber(grid, baseVertex(grid, number)), number);
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
