// Attacks on the real program over loopback, each bounded in count and time, while an honest viewer flies. The figures
// are what the honest viewer has of it: keyframes a second, the longest gap between two, and how far the server's
// memory grew. They are printed. A test may run beside others, so what it asserts are counts, and memory by budgets;
// the figures are held against their bars on a quiet machine, where their time is given:
//
//   FORELAND_HOSTILE_SECONDS=10 FORELAND_HOSTILE_SCENE=SCENE.fls programs_test --gtest_filter=Hostile*
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "client/viewer.h"
#include "server/view/tour.h"
#include "tests/server/net/client.h"
#include "tests/support/program.h"
#include "tests/support/sanitized.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

Time now() {
  return {std::chrono::duration_cast<std::chrono::microseconds>(SteadyClock::now().time_since_epoch()).count()};
}

// The bars for a quiet machine with two processors, at five keyframes a second.
constexpr double kMinKeyframesPerSecond = 4.5, kLongestGap_ms = 600;
// Beyond what the server says that it holds for its viewers, which is bounded by its budget for all of them.
constexpr int64_t kMaxGrown_kib = 64 << 10, kQueues_kib = 256 << 10;

const char* givenSeconds() { return std::getenv("FORELAND_HOSTILE_SECONDS"); }

Duration attackTime() { return Duration::seconds(givenSeconds() ? std::atof(givenSeconds()) : 1.5); }

proto::ViewRequest request(uint32_t width, uint32_t height, double tau_px, int64_t keyframe_ms) {
  proto::ViewRequest request;
  request.lens.width_px = width;
  request.lens.height_px = height;
  request.tau_px = tau_px;
  request.keyframe_interval = Duration::milliseconds(keyframe_ms);
  request.strategy = proto::Strategy::kPredict;
  request.predictor = proto::Predictor::kConstantVelocity;
  return request;
}

// A viewer over a real socket, flown along a path from the moment it is made.
class Flyer {
 public:
  Flyer(uint16_t port, const proto::ViewRequest& request, const proto::Path& path)
      : socket_(port), viewer_(request), path_(path) {
    path_.start = now();
  }
  // Sends what is due, then takes what comes within `wait`. False when the server has closed.
  bool advance(std::chrono::milliseconds wait) {
    viewer_.frame(now(), path_.at(now()));
    for (Bytes message; viewer_.takeOutgoing(message);) socket_.send(message);
    if (!socket_.socket().isReadable(wait)) return true;
    const auto message = socket_.receive();
    return message && message->opcode != Opcode::kClose && viewer_.receive(message->bytes(), now()).ok();
  }
  uint32_t keyframes() const { return viewer_.statistics().keyframes; }

 private:
  WebSocketClient socket_;
  client::Viewer viewer_;
  proto::Path path_;
};

struct Figures {
  double keyframes_per_s = 0, longest_gap_ms = 0;
  uint32_t keyframes = 0;
  int64_t grown_kib = 0, held_kib = 0;
  bool stayed = true;
};

void expectWithinBars(const Figures& figures) {
  EXPECT_TRUE(figures.stayed) << "the honest viewer was disconnected";
  EXPECT_GT(figures.keyframes, 0u);
  EXPECT_LE(figures.held_kib, kQueues_kib + kMaxGrown_kib);
  if (!kIsSanitized) { EXPECT_LE(figures.grown_kib, kQueues_kib + kMaxGrown_kib); }
  if (!givenSeconds()) return;
  EXPECT_GE(figures.keyframes_per_s, kMinKeyframesPerSecond);
  EXPECT_LE(figures.longest_gap_ms, kLongestGap_ms);
  EXPECT_LE(figures.grown_kib - figures.held_kib, kMaxGrown_kib);
}

class Hostile : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const char* scene = std::getenv("FORELAND_HOSTILE_SCENE");
    scene_file_ = scene ? scene : (*folder_ / "land.fls").string();
    FormulaSource source(513, 513, hills(8));
    if (!scene) { ASSERT_TRUE(terrain::buildScene(source, {scene_file_, 0.1, 1}).ok()); }
    scene_ = terrain::Scene::open(scene_file_).value();
  }
  static void TearDownTestSuite() {
    scene_.reset();
    delete folder_;
  }

  void SetUp() override {
    server_.emplace("serve", std::vector<std::string>{scene_file_, "--listen", "127.0.0.1:0", "--threads", "2",
                                                      "--log-level", "off"});
    port_ = portOf(server_->readLine());
  }

  proto::Path tour(const char* name) const { return server::planTour(*scene_, name, 600).value(); }

  // However slow a machine is, a keyframe comes within this time.
  static bool isPatient(Time begin) { return now() < begin + Duration::seconds(kTimeout.count()); }

  // Flies an honest viewer, alone at first and then while `attackers` threads attack; each is called again and again
  // until the time is over.
  Figures under(size_t attackers, const std::function<void(size_t attacker)>& attack) {
    Flyer honest(port_, request(1920, 1080, 1, 200), tour("survey"));
    Figures figures;
    const auto fly = [&](Duration time, bool counts) {
      const Time begin = now();
      const uint32_t before = honest.keyframes();
      Time last = begin;
      const auto goesOn = [&] { return now() < begin + time || (honest.keyframes() == before && isPatient(begin)); };
      while (figures.stayed && goesOn()) {
        const uint32_t keyframes = honest.keyframes();
        figures.stayed = honest.advance(std::chrono::milliseconds(8));
        if (honest.keyframes() == keyframes && figures.stayed && goesOn()) continue;
        if (counts) figures.longest_gap_ms = std::max(figures.longest_gap_ms, (now() - last).toMilliseconds());
        last = now();
      }
      if (!counts) return;
      figures.keyframes = honest.keyframes() - before;
      figures.keyframes_per_s = figures.keyframes / (now() - begin).toSeconds();
    };
    fly(Duration::milliseconds(700), false);
    const int64_t before_kib = server_->kibibytes("VmRSS");
    std::atomic<bool> is_over = false;
    std::vector<std::jthread> threads;
    for (size_t i = 0; i < attackers; ++i)
      threads.emplace_back([&, i] {
        while (!is_over) attack(i);
      });
    fly(attackTime(), true);
    figures.grown_kib = server_->kibibytes("VmRSS") - before_kib;
    figures.held_kib = static_cast<int64_t>(metric(port_, "queue_bytes") / 1024);
    is_over = true;
    threads.clear();
    std::printf("FIGURES %-18s %5.2f keyframes/s, longest gap %5.0f ms, memory %+.1f MiB, of which %.1f are queues\n",
                testing::UnitTest::GetInstance()->current_test_info()->name(), figures.keyframes_per_s,
                figures.longest_gap_ms, static_cast<double>(figures.grown_kib) / 1024,
                static_cast<double>(figures.held_kib) / 1024);
    expectWithinBars(figures);
    EXPECT_TRUE(httpGet(port_, "/livez").starts_with("HTTP/1.1 200"));
    EXPECT_EQ(metric(port_, "failures_total"), 0);
    return figures;
  }

  // Once everybody has left.
  void expectNothingIsLeft() const {
    EXPECT_TRUE(eventually([&] { return metric(port_, "sessions") == 0; }));
    EXPECT_TRUE(eventually([&] { return metric(port_, "queue_bytes") == 0; }));
    EXPECT_EQ(metric(port_, "section_nodes"), 0);
  }

  static inline TemporaryFolder* folder_;
  static inline std::string scene_file_;
  static inline std::shared_ptr<const terrain::Scene> scene_;
  std::optional<Program> server_;
  uint16_t port_ = 0;
};

TEST_F(Hostile, ToursAndHangUp) {
  under(2, [&](size_t) {
    WebSocketClient client(port_);
    client.send(proto::encode(request(640, 360, 1, 200)));
    for (uint32_t i = 0; i < 12; ++i) client.send(proto::encode(proto::TourRequest{i, "canyon", 3600}));
    (void)client.socket().isReadable(std::chrono::milliseconds(50));
  });
  expectNothingIsLeft();
}

// A tour is larger than the buffers of both systems, so a second one would not be computed. Of 60 that wait one is.
TEST_F(Hostile, ToursUnread) {
  std::vector<std::unique_ptr<WebSocketClient>> clients(5);
  std::atomic<int> connected = 0;
  Socket silent(port_);
  under(5, [&](size_t i) {
    clients[i] = std::make_unique<WebSocketClient>(port_, 4096);
    ++connected;
    clients[i]->send(proto::encode(request(640, 360, 1, 200)));
    for (uint32_t k = 0; k < 60; ++k) clients[i]->send(proto::encode(proto::TourRequest{k, "survey", 3600}));
    for (int k = 0; k < 20; ++k) {
      clients[i]->send(proto::encode(request(640, 360, 1, 200)));
      (void)silent.isReadable(std::chrono::milliseconds(10));
    }
  });
  EXPECT_LE(metric(port_, "replies_total"), connected.load());
  for (const std::string reason : {"queues", "message"})
    EXPECT_EQ(metric(port_, "refusals_total{reason=\"" + reason + "\"}"), 0) << reason;
  clients.clear();
  expectNothingIsLeft();
}

// Viewsheds as large as may be, and as many lines as may be in a request, again and again.
TEST_F(Hostile, AskWhatIsSeenWithoutEnd) {
  std::atomic<size_t> told = 0;
  under(4, [&](size_t i) {
    WebSocketClient client(port_);
    client.send(proto::encode(request(640, 360, 1, 200)));
    proto::SightRequest pairs;
    for (size_t k = 0; k < 2 * proto::kMaxSightPairs; ++k) pairs.ends.push_back({(k * 37) % 512, (k * 91) % 512, 2});
    client.send(proto::encode(proto::ViewshedRequest{1, {200, 200.0 + i}, 2, 0, 1e5, 3}));
    for (int k = 0; k < 12; ++k) client.send(proto::encode(pairs));
    const Time begin = now();
    while (now() < begin + Duration::milliseconds(400)) {
      if (!client.socket().isReadable(std::chrono::milliseconds(50))) continue;
      if (!client.receive()) break;
      ++told;
    }
  });
  EXPECT_GT(told, 0u);
  expectNothingIsLeft();
}

TEST_F(Hostile, AskWhatIsSeenWithNumbersThatMakeNoSense) {
  const auto refusalOf = [&](const Bytes& asked) {
    WebSocketClient client(port_);
    client.send(proto::encode(request(640, 360, 1, 200)));
    client.send(asked);
    while (const auto message = client.receive()) {
      const auto reply = proto::decodeServerMessage(message->bytes());
      if (reply.ok() && std::holds_alternative<proto::Refusal>(*reply)) return std::get<proto::Refusal>(*reply).message;
    }
    return std::string();
  };
  using proto::ViewshedRequest;
  const std::vector<glm::dvec3> many(2 * (proto::kMaxSightPairs + 1));
  EXPECT_NE(refusalOf(proto::encode(proto::SightRequest{1, many})).find("1 to 4096 pairs"), std::string::npos);
  EXPECT_NE(refusalOf(proto::encode(proto::SightRequest{1, {{NAN, 1, 1}, {2, 2, 2}}})).find("not finite"),
            std::string::npos);
  EXPECT_NE(refusalOf(proto::encode(ViewshedRequest{1, {9, 9}, 2, 0, 1e300, 30})).find("radius"), std::string::npos);
  EXPECT_NE(refusalOf(proto::encode(ViewshedRequest{1, {9, 9}, 2, 0, 1000, 0})).find("cells"), std::string::npos);
  EXPECT_NE(refusalOf(proto::encode(ViewshedRequest{1, {9, NAN}, 2, 0, 1000, 9})).find("observer"), std::string::npos);
  EXPECT_TRUE(httpGet(port_, "/livez").starts_with("HTTP/1.1 200"));
  expectNothingIsLeft();
}

// Takes keyframes without looking into them, and so costs the server far more than itself.
class Hog {
 public:
  Hog(uint16_t port, const proto::Path& path) : socket_(port), path_(path) {
    path_.start = now();
    socket_.send(proto::encode(request(3840, 2160, 0.2, 20)));
  }
  bool advance() {
    proto::PoseUpdate update{{now(), path_.at(now())}, keyframes_, now()};
    if (!socket_.send(proto::encode(update))) return false;
    if (!socket_.socket().isReadable(std::chrono::milliseconds(20))) return true;
    const auto message = socket_.receive();
    if (!message || message->opcode == Opcode::kClose) return false;
    const auto kind = static_cast<uint8_t>(message->payload[0]);
    keyframes_ += kind == 3 || (kind & 7) == 6;
    return true;
  }
  uint32_t keyframes() const { return keyframes_; }

 private:
  WebSocketClient socket_;
  proto::Path path_;
  uint32_t keyframes_ = 0;
};

TEST_F(Hostile, ProcessorHogs) {
  const proto::Path path = tour("canyon");
  std::vector<std::unique_ptr<Hog>> hogs(4);
  under(4, [&](size_t i) {
    if (!hogs[i]) hogs[i] = std::make_unique<Hog>(port_, path);
    if (!hogs[i]->advance()) hogs[i].reset();
  });
  for (const auto& hog : hogs) {
    EXPECT_TRUE(eventually([&] { return !hog || hog->keyframes() > 0 || !hog->advance(); }));
    EXPECT_TRUE(hog && hog->keyframes() > 0) << "nobody is shut out";
  }
  hogs.clear();
  expectNothingIsLeft();
}

TEST_F(Hostile, HalfOpen) {
  std::vector<Socket> sockets;
  under(1, [&](size_t) {
    for (int i = 0; i < 100 && sockets.size() < 1024; ++i) {
      sockets.emplace_back(port_);
      sockets.back().send("GET /fly HTTP/1.1\r\nHost");
    }
    (void)sockets.back().isReadable(std::chrono::milliseconds(20));
  });
  EXPECT_LE(metric(port_, "connections"), 1024 + 16);
  sockets.clear();
  expectNothingIsLeft();
}

TEST_F(Hostile, TrickledFrames) {
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  under(1, [&](size_t) {
    if (clients.size() < 60) {
      clients.push_back(std::make_unique<WebSocketClient>(port_));
      clients.back()->socket().send(WebSocketClient::frameHead(Opcode::kBinary, 16u << 20));
    }
    const std::string some(8192, '\x01');
    for (auto& client : clients) client->socket().send(some);
    (void)clients.back()->socket().isReadable(std::chrono::milliseconds(2));
  });
  clients.clear();
  expectNothingIsLeft();
}

TEST_F(Hostile, RepeatedResumes) {
  under(3, [&](size_t i) {
    WebSocketClient client(port_);
    client.send(proto::encode(request(1920, 1080, 0.2, 200)));
    proto::Resume resume{scene_->id(), 7, now(), 0, Bytes(1u << 20, static_cast<uint8_t>(i * 127))};
    client.send(proto::encode(resume));
    client.send(proto::encode(resume));
    (void)client.socket().isReadable(std::chrono::milliseconds(20));
  });
  EXPECT_EQ(metric(port_, "resumed_total"), 0) << "from noise";
  expectNothingIsLeft();
}

}  // namespace
}  // namespace foreland::test
