// The C interface in sessions with the real server: what foreland.h promises, and how sessions end. Every wait is for a
// condition.
#include "client/c/foreland.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "oracle/crack_checker.h"
#include "server/net/access/token.h"
#include "tests/client/c/host.h"
#include "tests/server/net/live_server.h"

namespace foreland::test {
namespace {

proto::GridShape shape() { return server::welcomeTo(hillWorld()->hierarchy).shape; }

ForelandMapPoint placeAt(const Host& host, const double point[3]) {
  ForelandPlace place = FORELAND_INIT(ForelandPlace);
  EXPECT_EQ(foreland_to_geodetic(*host, point, &place), FORELAND_OK) << foreland_last_error();
  return place.at;
}

TEST(ForelandC, OpensAtOnceAndTellsTheScene) {
  const auto server = serve(testOptions());
  Host host(server->port());
  ForelandScene scene = FORELAND_INIT(ForelandScene);
  host.waitFor(FORELAND_EVENT_SCENE);
  scene = host.scene();
  EXPECT_EQ(scene.samples[0], 129u);
  EXPECT_GT(scene.highest, scene.lowest);
  EXPECT_GT(scene.landmark_count, 0u);
  EXPECT_EQ(scene.is_geographic, 0u);
  EXPECT_TRUE(host.stats().is_connected);
}

TEST(ForelandC, FramesKeepTheTolerance) {
  const auto server = serve(testOptions());
  ForelandOptions options = fastOptions();
  options.tolerance_px = 2;
  Host host(server->port(), options);
  host.waitFor(FORELAND_EVENT_SCENE);
  uint32_t guaranteed = 0;
  host.fly(12, [&](const ForelandFrame& frame) {
    if (!std::isfinite(frame.guaranteed_px)) return;
    EXPECT_LE(frame.guaranteed_px, 8) << "a camera that is hard to predict has four times the tolerance at most";
    EXPECT_GE(frame.weight, 0);
    EXPECT_LE(frame.weight, 1);
    ++guaranteed;
  });
  EXPECT_GT(guaranteed, 0u);
  options.tolerance_px = 0.5;
  ASSERT_EQ(foreland_set_options(*host, &options), FORELAND_OK) << foreland_last_error();
  const auto isAsked = [&] { return host.frame(host.poseAt(0.5, 0.5)).guaranteed_px == 0.5; };
  EXPECT_TRUE(eventually([&] { return isAsked(); }));
}

TEST(ForelandC, UpdatesMakeMeshesWithoutCracks) {
  const auto server = serve(testOptions());
  Host host(server->port());
  host.waitFor(FORELAND_EVENT_SCENE);
  for (int i = 0; i < 10; ++i) {
    host.fly(2);
    const auto report = oracle::findCracks(host.mesh(), shape());
    EXPECT_EQ(report.cracks, 0u) << report.first;
    ASSERT_GT(host.mesh().indices.size(), 0u);
  }
  ASSERT_EQ(foreland_redraw(*host), FORELAND_OK);
  host.forgetMesh();
  host.fly(1);
  const auto report = oracle::findCracks(host.mesh(), shape());
  EXPECT_EQ(report.cracks, 0u) << "after a redraw: " << report.first;
}

TEST(ForelandC, HeightsHeldAgreeWithExactOnes) {
  const auto server = serve(testOptions());
  ForelandOptions options = fastOptions();
  options.tolerance_px = 200;  // of the mesh, which so is not what tells heights
  Host host(server->port(), options);
  host.waitFor(FORELAND_EVENT_SCENE);
  host.fly(5);
  // Near the ground the client asks for what it lacks, so heights there are exact at samples.
  const ForelandScene scene = host.scene();
  const double step_x = (scene.high[0] - scene.low[0]) / (scene.samples[0] - 1);
  const double step_y = (scene.high[1] - scene.low[1]) / (scene.samples[1] - 1);
  const double at[3] = {scene.low[0] + 64 * step_x, scene.low[1] + 60 * step_y, scene.highest + 1};
  const ForelandMapPoint place = placeAt(host, at);
  uint64_t question = 0;
  ASSERT_EQ(foreland_heights(*host, &place, 1, &question), FORELAND_OK) << foreland_last_error();
  const ForelandEvent& told = host.waitFor(FORELAND_EVENT_HEIGHTS);
  ASSERT_EQ(told.question, question);
  ASSERT_EQ(told.count, 1u);
  const double exact = told.heights[0];
  double held = 0;
  const ForelandPose low{{at[0], at[1], exact + 2}, {0, 0, 0, 1}};
  EXPECT_TRUE(eventually([&] {
    host.frame(low);
    return foreland_height_now(*host, &place, &held) == FORELAND_OK && std::abs(held - exact) < 0.06;
  })) << held
      << " m held, " << exact << " m exactly";
  // What moves down is held above it, and a ray meets it.
  const double above[3] = {at[0], at[1], exact + 50}, below[3] = {at[0], at[1], exact - 50}, down[3] = {0, 0, -1};
  double swept[3], met[3];
  ASSERT_EQ(foreland_sweep(*host, above, below, 2, swept), FORELAND_OK);
  EXPECT_GT(swept[2], exact + 1.9);
  ASSERT_EQ(foreland_raycast(*host, above, down, std::numeric_limits<double>::infinity(), met), FORELAND_OK)
      << foreland_last_error();
  EXPECT_NEAR(met[2], exact, 0.06);
  EXPECT_EQ(foreland_raycast(*host, above, down, 10, met), FORELAND_NOTHING);
}

TEST(ForelandC, PlacesGoToTheSceneAndBack) {
  const auto server = serve(testOptions());
  Host host(server->port());
  host.waitFor(FORELAND_EVENT_SCENE);
  for (int i = 0; i < 50; ++i) {
    const double point[3] = {37.5 * i, -21.0 * i, 100.0 + i};
    const ForelandMapPoint place = placeAt(host, point);
    double back[3];
    ASSERT_EQ(foreland_to_scene(*host, &place, back), FORELAND_OK);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(back[axis], point[axis], 1e-6);
  }
}

TEST(ForelandC, AnswersWhatIsSeen) {
  const auto server = serve(testOptions());
  Host host(server->port());
  host.waitFor(FORELAND_EVENT_SCENE);
  const ForelandScene s = host.scene();
  const double x = 0.5 * (s.low[0] + s.high[0]), y = 0.5 * (s.low[1] + s.high[1]);
  const double high[3] = {x, y, s.highest + 500}, deep[3] = {x, y, s.lowest - 500},
               far[3] = {x + 10, y, s.highest + 500};
  const ForelandMapPoint pairs[4] = {placeAt(host, high), placeAt(host, deep), placeAt(host, high), placeAt(host, far)};
  uint64_t question = 0, viewshed = 0;
  ASSERT_EQ(foreland_visible(*host, pairs, 2, nullptr, &question), FORELAND_OK) << foreland_last_error();
  const ForelandEvent sights = host.waitFor(FORELAND_EVENT_SIGHTS);
  ASSERT_EQ(sights.question, question);
  ASSERT_EQ(sights.count, 2u);
  EXPECT_EQ(sights.sights[0].what, FORELAND_HIDDEN_BY_GROUND);
  EXPECT_EQ(sights.sights[1].what, FORELAND_SEEN);
  EXPECT_TRUE(std::isnan(sights.sights[1].hit[0]));

  ForelandViewshedQuestion asked = FORELAND_INIT(ForelandViewshedQuestion);
  asked.from = pairs[0];
  asked.from.height = 20;
  asked.radius = 0.2 * (s.high[0] - s.low[0]);
  asked.cell = asked.radius / 40;
  ASSERT_EQ(foreland_viewshed(*host, &asked, &viewshed), FORELAND_OK) << foreland_last_error();
  for (uint32_t known = 0;;) {
    const ForelandEvent& part = host.waitFor(FORELAND_EVENT_VIEWSHED);
    ASSERT_EQ(part.question, viewshed);
    ASSERT_EQ(part.viewshed->begin, known);
    known += part.viewshed->count;
    if (part.value != 1) continue;
    EXPECT_EQ(known, part.viewshed->columns * part.viewshed->rows);
    break;
  }
}

TEST(ForelandC, RefusesWhatMakesNoSenseAndSaysWhatToDo) {
  const auto server = serve(testOptions());
  ForelandTerrain* none = nullptr;
  const auto says = [](const char* word) { return std::string(foreland_last_error()).find(word) != std::string::npos; };
  EXPECT_EQ(foreland_open("ftp://a", nullptr, &none), FORELAND_ARGUMENT);
  EXPECT_TRUE(says("ws://HOST:PORT")) << foreland_last_error();
  EXPECT_EQ(foreland_open(nullptr, nullptr, &none), FORELAND_ARGUMENT);
  ForelandOptions options{};
  EXPECT_EQ(foreland_open("ws://127.0.0.1:1", &options, &none), FORELAND_ARGUMENT);
  EXPECT_TRUE(says("FORELAND_INIT")) << foreland_last_error();
  options = FORELAND_INIT(ForelandOptions);
  options.tolerance_px = -1;
  EXPECT_EQ(foreland_open("ws://127.0.0.1:1", &options, &none), FORELAND_ARGUMENT);
  EXPECT_TRUE(says("tolerance_px")) << foreland_last_error();
  EXPECT_EQ(none, nullptr);

  Host host(server->port());
  double out[3];
  const double nowhere[3] = {NAN, 0, 0};
  const ForelandMapPoint place{0, 0, 0};
  ForelandTerrain* unopened = nullptr;
  ASSERT_EQ(foreland_open("ws://127.0.0.1:1", nullptr, &unopened), FORELAND_OK);
  EXPECT_EQ(foreland_to_scene(unopened, &place, out), FORELAND_NO_SCENE);
  foreland_close(unopened);
  host.waitFor(FORELAND_EVENT_SCENE);
  EXPECT_EQ(foreland_sweep(*host, nowhere, nowhere, 1, out), FORELAND_ARGUMENT);
  EXPECT_EQ(foreland_to_scene(*host, nullptr, out), FORELAND_ARGUMENT);
  ForelandFrame frame = FORELAND_INIT(ForelandFrame);
  const ForelandPose pose{{0, 0, 0}, {0, 0, 0, 0}};
  EXPECT_EQ(foreland_frame(*host, foreland_now(), &pose, &frame), FORELAND_ARGUMENT);
  ForelandLens lens = FORELAND_INIT(ForelandLens);
  lens.fov_y = 9;
  lens.width_px = lens.height_px = 100;
  EXPECT_EQ(foreland_set_lens(*host, &lens), FORELAND_ARGUMENT);
  uint64_t question = 0;
  EXPECT_EQ(foreland_heights(*host, &place, 0, &question), FORELAND_ARGUMENT);
  host.fly(2);  // the session is none the worse for it
}

// A host that was compiled with a shorter struct.
TEST(ForelandC, WritesNoMoreThanTheHostHasRoomFor) {
  const auto server = serve(testOptions());
  Host host(server->port());
  host.waitFor(FORELAND_EVENT_SCENE);
  ForelandScene scene;
  std::memset(&scene, 0x5a, sizeof scene);
  scene.size = offsetof(ForelandScene, title);
  ASSERT_EQ(foreland_get_scene(*host, &scene), FORELAND_OK);
  EXPECT_EQ(scene.size, offsetof(ForelandScene, title));
  EXPECT_EQ(scene.id, host.scene().id);
  const auto* bytes = reinterpret_cast<const unsigned char*>(&scene);
  for (size_t i = offsetof(ForelandScene, title); i < sizeof scene; ++i) ASSERT_EQ(bytes[i], 0x5a) << i;
}

TEST(ForelandC, ConnectsAnewToAServerThatComesBack) {
  auto server = serve(testOptions());
  const uint16_t port = server->port();
  Host host(port);
  host.waitFor(FORELAND_EVENT_SCENE);
  host.fly(3);
  server.reset();
  const ForelandEvent stall = host.waitFor(FORELAND_EVENT_STALL, [&] { host.frame(host.poseAt(0.5, 0.5)); });
  EXPECT_GT(stall.value, 0);
  EXPECT_GT(std::string(stall.message).size(), 0u);
  uint64_t question = 0;
  const ForelandMapPoint place = placeAt(host, host.poseAt(0.5, 0.5).eye);
  ASSERT_EQ(foreland_heights(*host, &place, 1, &question), FORELAND_OK);
  const ForelandMapPoint pair[2] = {place, place};
  uint64_t lost = 0;
  ASSERT_EQ(foreland_visible(*host, pair, 1, nullptr, &lost), FORELAND_OK);
  EXPECT_EQ(host.waitFor(FORELAND_EVENT_UNANSWERED).question, lost);
  ServeOptions options = testOptions();
  options.listen.port = port;
  server = serve(options);
  host.waitFor(FORELAND_EVENT_SCENE, [&] { host.frame(host.poseAt(0.5, 0.5)); });
  EXPECT_EQ(host.waitFor(FORELAND_EVENT_HEIGHTS).question, question);
  host.fly(3);
  const auto report = oracle::findCracks(host.mesh(), shape());
  EXPECT_EQ(report.cracks, 0u) << report.first;
}

TEST(ForelandC, ClosesInMidFlight) {
  const auto server = serve(testOptions());
  for (int i = 0; i < 40; ++i) {
    Host host(server->port());
    if (i % 4 == 0) continue;  // while it connects
    host.waitFor(FORELAND_EVENT_SCENE);
    if (i % 4 == 1) continue;
    host.fly(i % 5);
    uint64_t question = 0;
    const ForelandMapPoint place = placeAt(host, host.poseAt(0.5, 0.5).eye);
    EXPECT_EQ(foreland_heights(*host, &place, 1, &question), FORELAND_OK);
    if (i % 4 == 3) { EXPECT_EQ(foreland_reconnect(*host), FORELAND_OK); }
  }
}

// It takes connections, and says nothing on them.
class SilentServer {
 public:
  SilentServer() : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(fd_, 16), 0);
    EXPECT_EQ(::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  ~SilentServer() { ::close(fd_); }
  SilentServer(const SilentServer&) = delete;
  SilentServer& operator=(const SilentServer&) = delete;
  uint16_t port() const { return port_; }
  // Until somebody connects.
  void accept() const { ::close(::accept(fd_, nullptr, nullptr)); }

 private:
  int fd_;
  uint16_t port_ = 0;
};

TEST(ForelandC, ClosesWhileNobodyAnswers) {
  Host nobody(1);
  EXPECT_NE(std::string(nobody.waitFor(FORELAND_EVENT_STALL).message).find("is `foreland serve` running there?"),
            std::string::npos);
  const SilentServer silent;
  for (int i = 0; i < 3; ++i) {
    const Host host(silent.port());
    silent.accept();
  }
}

TEST(ForelandC, SaysWhenATokenIsWantedAndTakesANewOne) {
  const std::string secret(48, 's');
  ServeOptions options = testOptions();
  options.gate.token_secret = secret;
  const auto server = serve(options);
  Host host(server->port());
  const ForelandEvent& stall = host.waitFor(FORELAND_EVENT_STALL);
  EXPECT_NE(std::string(stall.message).find("foreland_set_token"), std::string::npos) << stall.message;
  const std::string token = server::signToken({.name = "a", .expires_s = 4'000'000'000}, secret);
  EXPECT_EQ(foreland_set_token(*host, token.c_str()), FORELAND_OK);
  ASSERT_EQ(foreland_reconnect(*host), FORELAND_OK);
  host.waitFor(FORELAND_EVENT_SCENE);
}

}  // namespace
}  // namespace foreland::test
