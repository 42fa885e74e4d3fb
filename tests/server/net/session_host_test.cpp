// Sessions on several workers, without sockets: the test is the I/O thread. The laws: a session never has two unsent
// deltas, its messages come in order, and what it computes does not depend on the threads.
#include "server/net/session_host.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "proto/message/message.h"
#include "server/net/steady_clock.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

constexpr std::chrono::seconds kTimeout{20};

std::shared_ptr<const World> hillWorld() {
  static const auto world = std::make_shared<const World>(test::makeScene(129, 129, 11));
  return world;
}

// What the workers hand to the I/O thread.
class Mailbox {
 public:
  struct Item {
    size_t viewer;
    std::vector<Bytes> batch;  // empty: refused
    std::string refusal{};
  };

  void put(Item item) {
    const std::lock_guard lock(mutex_);
    items_.push_back(std::move(item));
    changed_.notify_one();
  }
  // Nothing if nothing comes for a while.
  std::optional<Item> take(std::chrono::milliseconds wait = kTimeout) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, wait, [this] { return !items_.empty(); })) return std::nullopt;
    Item item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> items_;
};

struct Viewer {
  std::shared_ptr<SessionActor> actor;
  proto::KeyframeMemory keyframes_taken{};
  uint64_t batches = 0;
  uint32_t keyframes = 0;
  bool has_unsent_keyframe = false;
};

Bytes poseUpdate(uint32_t received) {
  proto::PoseUpdate update;
  update.pose.time = update.received_at = steadyNow();
  update.pose.pose.eye = {std::sin(update.pose.time.toSeconds()) * 300, 0, 1400};
  update.pose.pose.orientation = proto::lookAlong({0, 0.7, -0.7}, {0, 0, 1});
  update.received_keyframe = received;
  return proto::encode(update);
}

class Host : public testing::Test {
 protected:
  size_t open(const HostLimits& limits = {}) {
    if (!host_)
      host_ =
          std::make_unique<SessionHost>(std::vector{hillWorld()}, SessionOptions{}, limits, pool_, steadyNow, metrics_);
    const size_t index = viewers_.size();
    Outlet outlet;
    outlet.send = [this, index](std::vector<Bytes> batch) { mailbox_.put({index, std::move(batch), {}}); };
    outlet.refuse = [this, index](std::string why) { mailbox_.put({index, {}, std::move(why)}); };
    viewers_.push_back({.actor = host_->open(std::move(outlet))});
    return index;
  }

  Status requestView(size_t index) {
    proto::ViewRequest request;
    request.keyframe_interval = Duration::milliseconds(20);
    request.strategy = static_cast<proto::Strategy>(index % 3);
    return viewers_[index].actor->deliver(proto::encode(request));
  }

  // Checks the order of a batch's keyframes and that none was unsent.
  void read(Viewer& viewer, const std::vector<Bytes>& batch) {
    ++viewer.batches;
    for (const Bytes& bytes : batch) {
      const auto message = proto::decodeServerMessage(bytes, viewer.keyframes_taken);
      ASSERT_TRUE(message.ok()) << message.error().message;
      const auto* keyframe = std::get_if<proto::KeyframeMessage>(&*message);
      if (!keyframe) continue;
      EXPECT_FALSE(viewer.has_unsent_keyframe);
      EXPECT_EQ(keyframe->header.index, viewer.keyframes + 1);
      EXPECT_EQ(keyframe->header.base_index, viewer.keyframes);
      viewer.keyframes = keyframe->header.index;
      viewer.has_unsent_keyframe = true;
    }
  }

  // Plays the I/O thread: poses from all, batches read at once, and told to be sent if the viewer's link moves. Until
  // `done`.
  bool fly(const std::function<bool()>& done, const std::function<bool(size_t)>& moves) {
    const auto end = std::chrono::steady_clock::now() + kTimeout;
    while (!done() && !testing::Test::HasFailure() && std::chrono::steady_clock::now() < end) {
      for (Viewer& viewer : viewers_) EXPECT_TRUE(viewer.actor->deliver(poseUpdate(viewer.keyframes)).ok());
      const auto item = mailbox_.take(std::chrono::milliseconds(5));
      if (!item) continue;
      EXPECT_FALSE(item->batch.empty()) << item->refusal;
      Viewer& viewer = viewers_[item->viewer];
      read(viewer, item->batch);
      if (viewer.has_unsent_keyframe && !moves(item->viewer)) continue;
      viewer.has_unsent_keyframe = false;
      viewer.actor->sent(viewer.batches);
    }
    return done();
  }

  Metrics metrics_;
  Pool pool_{4, steadyNow};
  Mailbox mailbox_;
  std::unique_ptr<SessionHost> host_;
  std::vector<Viewer> viewers_;

  void TearDown() override {
    pool_.stop();
    viewers_.clear();
  }
};

TEST_F(Host, NoSessionHasTwoUnsentDeltas) {
  for (size_t i = 0; i < 9; ++i) ASSERT_TRUE(requestView(open()).ok());
  const auto everyoneFlew = [this] {
    return std::all_of(viewers_.begin(), viewers_.end(), [](const Viewer& v) { return v.keyframes >= 10; });
  };
  EXPECT_TRUE(fly(everyoneFlew, [](size_t) { return true; }));
}

TEST_F(Host, ASessionIsSilentUntilItsDeltaIsSent) {
  for (size_t i = 0; i < 3; ++i) ASSERT_TRUE(requestView(open()).ok());
  const auto othersFlew = [this] { return viewers_[1].keyframes >= 10 && viewers_[2].keyframes >= 10; };
  EXPECT_TRUE(fly(othersFlew, [](size_t viewer) { return viewer > 0; }));
  EXPECT_EQ(viewers_[0].keyframes, 1u);
}

TEST_F(Host, RefusesOnceAndThenSaysNothing) {
  const size_t viewer = open();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(viewers_[viewer].actor->deliver(Bytes{0xff}).ok());
  const auto item = mailbox_.take();
  ASSERT_TRUE(item.has_value());
  EXPECT_TRUE(item->batch.empty());
  pool_.stop();
  mailbox_.put({99, {}, {}});
  EXPECT_EQ(mailbox_.take()->viewer, 99u);
}

TEST_F(Host, TheInboxIsBounded) {
  const HostLimits limits{.inbox_messages = 2, .viewer_bytes = 1000};
  const size_t viewer = open(limits);
  EXPECT_FALSE(viewers_[viewer].actor->deliver(Bytes(1001)).ok());
  pool_.stop();  // from here on nobody empties it
  EXPECT_TRUE(viewers_[viewer].actor->deliver(Bytes(600)).ok());
  EXPECT_FALSE(viewers_[viewer].actor->deliver(Bytes(600)).ok());
  EXPECT_TRUE(viewers_[viewer].actor->deliver(Bytes(1)).ok());
  EXPECT_FALSE(viewers_[viewer].actor->deliver(Bytes(1)).ok());
}

constexpr size_t kPathPoses = 1000, kPathBytes = kPathPoses * sizeof(proto::Pose);

Bytes longPath() { return proto::encode(proto::Path{.start = {}, .poses = std::vector<proto::Pose>(kPathPoses)}); }

TEST_F(Host, WhatASessionKeepsCountsForItsViewer) {
  const size_t viewer = open({.viewer_bytes = 2 * kPathBytes - 1});
  SessionActor& actor = *viewers_[viewer].actor;
  ASSERT_TRUE(requestView(viewer).ok());
  ASSERT_TRUE(mailbox_.take().has_value());  // the welcome
  actor.sent(1);
  ASSERT_TRUE(actor.deliver(longPath()).ok());
  ASSERT_TRUE(actor.deliver(proto::encode(proto::GroundRequest{1, {{1, 2}}})).ok());
  ASSERT_TRUE(mailbox_.take().has_value());  // so the path has been read
  EXPECT_GE(metrics_.queue_bytes, static_cast<int64_t>(kPathBytes));
  EXPECT_LE(metrics_.queue_bytes, static_cast<int64_t>(kPathBytes) + 1000) << "the messages themselves are gone";
  EXPECT_FALSE(actor.deliver(longPath()).ok()) << "this one and that which is kept";
  EXPECT_TRUE(actor.deliver(poseUpdate(0)).ok()) << "small messages are taken";
  actor.close();
  pool_.stop();
  viewers_.clear();
  EXPECT_EQ(metrics_.queue_bytes, 0);
}

TEST_F(Host, ARequestIsNotAnsweredWhileTooMuchIsHeld) {
  const HostLimits limits;
  const size_t hoarder = open(limits), other = open();
  const auto take = [&](size_t viewer) {
    const auto item = mailbox_.take();
    ASSERT_TRUE(item.has_value());
    EXPECT_EQ(item->viewer, viewer);
    viewers_[viewer].actor->sent(++viewers_[viewer].batches);
  };
  const auto ask = [&](size_t viewer) {
    EXPECT_TRUE(viewers_[viewer].actor->deliver(proto::encode(proto::GroundRequest{1, {{1, 2}}})).ok());
  };
  for (const size_t viewer : {hoarder, other}) {
    ASSERT_TRUE(requestView(viewer).ok());
    take(viewer);
  }
  const auto held = static_cast<int64_t>(limits.viewer_bytes) + 1;
  viewers_[hoarder].actor->bytes()->add(held);  // as the connection counts what is unsent
  for (int i = 0; i < 3; ++i) ask(hoarder);
  ask(other);
  take(other);
  viewers_[hoarder].actor->bytes()->add(-held);
  take(hoarder);
}

// As when there is no memory to tell the viewer that there is none.
TEST_F(Host, ASessionThatCannotEvenRefuseEndsAlone) {
  ASSERT_TRUE(requestView(open()).ok());
  Outlet outlet;
  outlet.send = [](const std::vector<Bytes>&) { throw std::bad_alloc(); };
  outlet.refuse = [](const std::string&) { throw std::bad_alloc(); };
  const auto failing = host_->open(outlet);
  ASSERT_TRUE(failing->deliver(proto::encode(proto::ViewRequest{})).ok());
  EXPECT_TRUE(fly([&] { return failing->hasFailed() && viewers_[0].keyframes >= 3; }, [](size_t) { return true; }));
  EXPECT_TRUE(failing->deliver(poseUpdate(0)).ok()) << "it is not listened to any more";
  EXPECT_GE(metrics_.failures, 2u);
  EXPECT_FALSE(viewers_[0].actor->hasFailed());
  EXPECT_TRUE(fly([&] { return viewers_[0].keyframes >= 10; }, [](size_t) { return true; }));
}

// Where the room of all is taken, by a few who hold much.
TEST(ViewerBytes, WhoHoldsLittleIsTakenInHoweverMuchOthersHold) {
  Metrics metrics;
  const HostLimits limits{.viewer_bytes = 600, .queue_bytes = 1000};
  ViewerBytes first(limits, metrics), second(limits, metrics), third(limits, metrics);
  metrics.sessions = 3;
  first.add(500);
  EXPECT_TRUE(first.checkRoomFor(100).ok());
  EXPECT_FALSE(first.checkRoomFor(101).ok()) << "more than one viewer may hold";
  EXPECT_TRUE(second.checkRoomFor(500).ok());
  EXPECT_FALSE(second.checkRoomFor(501).ok()) << "more than all may hold";
  second.add(500);
  EXPECT_FALSE(first.checkRoomFor(1).ok());
  EXPECT_TRUE(third.checkRoomFor(333).ok());
  EXPECT_FALSE(third.checkRoomFor(334).ok()) << "more than a third";
  EXPECT_EQ(metrics.queue_bytes, 1000);
}

TEST_F(Host, ViewersComeAndGoWhileOthersFly) {
  for (int round = 0; round < 200; ++round) {
    const size_t viewer = open();
    ASSERT_TRUE(requestView(viewer).ok());
    ASSERT_TRUE(viewers_[viewer].actor->deliver(poseUpdate(0)).ok());
    if (round % 2 == 0) { ASSERT_TRUE(mailbox_.take().has_value()); }
    viewers_[viewer].actor->close();
    viewers_[viewer].actor.reset();
  }
  pool_.stop();
  EXPECT_EQ(metrics_.sessions, 0);
  EXPECT_EQ(metrics_.section_nodes, 0);
}

}  // namespace
}  // namespace foreland::server
