// A session by itself: what it answers, what it refuses, when it has something to do.
#include "server/session/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "base/rng.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

std::shared_ptr<const World> smallWorld() {
  static const auto world = std::make_shared<const World>(test::makeScene(65, 65, 5));
  return world;
}

proto::PoseUpdate poseAt(double seconds) {
  return {{Time::seconds(seconds), {{0, 0, 1500}, proto::lookAlong({0, 0, -1}, {0, 0, 1})}}, 0, {}};
}

TEST(Session, GreetsWithTheSceneAndTheToleranceInForce) {
  Session session(smallWorld(), {.tau_px = 2.5});
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  ASSERT_TRUE(session.due());
  SessionScratch scratch;
  std::vector<Bytes> out;
  session.step(Time{}, scratch, out);
  ASSERT_EQ(out.size(), 1u);
  auto message = proto::decodeServerMessage(out[0]);
  ASSERT_TRUE(message.ok()) << message.error().message;
  const auto& welcome = std::get<proto::Welcome>(*message);
  EXPECT_EQ(welcome.shape, smallWorld()->hierarchy.grid().shape());
  EXPECT_EQ(welcome.frame, smallWorld()->hierarchy.scene().frame());
  EXPECT_EQ(welcome.tau_px, 2.5);
  EXPECT_EQ(welcome.keyframe_interval, Duration::milliseconds(200));
}

TEST(Session, RefusesEveryOtherMessageBeforeAViewRequest) {
  Session session(smallWorld(), {});
  EXPECT_FALSE(session.receive(proto::encode(poseAt(0)), Time{}).ok());
}

TEST(Session, RefusesAnAcknowledgementOfAKeyframeNeverSent) {
  Session session(smallWorld(), {});
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  proto::PoseUpdate update = poseAt(0);
  update.received_keyframe = 1;  // one more than were sent
  EXPECT_FALSE(session.receive(proto::encode(update), Time{}).ok());
}

TEST(Session, RefusesAnUnknownTourByNamingTheKnownOnes) {
  Session session(smallWorld(), {});
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  const Status s = session.receive(proto::encode(proto::TourRequest{1, "loop", 10}), Time{});
  ASSERT_FALSE(s.ok());
  EXPECT_NE(s.error().message.find("survey"), std::string::npos);
}

TEST(Session, MakesNoKeyframeWhileOneIsUnsent) {
  Session session(smallWorld(), {});
  SessionScratch scratch;
  std::vector<Bytes> out;
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(session.receive(proto::encode(poseAt(0.05 * i)), Time::seconds(0.05 * i)).ok());
    session.step(Time::seconds(0.05 * i), scratch, out);
  }
  EXPECT_EQ(session.statistics().keyframes, 1u);
  session.onDrained(Time::seconds(5));
  session.step(Time::seconds(6), scratch, out);
  EXPECT_EQ(session.statistics().keyframes, 2u);
}

// A window that is hidden has no pixels. Its session answers and follows, and goes on where it is when there are some.
TEST(Session, WaitsWhileItsViewerShowsNothing) {
  for (const bool begins_closed : {true, false})
    for (const auto& [width, height] : {std::pair(0u, 0u), {0u, 600u}, {800u, 0u}}) {
      Session session(smallWorld(), {.prefetch_ahead = Duration::seconds(1)});
      SessionScratch scratch;
      std::vector<Bytes> out;
      const auto ask = [&](proto::Lens lens, double at) {
        proto::ViewRequest request;
        request.lens = lens;
        ASSERT_TRUE(session.receive(proto::encode(request), Time::seconds(at)).ok());
      };
      const auto flyUntil = [&](double from, double to) {
        for (double t = from; t < to; t += 0.1) {
          proto::PoseUpdate update = poseAt(t);
          update.received_keyframe = session.keyframe().index;
          update.received_at = Time::seconds(t);
          ASSERT_TRUE(session.receive(proto::encode(update), Time::seconds(t)).ok());
          session.step(Time::seconds(t), scratch, out);
          session.onDrained(Time::seconds(t));
        }
      };
      const proto::Lens closed{1, width, height}, open{1, 800, 600};
      if (!begins_closed) {
        ask(open, 0);
        flyUntil(0, 2);
        EXPECT_GT(session.statistics().keyframes, 0u);
      }
      ask(closed, 2);
      const uint64_t before = session.statistics().keyframes, read = session.statistics().prefetches;
      flyUntil(2, 20);
      EXPECT_EQ(session.statistics().keyframes, before);
      EXPECT_EQ(session.statistics().prefetches, read);
      EXPECT_FALSE(session.due()) << "it waits for messages";
      EXPECT_GE(out.size(), 1u) << "the welcome";
      ASSERT_TRUE(session.receive(proto::encode(proto::GroundRequest{1, {{0, 0}}}), Time::seconds(20)).ok());
      EXPECT_TRUE(session.due()) << "what is asked is answered";
      flyUntil(20, 21);
      EXPECT_EQ(session.statistics().replies, 1u);
      ask(open, 21);
      flyUntil(21, 23);
      EXPECT_GT(session.statistics().keyframes, before);
      EXPECT_EQ(session.keyframe().lens, open);
      EXPECT_GT(session.keyframe().time, Time::seconds(20)) << "nothing of the time between is made up for";
    }
}

// The messages that a camera gets which flies over a scene and comes back.
std::vector<Bytes> messagesOver(std::shared_ptr<const terrain::Scene> scene, Occlusion occlusion) {
  const auto world = openWorld(std::move(scene), occlusion).value();
  Session session(world, {});
  SessionScratch scratch;
  std::vector<Bytes> out;
  proto::ViewRequest request;
  request.occlusion = occlusion == Occlusion::kOn;
  EXPECT_TRUE(session.receive(proto::encode(request), Time{}).ok());
  for (double t = 0; t < 12; t += 0.1) {
    const double along = 1200 * std::sin(0.5 * t);
    proto::PoseUpdate update{
        {Time::seconds(t), {{along, 0.3 * along, 250}, proto::lookAlong({1, 0.2, -0.3}, {0, 0, 1})}}, 0, {}};
    update.received_keyframe = session.keyframe().index;
    update.received_at = Time::seconds(t);
    EXPECT_TRUE(session.receive(proto::encode(update), Time::seconds(t)).ok());
    session.step(Time::seconds(t), scratch, out);
    session.onDrained(Time::seconds(t));
  }
  EXPECT_GT(session.statistics().keyframes, 30u);
  return out;
}

TEST(Session, SendsTheSameWhetherPagesAreCodedOrNot) {
  const test::TemporaryFolder folder;
  std::array<std::shared_ptr<const terrain::Scene>, 2> scenes;
  for (const auto coding : {terrain::PageCoding::kPlain, terrain::PageCoding::kCoded}) {
    test::FormulaSource source(260, 250, test::hills(5));
    ASSERT_TRUE(
        terrain::buildScene(source, {.output = folder / "scene.fls", .additions = {.page_coding = coding}}).ok());
    scenes[static_cast<size_t>(coding)] = *terrain::Scene::open(folder / "scene.fls");
  }
  ASSERT_TRUE(scenes[1]->coded());
  for (const Occlusion occlusion : {Occlusion::kOff, Occlusion::kOn}) {
    auto plain = messagesOver(scenes[0], occlusion), coded = messagesOver(scenes[1], occlusion);
    ASSERT_EQ(plain.size(), coded.size());
    EXPECT_NE(plain[0], coded[0]) << "the welcome names the scene";
    for (size_t i = 1; i < plain.size(); ++i) EXPECT_EQ(plain[i], coded[i]) << "message " << i;
  }
  EXPECT_GT(scenes[1]->coded()->counts().inflated, 0u);
}

TEST(Session, CountsTheMemoryForWhatRidgesHide) {
  const auto world = openWorld(test::makeScene(65, 65, 5), Occlusion::kOn).value();
  const auto bytesWith = [&](bool occlusion) {
    Session session(world, {});
    SessionScratch scratch;
    std::vector<Bytes> out;
    proto::ViewRequest request;
    request.occlusion = occlusion;
    EXPECT_TRUE(session.receive(proto::encode(request), Time{}).ok());
    EXPECT_TRUE(session.receive(proto::encode(poseAt(0)), Time{}).ok());
    session.step(Time::seconds(1), scratch, out);
    EXPECT_EQ(session.statistics().keyframes, 1u);
    return session.statistics().memory_bytes;
  };
  EXPECT_GT(bytesWith(true), bytesWith(false) + sizeof(ViewerOcclusion));
}

// By half an interval at most, and only if it is told to.
TEST(Session, ComputesAKeyframeEarlyIfItIsToldTo) {
  Session session(smallWorld(), {.max_early = Duration::milliseconds(1000), .slack = Duration{}});
  SessionScratch scratch;
  std::vector<Bytes> out;
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(poseAt(0)), Time{}).ok());
  session.step(Time::seconds(1), scratch, out);
  ASSERT_EQ(session.statistics().keyframes, 1u);
  session.onDrained(Time::seconds(1));
  ASSERT_TRUE(session.receive(proto::encode(poseAt(1)), Time::seconds(1)).ok());
  const auto due = session.due();
  ASSERT_TRUE(due && due->earliest);
  EXPECT_EQ(due->work, session.computeTime());
  EXPECT_GT(due->release - *due->earliest, Duration{});
  EXPECT_LE(due->release - *due->earliest, Duration::milliseconds(100));  // half of the usual interval
  const Time early = std::max(*due->earliest, Time::seconds(1));
  ASSERT_LT(early, due->release);
  session.step(early, scratch, out);
  EXPECT_EQ(session.statistics().keyframes, 1u);
  session.step(early, scratch, out, Session::Start::kEarly);
  EXPECT_EQ(session.statistics().keyframes, 2u);
}

// When the second keyframe is due to be begun.
Due dueOfSecond(const SessionOptions& options) {
  Session session(smallWorld(), options);
  SessionScratch scratch;
  std::vector<Bytes> out;
  EXPECT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  EXPECT_TRUE(session.receive(proto::encode(poseAt(0)), Time{}).ok());
  session.step(Time::seconds(1), scratch, out);
  session.onDrained(Time::seconds(1));
  EXPECT_TRUE(session.receive(proto::encode(poseAt(1)), Time::seconds(1)).ok());
  return session.due().value();
}

// The slack moves the beginning and nothing else, not beyond the earliest, and only where that is permitted.
TEST(Session, BeginsAKeyframeEarlierByItsSlack) {
  const auto dueWith = [](int64_t max_early_ms, int64_t slack_ms) {
    return dueOfSecond({.max_early = Duration::milliseconds(max_early_ms), .slack = Duration::milliseconds(slack_ms)});
  };
  const Due tight = dueWith(40, 0), loose = dueWith(40, 20), most = dueWith(40, 90);
  EXPECT_EQ(loose.release, tight.release - Duration::milliseconds(20));
  EXPECT_EQ(loose.deadline, tight.deadline);
  EXPECT_EQ(loose.earliest, tight.earliest);
  EXPECT_EQ(most.release, *tight.earliest);
  EXPECT_EQ(dueWith(0, 20).release, tight.release);
}

TEST(Session, PrefetchesBetweenKeyframesWithoutSendingAnything) {
  Session session(smallWorld(), {.prefetch_ahead = Duration::milliseconds(2000)});
  SessionScratch scratch;
  std::vector<Bytes> out;
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(poseAt(0)), Time{}).ok());
  session.step(Time::seconds(1), scratch, out);
  ASSERT_EQ(session.statistics().keyframes, 1u);
  const size_t sent = out.size();
  ASSERT_TRUE(session.due());
  session.step(Time::seconds(1.1), scratch, out);  // the keyframe is unsent still
  EXPECT_EQ(session.statistics().prefetches, 1u);
  session.step(Time::seconds(1.2), scratch, out);  // not again so soon
  EXPECT_EQ(session.statistics().prefetches, 1u);
  EXPECT_EQ(out.size(), sent);
}

// A camera that stands for a minute over a scene that is in memory, or is not; after half of it a keyframe has to read.
TEST(Session, PrefetchesSeldomWhatIsInMemory) {
  for (const uint64_t pages_read : {0, 3}) {
    Session session(smallWorld(), {.prefetch_ahead = Duration::milliseconds(2000)});
    SessionScratch scratch;
    std::vector<Bytes> out;
    ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
    std::array<uint64_t, 2> prefetches{};  // in either half
    for (int i = 0; i < 1200; ++i) {
      const Time now = Time::seconds(0.05 * i);
      proto::PoseUpdate update = poseAt(0.05 * i);
      update.received_keyframe = session.keyframe().index;
      update.received_at = now;
      ASSERT_TRUE(session.receive(proto::encode(update), now).ok());
      const SessionStatistics before = session.statistics();
      session.step(now, scratch, out);
      const bool did_prefetch = session.statistics().prefetches > before.prefetches;
      const bool keyframe_reads = i > 600 && i < 610 && session.statistics().keyframes > before.keyframes;
      session.noteComputeTime({}, did_prefetch ? pages_read : keyframe_reads ? 1 : 0);
      session.onDrained(now);
      prefetches[i / 600] += did_prefetch ? 1 : 0;
    }
    const auto [first, second] = prefetches;
    if (pages_read == 0) {
      EXPECT_LE(first, 6u);
      EXPECT_GE(second, 4u) << "the keyframe made it begin again";
      EXPECT_LE(second, 8u);
    } else {
      EXPECT_GE(std::min(first, second), 50u);
    }
  }
}

TEST(Session, ATinyToleranceIsDoubledUntilTheSectionFits) {
  Session session(smallWorld(), {.max_section_nodes = 500});
  SessionScratch scratch;
  std::vector<Bytes> out;
  proto::ViewRequest request;
  request.tau_px = 0.01;
  ASSERT_TRUE(session.receive(proto::encode(request), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(poseAt(0)), Time{}).ok());
  session.step(Time::seconds(1), scratch, out);
  EXPECT_EQ(session.statistics().keyframes, 1u);
  EXPECT_LE(session.section().slots.size(), 500u);
  EXPECT_GT(session.keyframe().tau_px, 0.01f);
}

// A camera that stands, jumps at `jump_s`, and stands again; poses and keyframes every 50 ms.
struct Jumper {
  Session session;
  SessionScratch scratch;
  std::vector<Bytes> out;

  Jumper(std::shared_ptr<const World> world, const SessionOptions& options, proto::Strategy strategy)
      : session(std::move(world), options) {
    proto::ViewRequest request;
    request.strategy = strategy;
    request.predictor = proto::Predictor::kConstantVelocity;
    CHECK_TRUE(session.receive(proto::encode(request), Time{}).ok());
  }
  void pose(double s, const glm::dvec3& eye, const glm::dvec3& forward, bool has_jumped = false) {
    proto::PoseUpdate update{{Time::seconds(s), {eye, proto::lookAlong(forward, {0, 0, 1})}}, 0, {}};
    update.has_jumped = has_jumped;
    update.received_keyframe = session.keyframe().index;
    update.received_at = Time::seconds(s);
    CHECK_TRUE(session.receive(proto::encode(update), Time::seconds(s)).ok());
    session.step(Time::seconds(s), scratch, out);
    session.onDrained(Time::seconds(s));
  }
};

TEST(Session, StartsFromNothingAtTheCameraAfterAJump) {
  for (const proto::Strategy strategy :
       {proto::Strategy::kDelay, proto::Strategy::kCurrent, proto::Strategy::kPredict}) {
    Jumper jumper(smallWorld(), {}, strategy);
    const glm::dvec3 here(0, 0, 900), there(300, -2000, 700), down(0.3, 0, -1), north(0, 1, -0.5);
    for (int i = 0; i < 40; ++i) jumper.pose(0.05 * i, here, down);
    const uint32_t before = jumper.session.keyframe().index;
    ASSERT_GT(before, 2u);
    EXPECT_EQ(jumper.session.keyframe().base_index, before - 1);
    jumper.pose(2.025, there, north);
    jumper.pose(2.1, there, north);
    const proto::KeyframeHeader& keyframe = jumper.session.keyframe();
    EXPECT_EQ(keyframe.index, before + 1);
    EXPECT_EQ(keyframe.base_index, 0u);
    EXPECT_LT(glm::distance(keyframe.pose.eye, there), 0.1);
    EXPECT_LT(keyframe.region_radius_m, 1) << "the way from one view to the other is in no region";
    for (int i = 43; i < 60; ++i) jumper.pose(0.05 * i, there, north);
    EXPECT_GT(keyframe.base_index, before);
    EXPECT_LT(glm::distance(keyframe.pose.eye, there), 0.1);
    EXPECT_LT(keyframe.region_radius_m, 1);
    EXPECT_EQ(jumper.session.statistics().jumps, 1u);
  }
}

// A camera that is told to be everywhere at once costs no more keyframes than another.
TEST(Session, AJumpWithEveryPoseGetsAKeyframeAnInterval) {
  Jumper jumper(smallWorld(), {}, proto::Strategy::kPredict);
  for (int i = 0; i < 200; ++i) jumper.pose(0.05 * i, {3000.0 * (i % 2), 0, 900}, {0.3, 0, -1});
  EXPECT_LE(jumper.session.statistics().keyframes, 53u);
  EXPECT_GE(jumper.session.statistics().keyframes, 40u);
}

void expectTheSame(const Session& a, const Session& b) {
  const proto::KeyframeHeader &k = a.keyframe(), &l = b.keyframe();
  EXPECT_EQ(k.pose.eye, l.pose.eye);
  EXPECT_EQ(k.pose.orientation, l.pose.orientation);
  EXPECT_EQ(k.region_radius_m, l.region_radius_m);
  EXPECT_EQ(k.region_angle_rad, l.region_angle_rad);
  EXPECT_EQ(k.tau_px, l.tau_px);
  EXPECT_EQ(a.section().slots, b.section().slots);
}

// A camera that stands, and jumps 300 m or turns on the spot, slowly enough to have flown there. If the pose says that
// it jumped, the session goes on as one that begins there.
TEST(Session, AfterAnAnnouncedJumpGoesOnAsANewSessionWould) {
  const glm::dvec3 here(0, 0, 900), down(0.3, 0, -1);
  struct Jump {
    glm::dvec3 eye, forward;
  };
  for (const proto::Strategy strategy : {proto::Strategy::kDelay, proto::Strategy::kCurrent, proto::Strategy::kPredict})
    for (const Jump& jump : {Jump{{300, 0, 900}, down}, Jump{here, {0.3, 0.4, -1}}})
      for (const bool is_announced : {true, false}) {
        Jumper jumper(smallWorld(), {}, strategy), fresh(smallWorld(), {}, strategy);
        for (int i = 0; i < 40; ++i) jumper.pose(0.05 * i, here, down);
        const uint32_t before = jumper.session.keyframe().index;
        jumper.pose(2.35, jump.eye, jump.forward, is_announced);
        EXPECT_EQ(jumper.session.statistics().jumps, is_announced ? 1u : 0u);
        if (!is_announced) continue;
        EXPECT_EQ(jumper.session.keyframe().index, before + 1);
        EXPECT_EQ(jumper.session.keyframe().base_index, 0u);
        fresh.pose(2.35, jump.eye, jump.forward);
        for (int i = 48; fresh.session.keyframe().index == 0; ++i) fresh.pose(0.05 * i, jump.eye, jump.forward);
        expectTheSame(jumper.session, fresh.session);
        for (int i = 60; i < 90; ++i)
          for (Jumper* both : {&jumper, &fresh}) both->pose(0.05 * i, jump.eye, jump.forward);
        expectTheSame(jumper.session, fresh.session);
      }
}

// An acknowledgement's pose is no newer than the last one, so nothing has jumped.
TEST(Session, NoJumpIsAnnouncedByAPoseThatIsNotNew) {
  Jumper jumper(smallWorld(), {}, proto::Strategy::kPredict);
  const glm::dvec3 here(0, 0, 900), down(0.3, 0, -1);
  jumper.pose(0, here, down, true);  // nor by the first
  for (int i = 0; i < 20; ++i) jumper.pose(0.05 * i, here, down);
  for (int i = 0; i < 20; ++i) jumper.pose(0.95, here, down, true);
  EXPECT_EQ(jumper.session.statistics().jumps, 0u);
  jumper.pose(1, here, down, true);
  EXPECT_EQ(jumper.session.statistics().jumps, 1u);
}

// A viewer that announces a jump with every pose is believed for a few, and costs no more than these beside one that
// does not.
TEST(Session, JumpsAnnouncedWithoutEndAreMotion) {
  std::array<uint64_t, 2> added{};
  uint64_t max_nodes = 0;
  for (const bool is_announced : {false, true}) {
    Jumper jumper(smallWorld(), {}, proto::Strategy::kPredict);
    uint64_t from_nothing = 0;
    uint32_t last = 0;
    for (int i = 0; i < 400; ++i) {
      jumper.pose(0.05 * i, {600 * std::sin(0.03 * i), 0, 900}, {0.3, 0, -1}, is_announced);
      const proto::KeyframeHeader& keyframe = jumper.session.keyframe();
      max_nodes = std::max<uint64_t>(max_nodes, jumper.session.statistics().section_nodes);
      if (keyframe.index != std::exchange(last, keyframe.index) && keyframe.base_index == 0) ++from_nothing;
    }
    added[is_announced] = jumper.session.statistics().nodes_added;
    EXPECT_GT(jumper.session.statistics().keyframes, 90u) << "it is served";
    EXPECT_LE(from_nothing, is_announced ? 4u + 20u + 1u : 1u);
  }
  EXPECT_LE(added[true], added[false] + 25 * max_nodes);
}

TEST(Session, NoSectionIsLargerThanItsLimitHoweverTheCameraMoves) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (const proto::Strategy strategy : {proto::Strategy::kCurrent, proto::Strategy::kPredict}) {
    Jumper jumper(smallWorld(), {.max_section_nodes = 300, .max_added_nodes = 200, .max_added_after_jump = 50},
                  strategy);
    glm::dvec3 eye(0, 0, 900), velocity(0);
    for (int i = 0; i < 300; ++i) {
      if (rng.below(12) == 0) velocity = {rng.uniform(-900, 900), rng.uniform(-900, 900), rng.uniform(-50, 50)};
      if (rng.below(25) == 0) eye = {rng.uniform(-1500, 1500), rng.uniform(-1500, 1500), rng.uniform(100, 2000)};
      eye += 0.05 * velocity;
      jumper.pose(0.05 * i, eye, {rng.uniform(-1, 1), rng.uniform(-1, 1), -0.5});
      ASSERT_LE(jumper.session.section().slots.size(), 300u) << i;
    }
    EXPECT_GT(jumper.session.statistics().keyframes, 30u);
    EXPECT_GT(jumper.session.statistics().jumps, 3u);
  }
}

TEST(Session, AnEnormousRegionGetsASectionForThePoseAlone) {
  Jumper jumper(smallWorld(), {.max_section_nodes = 300}, proto::Strategy::kPredict);
  for (int i = 0; i < 60; ++i) jumper.pose(0.05 * i, {1e6 * i, 0, 5e7}, {0, 0, -1});
  for (int i = 60; i < 90; ++i) jumper.pose(0.05 * i, {0, 0, 900}, {0, 0.2, -1});
  EXPECT_LE(jumper.session.section().slots.size(), 300u);
  EXPECT_LT(jumper.session.keyframe().tau_px, 1000);
}

// A session whose viewer has asked for a view, and been told of the scene.
class GreetedSession : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
    session.step(Time{}, scratch, out);
    out.clear();
  }
  Session session{smallWorld(), {}};
  SessionScratch scratch;
  std::vector<Bytes> out;
};

TEST_F(GreetedSession, AnswersRequestsOneAStepAndNoneWhileAReplyIsUnsent) {
  for (uint32_t i = 0; i < 3; ++i)
    ASSERT_TRUE(session.receive(proto::encode(proto::GroundRequest{i, {{1, 2}}}), Time{}).ok());
  ASSERT_TRUE(session.due() && session.due()->is_costly);
  session.step(Time{}, scratch, out);
  session.noteComputeTime(Duration::milliseconds(100));
  EXPECT_EQ(out.size(), 1u);
  EXPECT_FALSE(session.due()) << "the reply is unsent";
  session.onDrained(Time::seconds(0.1));
  EXPECT_GE(session.due()->release, Time::seconds(0.5)) << "a fifth of a worker's time";
  session.step(Time::seconds(0.2), scratch, out);
  EXPECT_EQ(out.size(), 1u);
  session.step(Time::seconds(0.6), scratch, out);
  EXPECT_EQ(out.size(), 2u);
}

TEST(Session, RefusesMoreRequestsThanMayWait) {
  Session session(smallWorld(), {});
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  const auto ask = [&](uint32_t id) {
    return session.receive(proto::encode(proto::GroundRequest{id, {{1, 2}}}), Time{});
  };
  for (uint32_t i = 0; i < Requests::kMax; ++i) ASSERT_TRUE(ask(i).ok());
  EXPECT_FALSE(ask(99).ok());
}

// Else those who come together and ask for tours stop all who fly.
TEST_F(GreetedSession, ATourIsDueAfterTheKeyframesOfOthersOfAWholeSecond) {
  ASSERT_TRUE(session.receive(proto::encode(proto::TourRequest{1, "survey", 10}), Time{}).ok());
  const auto due = session.due();
  ASSERT_TRUE(due);
  EXPECT_EQ(due->deadline, due->release + Duration::seconds(1));
  session.step(due->release, scratch, out);
  session.onDrained(due->release);
  ASSERT_TRUE(session.receive(proto::encode(proto::GroundRequest{2, {{1, 2}}}), due->release).ok());
  const auto soon = session.due();
  ASSERT_TRUE(soon);
  EXPECT_LT(soon->deadline, soon->release + Duration::seconds(1));
}

TEST_F(GreetedSession, ANewerTourReplacesOneThatWaits) {
  for (uint32_t i = 0; i < 60; ++i)
    ASSERT_TRUE(session.receive(proto::encode(proto::TourRequest{i, "survey", 10}), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(proto::GroundRequest{60, {{1, 2}}}), Time{}).ok());
  for (int i = 0; i < 10; ++i) {
    session.step(Time::seconds(i), scratch, out);
    session.onDrained(Time::seconds(i));
  }
  ASSERT_EQ(out.size(), 2u);
  const auto tour = proto::decodeServerMessage(out[0]), ground = proto::decodeServerMessage(out[1]);
  ASSERT_TRUE(tour.ok() && ground.ok());
  EXPECT_EQ(std::get<proto::TourReply>(*tour).id, 59u);
  EXPECT_EQ(std::get<proto::GroundReply>(*ground).id, 60u);
}

TEST_F(GreetedSession, ANewerViewshedReplacesOneThatWaitsAndACancelledOneGoes) {
  for (uint32_t i = 0; i < 60; ++i)
    ASSERT_TRUE(session.receive(proto::encode(proto::ViewshedRequest{i, {20, 20}, 2, 0, 100, 10}), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(proto::GroundRequest{60, {{1, 2}}}), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(proto::GroundRequest{61, {{1, 2}}}), Time{}).ok());
  ASSERT_TRUE(session.receive(proto::encode(proto::RequestCancel{60}), Time{}).ok());
  for (int i = 0; i < 10; ++i) {
    session.step(Time::seconds(i), scratch, out);
    session.onDrained(Time::seconds(i));
  }
  ASSERT_EQ(out.size(), 2u);
  const auto viewshed = proto::decodeServerMessage(out[0]), ground = proto::decodeServerMessage(out[1]);
  ASSERT_TRUE(viewshed.ok() && ground.ok());
  EXPECT_EQ(std::get<proto::ViewshedReply>(*viewshed).id, 59u);
  EXPECT_EQ(std::get<proto::ViewshedReply>(*viewshed).error, "");
  EXPECT_EQ(std::get<proto::GroundReply>(*ground).id, 61u);
}

TEST_F(GreetedSession, TellsTheBytesThatItKeepsForItsViewer) {
  EXPECT_EQ(session.keptBytes(), 0u);
  proto::Path path{.start = {}, .poses = std::vector<proto::Pose>(1000)};
  ASSERT_TRUE(session.receive(proto::encode(path), Time{}).ok());
  const size_t with_path = session.keptBytes();
  EXPECT_GE(with_path, 1000 * sizeof(proto::Pose));
  ASSERT_TRUE(session.receive(proto::encode(path), Time{}).ok());
  EXPECT_EQ(session.keptBytes(), with_path) << "a path replaces the one before";
  const proto::GroundRequest ground{1, std::vector<glm::dvec2>(100, {1, 2})};
  ASSERT_TRUE(session.receive(proto::encode(ground), Time{}).ok());
  EXPECT_GE(session.keptBytes(), with_path + 100 * sizeof(glm::dvec2));
  ASSERT_TRUE(session.receive(proto::encode(proto::Resume{1, 2, Time{}, 3, Bytes(5000)}), Time{}).ok());
  EXPECT_GE(session.keptBytes(), with_path + 5000);
  for (int i = 0; i < 3; ++i) session.step(Time::seconds(i), scratch, out);
  EXPECT_EQ(session.keptBytes(), with_path) << "the rest is done with";
}

TEST(Session, ResumesOnceAtMost) {
  Session session(smallWorld(), {});
  ASSERT_TRUE(session.receive(proto::encode(proto::ViewRequest{}), Time{}).ok());
  const Bytes resume = proto::encode(proto::Resume{1, 2, Time{}, 3, {1, 2, 3}});
  EXPECT_TRUE(session.receive(resume, Time{}).ok());
  EXPECT_FALSE(session.receive(resume, Time{}).ok());
}

// Neither hours ahead nor hours back stop a flight, nor are keyframes counted as skipped that there was no time for.
TEST(Session, FliesOnAfterTheViewersClockIsSetAnew) {
  for (const double step_s : {3600.0 * 1000, -3600.0 * 1000})
    for (const proto::Strategy strategy : {proto::Strategy::kDelay, proto::Strategy::kPredict}) {
      Jumper jumper(smallWorld(), {}, strategy);
      double server_s = 0;
      const auto fly = [&](int poses, double offset_s) {
        for (int i = 0; i < poses; ++i, server_s += 0.05) {
          proto::PoseUpdate update = poseAt(server_s + offset_s);
          update.received_keyframe = jumper.session.keyframe().index;
          update.received_at = update.pose.time;
          ASSERT_TRUE(jumper.session.receive(proto::encode(update), Time::seconds(server_s)).ok());
          jumper.session.step(Time::seconds(server_s), jumper.scratch, jumper.out);
          jumper.session.onDrained(Time::seconds(server_s));
        }
      };
      fly(100, 0);
      const uint64_t before = jumper.session.statistics().keyframes;
      fly(100, step_s);
      EXPECT_GE(jumper.session.statistics().keyframes, before + 20) << step_s;
      EXPECT_LE(jumper.session.statistics().skipped_keyframes, 30u);
      EXPECT_NEAR(jumper.session.keyframe().time.toSeconds(), server_s + step_s, 2);
    }
}

}  // namespace
}  // namespace foreland::server
