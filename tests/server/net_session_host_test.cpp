// Sessions on several workers, without sockets: the test is the I/O thread. The laws: a session never has two unsent
// deltas, its messages come in order, and what it computes does not depend on the threads.
#include "server/net/session_host.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "proto/message.h"
#include "server/net/steady_clock.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

constexpr std::chrono::seconds kPatience{20};

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
  };

  void put(Item item) {
    const std::lock_guard lock(mutex_);
    items_.push_back(std::move(item));
    changed_.notify_one();
  }
  // Nothing when patience ends.
  std::optional<Item> take() {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, kPatience, [this] { return !items_.empty(); })) return std::nullopt;
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
      host_ = std::make_unique<SessionHost>(hillWorld(), SessionOptions{}, limits, pool_, steadyNow, metrics_);
    const size_t index = viewers_.size();
    viewers_.push_back({.actor = host_->open({.send =
                                                  [this, index](std::vector<Bytes> b) {
                                                    mailbox_.put({index, std::move(b)});
                                                  },
                                              .refuse =
                                                  [this, index](std::string) {
                                                    mailbox_.put({index, {}});
                                                  }})});
    return index;
  }

  Status requestView(size_t index) {
    proto::ViewRequest request;
    request.keyframe_interval = Duration::milliseconds(10);
    request.strategy = static_cast<proto::Strategy>(index % 3);
    return viewers_[index].actor->deliver(proto::encode(request));
  }

  // Checks the order of a batch's keyframes and that none was unsent.
  void read(Viewer& viewer, const std::vector<Bytes>& batch) {
    ++viewer.batches;
    for (const Bytes& bytes : batch) {
      const auto message = proto::decodeServerMessage(bytes);
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
  for (size_t i = 0; i < 9; ++i) {
    ASSERT_TRUE(requestView(open()).ok());
    ASSERT_TRUE(viewers_[i].actor->deliver(poseUpdate(0)).ok());
  }
  for (int round = 0; round < 500; ++round) {
    const auto item = mailbox_.take();
    ASSERT_TRUE(item.has_value()) << "the sessions fell silent";
    ASSERT_FALSE(item->batch.empty()) << "a session was refused";
    Viewer& viewer = viewers_[item->viewer];
    read(viewer, item->batch);
    // Poses while the delta is unsent must not bring another one forth.
    ASSERT_TRUE(viewer.actor->deliver(poseUpdate(viewer.keyframes)).ok());
    viewer.has_unsent_keyframe = false;
    viewer.actor->sent(viewer.batches);
    for (Viewer& other : viewers_) ASSERT_TRUE(other.actor->deliver(poseUpdate(other.keyframes)).ok());
  }
  for (const Viewer& viewer : viewers_) EXPECT_GT(viewer.keyframes, 0u);
}

TEST_F(Host, ASessionIsSilentUntilItsDeltaIsSent) {
  const size_t stuck = open(), moving = open();
  for (const size_t i : {stuck, moving}) {
    ASSERT_TRUE(requestView(i).ok());
    ASSERT_TRUE(viewers_[i].actor->deliver(poseUpdate(0)).ok());
  }
  while (viewers_[moving].keyframes < 20) {
    const auto item = mailbox_.take();
    ASSERT_TRUE(item.has_value());
    Viewer& viewer = viewers_[item->viewer];
    read(viewer, item->batch);
    if (item->viewer == stuck && viewer.has_unsent_keyframe) continue;
    viewer.has_unsent_keyframe = false;
    viewer.actor->sent(viewer.batches);
    for (Viewer& any : viewers_) ASSERT_TRUE(any.actor->deliver(poseUpdate(any.keyframes)).ok());
  }
  EXPECT_LE(viewers_[stuck].keyframes, 1u);
}

TEST_F(Host, RefusesOnceAndThenSaysNothing) {
  const size_t viewer = open();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(viewers_[viewer].actor->deliver(Bytes{0xff}).ok());
  const auto item = mailbox_.take();
  ASSERT_TRUE(item.has_value());
  EXPECT_TRUE(item->batch.empty());
  pool_.stop();
  mailbox_.put({99, {}});
  EXPECT_EQ(mailbox_.take()->viewer, 99u);
}

TEST_F(Host, TheInboxIsBounded) {
  const HostLimits limits{.inbox_messages = 2, .inbox_bytes = 100};
  const size_t viewer = open(limits);
  EXPECT_FALSE(viewers_[viewer].actor->deliver(Bytes(101)).ok());
  pool_.stop();  // from here on nobody empties it
  EXPECT_TRUE(viewers_[viewer].actor->deliver(Bytes(60)).ok());
  EXPECT_FALSE(viewers_[viewer].actor->deliver(Bytes(60)).ok());
  EXPECT_TRUE(viewers_[viewer].actor->deliver(Bytes(1)).ok());
  EXPECT_FALSE(viewers_[viewer].actor->deliver(Bytes(1)).ok());
}

TEST_F(Host, ViewersComeAndGoWhileOthersFly) {
  for (int round = 0; round < 200; ++round) {
    const size_t viewer = open();
    ASSERT_TRUE(requestView(viewer).ok());
    ASSERT_TRUE(viewers_[viewer].actor->deliver(poseUpdate(0)).ok());
    if (round % 2 == 0) {
      ASSERT_TRUE(mailbox_.take().has_value());
    }
    viewers_[viewer].actor->close();
    viewers_[viewer].actor.reset();
  }
  pool_.stop();
  EXPECT_EQ(metrics_.sessions, 0);
  EXPECT_EQ(metrics_.section_nodes, 0);
}

}  // namespace
}  // namespace foreland::server
