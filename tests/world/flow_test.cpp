// The flow of a session in virtual time: what it costs besides the deltas, and that nothing piles up.
#include <gtest/gtest.h>

#include "server/view/tour.h"
#include "sim/world.h"
#include "tests/support/scene.h"
#include "tests/world/alps.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::LinkOptions;
using sim::Traffic;
using sim::World;

using proto::Predictor;
using proto::Strategy;

ClientOptions flying(const char* tour, double seconds, Strategy strategy = Strategy::kPredict,
                     Predictor predictor = Predictor::kConstantVelocity) {
  auto path = server::planTour(*alps(), tour, seconds);
  CHECK_TRUE(path.ok());
  ClientOptions c;
  c.request.lens = {1.0471975511965976, 480, 270};
  c.request.strategy = strategy;
  c.request.predictor = predictor;
  c.path = *path;
  c.announce_path = predictor == Predictor::kKnownPath;
  return c;
}

struct Tour {
  const char* name;
  Predictor predictor;
};

class Overhead : public testing::TestWithParam<Tour> {};

TEST_P(Overhead, IsUnder5PercentOf400BytesAKeyframe) {
  World world(alps(), {}, Duration::milliseconds(4), 41);
  ClientOptions c = flying(GetParam().name, 60, Strategy::kPredict, GetParam().predictor);
  c.up.jitter = c.down.jitter = Duration::milliseconds(10);
  world.addClient(c);
  world.run(Time::seconds(30));
  EXPECT_EQ(world.report(), "");
  const Traffic& t = world.traffic(0);
  ASSERT_GT(t.headers.messages, 140u);
  // A frame's header is 2 or 4 bytes; a keyframe of 400 bytes has 4.
  EXPECT_LT((t.headers.mean() + 4) / (t.headers.mean() + 4 + 400), 0.05);
  EXPECT_LE(t.headers.largest, 32u);
  EXPECT_LE(t.other_down.messages, 1u) << "besides keyframes there is only the welcome";
  ASSERT_GT(t.poses.messages, 550u);
  EXPECT_LE(t.poses.largest, 16u);
  EXPECT_LE(t.poses.mean(), 8);
}

INSTANTIATE_TEST_SUITE_P(Flow, Overhead,
                         testing::Values(Tour{"survey", Predictor::kKnownPath},
                                         Tour{"canyon", Predictor::kConstantVelocity},
                                         Tour{"orbit", Predictor::kConstantVelocity},
                                         Tour{"spin", Predictor::kKnownPath}),
                         [](const auto& test) { return std::string(test.param.name); });

struct Silence {
  Strategy strategy;
  LinkOptions::Buffers buffers;
};

class ReadingNothing : public testing::TestWithParam<Silence> {};

// For half a minute nothing is read, while poses go on. Then what waited is read at once, and the flight goes on: in
// time with `predict` after a second; with `delay` and `current`, which show nothing that jumps, after some more.
TEST_P(ReadingNothing, LeavesNothingPiledUpAndComesBackInSeconds) {
  const bool predicts = GetParam().strategy == Strategy::kPredict;
  const bool buffered = GetParam().buffers == LinkOptions::Buffers::kEndless;
  const Time begin = Time::seconds(10), end = Time::seconds(40), back = end + Duration::seconds(predicts ? 1 : 5);
  World world(alps(), {}, Duration::milliseconds(4), 42);
  ClientOptions c = flying("canyon", 80, GetParam().strategy);
  c.down.pause_begin = begin;
  c.down.pause_end = end;
  c.down.buffers = GetParam().buffers;
  world.addClient(c);
  Duration worst{};
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (now > back) worst = std::max(worst, now - view.shown_time);
  };
  world.run(begin);
  const uint32_t before = world.session(0).keyframe().index;
  world.run(Time{end.us - 1});
  const uint32_t made = world.session(0).keyframe().index - before;
  EXPECT_LE(made, buffered ? 8u : 1u) << "of what nobody reads";
  EXPECT_LE(world.traffic(0).max_unsent_bytes, world.traffic(0).largest_down);
  world.run(Time::seconds(70));
  EXPECT_EQ(world.report(), "");
  EXPECT_LE(world.traffic(0).max_unsent_bytes, world.traffic(0).largest_down);
  EXPECT_GT(world.viewer(0).statistics().keyframes, before + made + 130);
  EXPECT_LE(worst, Duration::milliseconds(predicts ? 100 : 600));
}

INSTANTIATE_TEST_SUITE_P(Flow, ReadingNothing,
                         testing::Values(Silence{Strategy::kPredict, LinkOptions::Buffers::kNone},
                                         Silence{Strategy::kPredict, LinkOptions::Buffers::kEndless},
                                         Silence{Strategy::kDelay, LinkOptions::Buffers::kEndless},
                                         Silence{Strategy::kCurrent, LinkOptions::Buffers::kNone}),
                         [](const auto& test) {
                           const bool buffered = test.param.buffers == LinkOptions::Buffers::kEndless;
                           return std::string(name(test.param.strategy)) + (buffered ? "Buffered" : "Unbuffered");
                         });

class SlowLink : public testing::TestWithParam<const char*> {};

// What a link of 20 kbit/s carries, stated as a budget, for views whose sections are tens of kilobytes: the tolerance
// rises until each delta is through in time, and comes down again as the link allows.
TEST_P(SlowLink, KeyframesStayCurrentAt20KilobitsASecond) {
  constexpr double kBytesPerSecond = 2500, kSeconds = 40;
  constexpr Time kBegun = Time::seconds(4);
  World world(alps(), {}, Duration::milliseconds(4), 43);
  ClientOptions c = flying(GetParam(), 50, Strategy::kPredict, Predictor::kKnownPath);
  c.request.lens = {1.0471975511965976, 1920, 1080};
  c.request.tau_px = 0.5;
  c.request.max_bytes_per_second = static_cast<uint32_t>(kBytesPerSecond);
  c.request.memory_bytes = 0;  // so that there is something to send all the time
  c.down.latency = Duration::milliseconds(30);
  c.down.bytes_per_second = kBytesPerSecond;
  world.addClient(c);
  Duration worst{};
  float max_tau_px = 0, min_tau_px = 1e9f;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    max_tau_px = std::max(max_tau_px, view.mesh->to.tau_px);
    min_tau_px = std::min(min_tau_px, view.mesh->to.tau_px);
    if (now > kBegun) worst = std::max(worst, now - view.shown_time);
  };
  world.run(kBegun + Duration::seconds(kSeconds));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(max_tau_px, 4 * c.request.tau_px);
  EXPECT_LT(min_tau_px, 0.5 * max_tau_px);
  EXPECT_GT(world.viewer(0).statistics().bytes_down, 0.2 * kSeconds * kBytesPerSecond) << "no load to speak of";
  EXPECT_LE(worst, Duration::milliseconds(400)) << "more than two intervals late";
  EXPECT_LE(world.traffic(0).max_unsent_bytes, world.traffic(0).largest_down) << "more than one delta waits";
}

INSTANTIATE_TEST_SUITE_P(Flow, SlowLink, testing::Values("survey", "canyon", "orbit", "spin"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace foreland::test
