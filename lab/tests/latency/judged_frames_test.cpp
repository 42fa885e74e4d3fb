// Which frames of a flight are judged, at all rates from ten a second to one in ten seconds.
#include "lab/latency/judged_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

namespace foreland::lab {
namespace {

constexpr uint32_t kMaxOneIn = 100;

std::vector<uint64_t> judgedOf(uint32_t one_in, size_t count) {
  const JudgedFrames judged(one_in);
  std::vector<uint64_t> frames;
  for (uint64_t frame = 0; frames.size() < count; ++frame)
    if (judged.has(frame)) frames.push_back(frame);
  return frames;
}

// How often each phase of the interval is among the frames.
std::map<uint64_t, double> phasesOf(const std::vector<uint64_t>& frames, uint64_t interval) {
  std::map<uint64_t, double> phases;
  for (const uint64_t frame : frames) ++phases[frame % interval];
  return phases;
}

TEST(JudgedFrames, AreAsManyASecondAsAskedFor) {
  for (uint32_t one_in = 1; one_in <= kMaxOneIn; ++one_in) {
    const std::vector<uint64_t> frames = judgedOf(one_in, 500);
    for (size_t i = 0; i < frames.size(); ++i) ASSERT_EQ(frames[i] / (6 * one_in), i) << one_in;
    EXPECT_DOUBLE_EQ(JudgedFrames(one_in).hz() * one_in, 10);
  }
}

TEST(JudgedFrames, AreSomeOfThoseOfTenASecond) {
  const JudgedFrames most;
  for (uint32_t one_in = 1; one_in <= kMaxOneIn; ++one_in)
    for (const uint64_t frame : judgedOf(one_in, 500)) ASSERT_TRUE(most.has(frame)) << one_in << " " << frame;
}

// Keyframes each 100, 200, 300, 500 and 1000 ms.
TEST(JudgedFrames, FallOnAllPhasesOfAnIntervalEquallyOften) {
  constexpr size_t kCount = 3600;
  const std::vector<uint64_t> most = judgedOf(1, kCount);
  for (uint32_t one_in = 1; one_in <= kMaxOneIn; ++one_in) {
    const std::vector<uint64_t> frames = judgedOf(one_in, kCount);
    for (const uint64_t interval : {6, 12, 18, 30, 60}) {
      const auto phases = phasesOf(frames, interval), wanted = phasesOf(most, interval);
      ASSERT_GE(wanted.size(), 6u);
      ASSERT_EQ(phases.size(), wanted.size()) << interval << " " << one_in;
      for (const auto& [phase, times] : phases)
        ASSERT_NEAR(times / wanted.at(phase), 1, 0.2) << interval << " " << one_in << " " << phase;
    }
  }
}

TEST(JudgedFrames, FallOnAllPhasesOfShortIntervalsSoon) {
  for (const uint64_t interval : {6, 12, 18})
    for (uint32_t one_in = 1; one_in <= kMaxOneIn; ++one_in)
      EXPECT_EQ(phasesOf(judgedOf(one_in, 64), interval).size(), 6u) << interval << " " << one_in;
}

TEST(JudgedFrames, AreRefusedAtRatesThatAreNoPartOfTen) {
  for (uint32_t one_in = 1; one_in <= kMaxOneIn; ++one_in) {
    const auto judged = JudgedFrames::atRate(10.0 / one_in);
    ASSERT_TRUE(judged.ok()) << one_in;
    EXPECT_DOUBLE_EQ(judged->hz(), 10.0 / one_in);
  }
  EXPECT_DOUBLE_EQ(JudgedFrames::atRate(3.333)->hz(), 10.0 / 3);
  for (const double hz : {0.0, -2.0, 0.09, 3.0, 7.0, 11.0, 60.0, double(NAN), double(INFINITY)})
    EXPECT_FALSE(JudgedFrames::atRate(hz).ok()) << hz;
  EXPECT_EQ(JudgedFrames::atRate(3).error().message,
            "the frames judged a second must be 10 or a whole part of it, such as 5, 2, 1 or 0.1, not 3");
}

}  // namespace
}  // namespace foreland::lab
