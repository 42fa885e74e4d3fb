// A server that is full, overloaded or about to stop: whom it takes, what it says to proxies and operators, and how its
// viewers leave it.
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/net/live_server.h"

namespace foreland::server {
namespace {

using test::eventually;
using test::httpGet;
using test::LiveViewer;
using test::metric;
using test::Opcode;
using test::poseAt;
using test::requestAll;
using test::roughWorld;
using test::serve;
using test::Socket;
using test::testOptions;
using test::WebSocketClient;

TEST(FullServer, AdmitsNoMoreThanItsLimit) {
  ServeOptions options = testOptions();
  options.max_connections = 1;
  const auto server = serve(options);
  WebSocketClient first(server->port());
  ASSERT_TRUE(first.isOpen());
  const std::string reply = WebSocketClient(server->port()).reply();
  EXPECT_TRUE(reply.starts_with("HTTP/1.1 503")) << reply;
  EXPECT_NE(reply.find("Retry-After: "), std::string::npos);
  EXPECT_TRUE(httpGet(server->port(), "/").starts_with("HTTP/1.1 503"));
  EXPECT_TRUE(httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200")) << "operators are answered";
  EXPECT_TRUE(httpGet(server->port(), "/readyz").starts_with("HTTP/1.1 503"));
  EXPECT_EQ(metric(server->port(), "refusals_total{reason=\"full\"}"), 2);
}

TEST(FullServer, AdmitsNoMoreFromAnAddressThanItsLimit) {
  ServeOptions options = testOptions();
  options.max_connections_per_address = 2;
  const auto server = serve(options);
  {
    WebSocketClient first(server->port()), second(server->port());
    ASSERT_TRUE(first.isOpen() && second.isOpen());
    EXPECT_TRUE(Socket(server->port()).receiveToEnd().starts_with("HTTP/1.1 503"));
  }
  EXPECT_TRUE(eventually([&] { return httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200"); }));
  EXPECT_TRUE(eventually([&] { return metric(server->port(), "connections") == 1; })) << "that of the question";
  EXPECT_GE(metric(server->port(), "refusals_total{reason=\"address\"}"), 1);
}

// A server behind a proxy that it trusts, one connection for each address.
class BehindAProxy {
 public:
  BehindAProxy() {
    ServeOptions options = testOptions();
    options.max_connections_per_address = 1;
    options.gate.trusted_proxies = {"127.0.0.1"};
    server_ = serve(options);
  }
  // Asks with the proxy's lines of the header; the connection stays.
  Socket ask(const std::string& lines) const {
    Socket socket(server_->port());
    socket.send("GET /livez HTTP/1.1\r\nHost: a\r\n" + lines + "\r\n");
    return socket;
  }

 private:
  std::unique_ptr<Server> server_;
};

std::string statusOf(Socket& socket) { return socket.receiveSome(12).substr(9); }

// Who makes up a first line of the header is not believed: the proxy's own is the last one.
TEST(FullServer, CountsForTheAddressThatItsProxyNames) {
  const BehindAProxy server;
  Socket first = server.ask("X-Forwarded-For: 192.0.2.1\r\nX-Forwarded-For: 198.51.100.7\r\n");
  EXPECT_EQ(statusOf(first), "200");
  Socket same = server.ask("X-Forwarded-For: 192.0.2.2\r\nX-Forwarded-For: 198.51.100.7\r\n");
  EXPECT_EQ(statusOf(same), "503");
  Socket victim = server.ask("X-Forwarded-For: 192.0.2.1\r\n");
  EXPECT_EQ(statusOf(victim), "200") << "the name that the first made up";
}

// Of one client each has a port of its own; X-Forwarded-For is believed before Forwarded.
TEST(FullServer, CountsForAnAddressWhateverItsPorts) {
  const BehindAProxy server;
  Socket first = server.ask("X-Forwarded-For: 10.0.0.1:9001\r\nForwarded: for=192.0.2.1\r\n");
  EXPECT_EQ(statusOf(first), "200");
  Socket same = server.ask("X-Forwarded-For: 10.0.0.1:9002\r\nForwarded: for=192.0.2.2\r\n");
  EXPECT_EQ(statusOf(same), "503");
  Socket other = server.ask("Forwarded: for=\"[2001:db8::1]:9001\";proto=https\r\n");
  EXPECT_EQ(statusOf(other), "200");
  Socket neighbour = server.ask("Forwarded: for=\"[2001:db8::2]:9002\";proto=https\r\n");
  EXPECT_EQ(statusOf(neighbour), "503") << "of the same network";
}

// Whoever holds connections beyond the limit and asks for nothing leaves room for operators for a time only.
TEST(FullServer, ClosesWhateverComesBeyondItsReserve) {
  ServeOptions options = testOptions();
  options.max_connections = 1;
  const auto server = serve(options);
  std::deque<Socket> mute;
  for (int i = 0; i < 17; ++i) mute.emplace_back(server->port());
  EXPECT_TRUE(Socket(server->port()).receiveToEnd().starts_with("HTTP/1.1 503"));
  mute.clear();
  EXPECT_TRUE(eventually([&] { return httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200"); }));
}

TEST(FullServer, IsReadyUntilItIsFull) {
  ServeOptions options = testOptions();
  const auto server = serve(options);
  for (const char* path : {"/livez", "/readyz", "/healthz"})
    EXPECT_TRUE(httpGet(server->port(), path).starts_with("HTTP/1.1 200")) << path;
}

// Viewers who want all that there is, and are elsewhere all the time, of a server with one worker. While they fly it is
// not ready for more, though it takes them; when they have left it is.
TEST(FullServer, IsNotReadyWhileItIsOverloaded) {
  ServeOptions options = testOptions();
  options.threads = 1;
  const auto server = serve(options, roughWorld());
  const uint16_t port = server->port();
  const auto isReady = [&] { return httpGet(port, "/readyz").starts_with("HTTP/1.1 200"); };
  ASSERT_TRUE(isReady());
  {
    std::vector<std::jthread> hogs;
    for (int i = 0; i < 6; ++i)
      hogs.emplace_back([port](const std::stop_token& stop) {
        LiveViewer hog(port, requestAll());
        proto::Pose pose = poseAt({});
        while (hog.advance(pose) && !stop.stop_requested()) pose.eye.x = 3000 - pose.eye.x;
      });
    EXPECT_TRUE(eventually([&] { return httpGet(port, "/readyz").find("overloaded") != std::string::npos; }));
    EXPECT_TRUE(httpGet(port, "/livez").starts_with("HTTP/1.1 200"));
    EXPECT_TRUE(WebSocketClient(port).isOpen()) << "who was led here before is served";
  }
  EXPECT_TRUE(eventually(isReady));
}

TEST(StoppingServer, StopsWithViewersConnected) {
  auto server = serve(testOptions());
  const uint16_t port = server->port();
  LiveViewer polite(port), another(port);
  WebSocketClient deaf(port);  // never answers the close frame
  EXPECT_TRUE(eventually(
      [&] { return !polite.advance() || !another.advance() || (polite.keyframes() > 0 && another.keyframes() > 0); }));
  server->stop();
  EXPECT_EQ(polite.socket().receiveClose(), 1001);
  EXPECT_EQ(deaf.receiveClose(), 1001);
  server.reset();
  EXPECT_FALSE(Socket(port).isConnected());
}

// Each at a keyframe; the server meanwhile takes no other, and says so to proxies.
TEST(StoppingServer, HandsItsViewersOver) {
  const auto server = serve(testOptions());
  const uint16_t port = server->port();
  LiveViewer first(port), second(port);
  ASSERT_TRUE(eventually(
      [&] { return !first.advance() || !second.advance() || (first.keyframes() > 0 && second.keyframes() > 0); }));
  WebSocketClient deaf(port);  // never answers the close frame
  ASSERT_TRUE(deaf.isOpen());
  std::jthread drain([&] { server->drain(Duration::seconds(3600)); });
  const auto isAnswered = [&](const char* path, const char* status) {
    return httpGet(port, path).starts_with(std::string("HTTP/1.1 ") + status);
  };
  EXPECT_TRUE(eventually([&] { return isAnswered("/readyz", "503"); }));
  EXPECT_TRUE(isAnswered("/livez", "200"));
  EXPECT_TRUE(WebSocketClient(port).reply().starts_with("HTTP/1.1 503"));
  for (LiveViewer* viewer : {&first, &second}) {
    EXPECT_TRUE(eventually([&] { return !viewer->advance(); }));
    EXPECT_EQ(viewer->closeCode(), 1012);
    viewer->socket().sendFrame(Opcode::kClose, std::string("\x03\xf4", 2));
  }
  EXPECT_EQ(deaf.receiveClose(), 1012);
  EXPECT_TRUE(eventually([&] { return metric(port, "handed_over_total") == 3; }));
  drain.join();
  server->stop();
}

// It would wait for an hour. Whoever reads leaves at a keyframe meanwhile.
TEST(StoppingServer, HandsViewersOverBesideOneThatNeverReads) {
  ServeOptions options = testOptions();
  options.send_buffer_bytes = 4096;
  options.idle_timeout = Duration::seconds(3600);
  const auto server = serve(options, roughWorld());
  WebSocketClient deaf(server->port(), 4096);
  deaf.send(proto::encode(requestAll()));
  deaf.send(proto::encode(proto::PoseUpdate{{steadyNow(), poseAt(steadyNow())}, 0, {}}));
  LiveViewer reader(server->port());
  ASSERT_TRUE(eventually([&] { return !reader.advance() || reader.keyframes() > 0; }));
  ASSERT_TRUE(eventually([&] { return metric(server->port(), "keyframes_total") > reader.keyframes(); }));
  std::jthread drain([&] { server->drain(Duration::seconds(3600)); });
  EXPECT_TRUE(eventually([&] { return !reader.advance(); }));
  EXPECT_EQ(reader.closeCode(), 1012);
  drain.join();
  EXPECT_EQ(metric(server->port(), "sessions"), 0);
  server->stop();
}

// Would wait for an hour if the answer did not end it.
TEST(StoppingServer, StopsAsSoonAsItsViewersAnswer) {
  ServeOptions options = testOptions();
  options.stop_grace = Duration::seconds(3600);
  const auto server = serve(options);
  auto client = std::make_unique<WebSocketClient>(server->port());
  ASSERT_TRUE(eventually([&] { return metric(server->port(), "sessions") == 1; }));
  std::jthread answer([&] {
    EXPECT_EQ(client->receiveClose(), 1001);
    client->sendFrame(Opcode::kClose, std::string("\x03\xe9", 2));
    EXPECT_EQ(client->socket().receiveToEnd(), "");  // the server closes first (RFC 6455, section 7.1.1)
    client.reset();
  });
  server->stop();
}

}  // namespace
}  // namespace foreland::server
