// A session by itself: what it answers, what it refuses, when it has something to do.
#include <gtest/gtest.h>

#include "server/session/session.h"
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

}  // namespace
}  // namespace foreland::server
