// The server through real sockets on the loopback: what a viewer gets, and what happens to whoever misbehaves.
#include "server/net/server.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "client/viewer.h"
#include "proto/message/message.h"
#include "server/net/steady_clock.h"
#include "tests/server/net/client.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

using test::eventually;
using test::httpGet;
using test::metric;
using test::Opcode;
using test::Socket;
using test::WebSocketClient;

std::shared_ptr<const World> hillWorld() {
  static const auto world = std::make_shared<const World>(test::makeScene(129, 129, 7));
  return world;
}

ServeOptions testOptions() {
  ServeOptions options;
  options.listen.port = 0;
  options.session.keyframe_interval = Duration::milliseconds(20);
  return options;
}

std::unique_ptr<Server> serve(const ServeOptions& options, std::shared_ptr<const World> world = hillWorld()) {
  auto server = Server::listen(std::move(world), options, steadyNow);
  EXPECT_TRUE(server.ok()) << (server.ok() ? "" : server.error().message);
  return server.ok() ? std::move(*server) : nullptr;
}

proto::ViewRequest requestView() {
  proto::ViewRequest request;
  request.keyframe_interval = Duration::milliseconds(20);
  return request;
}

// Of which a view at all detail is more than the buffers of both systems hold.
std::shared_ptr<const World> roughWorld() {
  return std::make_shared<const World>(test::makeScene(257, 257, test::noise(3, 500)));
}

proto::ViewRequest requestAll() {
  proto::ViewRequest request = requestView();
  request.tau_px = 0.01;
  return request;
}

proto::Pose poseAt(Time now) {
  proto::Pose pose;
  pose.eye = {100 * std::sin(now.toSeconds()), 50, 1500};
  pose.orientation = proto::lookAlong({0.3, 0.6, -0.7}, {0, 0, 1});
  return pose;
}

// A real client over a real socket.
class LiveViewer {
 public:
  explicit LiveViewer(uint16_t port, const proto::ViewRequest& request = requestView())
      : socket_(port), viewer_(request, client::Blend::kKeyframe, Duration::milliseconds(10)) {
    viewer_.leaveMeshesEmpty();
  }

  // Sends what is due, then takes what comes within a few milliseconds. False when the server has closed.
  bool advance() { return advance(poseAt(steadyNow())); }
  bool advance(const proto::Pose& pose) {
    viewer_.frame(steadyNow(), pose);
    for (Bytes message; viewer_.takeOutgoing(message);) socket_.send(message);
    if (!socket_.socket().isReadable(std::chrono::milliseconds(5))) return true;
    const auto message = socket_.receive();
    if (!message || message->opcode == Opcode::kClose) {
      close_code_ = message ? message->closeCode() : 0;
      return false;
    }
    const Status status = viewer_.receive(message->bytes(), steadyNow());
    EXPECT_TRUE(status.ok()) << status.error().message;
    return status.ok();
  }
  uint32_t keyframes() const { return viewer_.statistics().keyframes; }
  WebSocketClient& socket() { return socket_; }
  int closeCode() const { return close_code_; }

 private:
  WebSocketClient socket_;
  int close_code_ = 0;
  client::Viewer viewer_;
};

TEST(Server, AnswersPlainRequests) {
  const test::TemporaryFolder web;
  std::ofstream(web / "index.html") << "<html>the page</html>";
  ServeOptions options = testOptions();
  options.web = web.path();
  const auto server = serve(options);
  EXPECT_NE(httpGet(server->port(), "/healthz").find("\r\n\r\nok\n"), std::string::npos);
  EXPECT_NE(httpGet(server->port(), "/").find("the page"), std::string::npos);
  const std::string head = httpGet(server->port(), "/", "", "HEAD");
  EXPECT_NE(head.find("Content-Length: 21\r\n"), std::string::npos);
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
  EXPECT_TRUE(httpGet(server->port(), "/fly").starts_with("HTTP/1.1 426"));
  EXPECT_TRUE(httpGet(server->port(), "/../etc/passwd").starts_with("HTTP/1.1 404"));
  EXPECT_EQ(metric(server->port(), "sessions"), 0);
}

TEST(Server, EveryReplyTellsBrowsersItsRules) {
  const test::TemporaryFolder web;
  std::ofstream(web / "index.html") << "<html>the page</html>";
  ServeOptions options = testOptions();
  options.web = web.path();
  options.metrics_listen = ListenAddress{.port = 0};
  options.max_connections = 50;
  const auto server = serve(options);
  const uint16_t port = server->port();
  const auto expectRules = [](const std::string& reply, const std::string& status) {
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 " + status)) << reply;
    for (const char* rule : {"X-Content-Type-Options: nosniff\r\n", "Content-Security-Policy: default-src 'self'; ",
                             "frame-ancestors 'self'\r\n", "Cross-Origin-Opener-Policy: same-origin\r\n",
                             "Cross-Origin-Embedder-Policy: require-corp\r\n", "Referrer-Policy: no-referrer\r\n"})
      EXPECT_NE(reply.find(rule), std::string::npos) << rule << reply;
  };
  expectRules(httpGet(port, "/"), "200");
  expectRules(httpGet(port, "/", "", "HEAD"), "200");
  expectRules(httpGet(port, "/", "Range: bytes=0-3\r\n"), "206");
  expectRules(httpGet(port, "/", "Range: bytes=99-\r\n"), "416");
  expectRules(httpGet(port, "/livez"), "200");
  expectRules(httpGet(port, "/none"), "404");
  expectRules(httpGet(port, "/", "", "POST"), "405");
  expectRules(httpGet(port, "/fly"), "426");
  expectRules(httpGet(server->metricsPort(), "/metrics"), "200");
  Socket nonsense(port);
  nonsense.send("GET / HTTP/9.9\r\n\r\n");
  expectRules(nonsense.receiveToEnd(), "400");
  std::deque<Socket> others;
  for (int i = 0; i < 66; ++i) others.emplace_back(port);
  expectRules(Socket(port).receiveToEnd(), "503");
}

// A file takes longer than the time for a reply to leave, which is for each piece of it.
TEST(Server, SendsALargeFileToWhoReadsSlowly) {
  const test::TemporaryFolder web;
  const std::string whole(4u << 20, 'x');
  std::ofstream(web / "index.html") << "<html>the page</html>";
  std::ofstream(web / "large.bin") << whole;
  ServeOptions options = testOptions();
  options.web = web.path();
  options.http_timeout = Duration::seconds(2);
  options.send_buffer_bytes = 4096;
  const auto server = serve(options);
  Socket slow(server->port(), 4096);
  WebSocketClient silent(server->port());
  slow.send("GET /large.bin HTTP/1.1\r\nHost: test\r\nConnection: close\r\n\r\n");
  const Time begin = steadyNow();
  size_t received = 0;
  while (const auto some = slow.receive(64u << 10)) {
    received += some->size();
    if (steadyNow() - begin < Duration::seconds(2.5)) (void)silent.socket().isReadable(std::chrono::milliseconds(80));
  }
  EXPECT_GE(received, whole.size());
}

TEST(Server, TwoViewersGetTheirOwnKeyframes) {
  const auto server = serve(testOptions());
  LiveViewer first(server->port()), second(server->port());
  ASSERT_TRUE(first.socket().isOpen() && second.socket().isOpen()) << first.socket().reply();
  EXPECT_TRUE(eventually(
      [&] { return !first.advance() || !second.advance() || (first.keyframes() > 4 && second.keyframes() > 4); }));
  EXPECT_GT(first.keyframes(), 4u);
  EXPECT_GT(second.keyframes(), 4u);
  EXPECT_EQ(metric(server->port(), "sessions"), 2);
  EXPECT_GE(metric(server->port(), "keyframes_total"), 10);
  EXPECT_GT(metric(server->port(), "section_nodes"), 0);
}

TEST(Server, CountsDownWhenAViewerLeaves) {
  const auto server = serve(testOptions());
  {
    LiveViewer viewer(server->port());
    EXPECT_TRUE(eventually([&] { return !viewer.advance() || viewer.keyframes() > 0; }));
    EXPECT_EQ(metric(server->port(), "sessions"), 1);
  }
  EXPECT_TRUE(eventually([&] { return metric(server->port(), "sessions") == 0; }));
  EXPECT_EQ(metric(server->port(), "section_nodes"), 0);
}

TEST(Server, RefusesAMessageThatIsNone) {
  const auto server = serve(testOptions());
  WebSocketClient client(server->port());
  client.send(Bytes{0xff, 1, 2, 3});
  const auto message = client.receive();
  ASSERT_TRUE(message.has_value());
  const Bytes bytes = message->bytes();
  const auto decoded = proto::decodeServerMessage(bytes);
  ASSERT_TRUE(decoded.ok());
  EXPECT_TRUE(std::holds_alternative<proto::Refusal>(*decoded));
  EXPECT_EQ(client.receiveClose(), 1008);
  EXPECT_TRUE(httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200"));
}

TEST(Server, RefusesTextAndEmptyMessages) {
  const auto server = serve(testOptions());
  WebSocketClient text(server->port()), empty(server->port());
  text.sendFrame(Opcode::kText, "hello");
  EXPECT_EQ(text.receiveClose(), 1008);
  empty.send({});
  EXPECT_EQ(empty.receiveClose(), 1008);
  EXPECT_EQ(metric(server->port(), "refusals_total{reason=\"message\"}"), 2);
}

TEST(Server, RefusesAViewerThatFloods) {
  ServeOptions options = testOptions();
  options.limits.viewer_bytes = 1000;
  const auto server = serve(options);
  WebSocketClient client(server->port());
  client.send(Bytes(1001));
  EXPECT_EQ(client.receiveClose(), 1008);
}

TEST(Server, ClosesOnAMessageBeyondTheLimit) {
  const auto server = serve(testOptions());
  WebSocketClient client(server->port());
  client.socket().send(WebSocketClient::frameHead(Opcode::kBinary, proto::kMaxClientMessageBytes + 1));
  EXPECT_EQ(client.receiveClose(), 1009);
  EXPECT_TRUE(httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200"));
}

TEST(Server, ServesOnAfterRandomBytes) {
  const auto server = serve(testOptions());
  Rng rng(5);
  for (int round = 0; round < 20; ++round) {
    std::string bytes(1 + rng.below(5000), '\0');
    for (char& c : bytes) c = static_cast<char>(rng.next());
    Socket plain(server->port());
    plain.send(bytes + "\r\n\r\n");
    plain.receiveToEnd();
    WebSocketClient framed(server->port());
    framed.socket().send(bytes);
    framed.send(Bytes(bytes.begin(), bytes.end()));  // whatever came before, a frame that ends it
  }
  EXPECT_TRUE(httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200"));
}

TEST(Server, ClosesWhoeverSaysNothing) {
  ServeOptions options = testOptions();
  options.http_timeout = options.idle_timeout = Duration::milliseconds(100);
  const auto server = serve(options);
  Socket mute(server->port());
  EXPECT_EQ(mute.receiveToEnd(), "");
  WebSocketClient idle(server->port());
  EXPECT_EQ(idle.receiveClose(), 1008);
}

// It asks for more than the buffers of both systems hold, sends poses for ever, and reads nothing.
TEST(Server, ClosesAViewerThatNeverReadsAfterOneKeyframe) {
  ServeOptions options = testOptions();
  options.idle_timeout = Duration::milliseconds(500);
  options.send_buffer_bytes = 4096;
  const auto server = serve(options, roughWorld());
  WebSocketClient client(server->port(), 4096);
  client.send(proto::encode(requestAll()));
  const auto sendPose = [&] {
    return client.send(proto::encode(proto::PoseUpdate{{steadyNow(), poseAt(steadyNow())}, 0, {}}));
  };
  sendPose();
  ASSERT_TRUE(eventually([&] { return metric(server->port(), "keyframes_total") == 1; }));
  EXPECT_TRUE(eventually([&] { return !sendPose() || metric(server->port(), "sessions") == 0; }));
  EXPECT_EQ(metric(server->port(), "keyframes_total"), 1);
  EXPECT_TRUE(eventually([&] { return metric(server->port(), "sessions") == 0; }));
}

TEST(Server, AdmitsNoMoreThanItsLimit) {
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

TEST(Server, AdmitsNoMoreFromAnAddressThanItsLimit) {
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

// Who makes up a first line of the header is not believed: the proxy's own is the last one.
TEST(Server, CountsForTheAddressThatItsProxyNames) {
  ServeOptions options = testOptions();
  options.max_connections_per_address = 1;
  options.gate.trusted_proxies = {"127.0.0.1"};
  const auto server = serve(options);
  const auto ask = [&](const std::string& lines) {
    Socket socket(server->port());
    socket.send("GET /livez HTTP/1.1\r\nHost: a\r\n" + lines + "\r\n");
    return socket;
  };
  const auto status = [](Socket& socket) { return socket.receiveSome(12).substr(9); };
  Socket first = ask("X-Forwarded-For: 192.0.2.1\r\nX-Forwarded-For: 198.51.100.7\r\n");
  EXPECT_EQ(status(first), "200");
  Socket same = ask("X-Forwarded-For: 192.0.2.2\r\nX-Forwarded-For: 198.51.100.7\r\n");
  EXPECT_EQ(status(same), "503");
  Socket victim = ask("X-Forwarded-For: 192.0.2.1\r\n");
  EXPECT_EQ(status(victim), "200") << "the name that the first made up";
}

TEST(Server, ClosesAViewerThatNeverGreetsAndOneWhoseMessageDoesNotEnd) {
  ServeOptions options = testOptions();
  options.idle_timeout = Duration::milliseconds(400);  // how often viewers are looked at follows from it
  options.hello_timeout = options.message_timeout = Duration::milliseconds(100);
  const auto server = serve(options);
  WebSocketClient mute(server->port());
  EXPECT_EQ(mute.receiveClose(), 1008);
  WebSocketClient slow(server->port());
  slow.send(proto::encode(requestView()));
  slow.socket().send(WebSocketClient::frameHead(Opcode::kBinary, 1000) + "beginning");
  EXPECT_EQ(slow.receiveClose(), 1008);
}

// Whoever holds connections beyond the limit and asks for nothing leaves room for operators for a time only.
TEST(Server, ClosesWhateverComesBeyondItsReserve) {
  ServeOptions options = testOptions();
  options.max_connections = 1;
  const auto server = serve(options);
  std::deque<Socket> mute;
  for (int i = 0; i < 17; ++i) mute.emplace_back(server->port());
  EXPECT_TRUE(Socket(server->port()).receiveToEnd().starts_with("HTTP/1.1 503"));
  mute.clear();
  EXPECT_TRUE(eventually([&] { return httpGet(server->port(), "/livez").starts_with("HTTP/1.1 200"); }));
}

TEST(Server, HasAPortForOperators) {
  ServeOptions options = testOptions();
  options.metrics_listen = ListenAddress{.port = 0};
  options.max_connections = 1;
  options.version = "1.2.3";
  const auto server = serve(options);
  EXPECT_TRUE(httpGet(server->port(), "/metrics").starts_with("HTTP/1.1 404"));
  WebSocketClient viewer(server->port());
  ASSERT_TRUE(viewer.isOpen());
  const uint16_t port = server->metricsPort();
  const std::string page = httpGet(port, "/metrics");
  for (const char* line : {"\nforeland_build_info{version=\"1.2.3\"} 1\n", "\nforeland_uptime_seconds ",
                           "\nprocess_cpu_seconds_total ", "\nprocess_resident_memory_bytes ", "\nprocess_open_fds ",
                           "\nforeland_http_replies_total{code=\"404\"} 1\n", "\nforeland_connections 1\n"})
    EXPECT_NE(page.find(line), std::string::npos) << line << page;
  EXPECT_TRUE(httpGet(port, "/readyz").starts_with("HTTP/1.1 503")) << "it is full";
  EXPECT_TRUE(httpGet(port, "/").starts_with("HTTP/1.1 404"));
  EXPECT_FALSE(WebSocketClient(port).isOpen());
}

TEST(Server, TellsTheToleranceInForce) {
  const auto server = serve(testOptions());
  LiveViewer viewer(server->port());
  ASSERT_TRUE(eventually([&] { return !viewer.advance() || viewer.keyframes() > 0; }));
  EXPECT_EQ(metric(server->port(), "tolerance_px"), 1);
  EXPECT_EQ(metric(server->port(), "coarse"), 0);
}

TEST(Server, IsReadyUntilItIsFull) {
  ServeOptions options = testOptions();
  const auto server = serve(options);
  for (const char* path : {"/livez", "/readyz", "/healthz"})
    EXPECT_TRUE(httpGet(server->port(), path).starts_with("HTTP/1.1 200")) << path;
}

// Viewers who want all that there is, and are elsewhere all the time, of a server with one worker. While they fly it is
// not ready for more, though it takes them; when they have left it is.
TEST(Server, IsNotReadyWhileItIsOverloaded) {
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

TEST(Server, StopsWithViewersConnected) {
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
TEST(Server, HandsItsViewersOver) {
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
TEST(Server, HandsViewersOverBesideOneThatNeverReads) {
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

// A clock stands for all that may fail anywhere for want of memory: whoever asks it now and then gets an exception.
class FailingClock {
 public:
  Clock clock() {
    return [this] {
      if (fails_ && ++calls_ % 5 == 0) throw std::bad_alloc();
      return steadyNow();
    };
  }
  void fail(bool fails) { fails_ = fails; }

 private:
  std::atomic<bool> fails_{false};
  std::atomic<unsigned> calls_{0};
};

TEST(Server, ServesOnWhateverIsThrown) {
  FailingClock clock;
  ServeOptions options = testOptions();
  options.idle_timeout = Duration::milliseconds(40);  // viewers are watched four times as often
  auto running = Server::listen(hillWorld(), options, clock.clock());
  ASSERT_TRUE(running.ok());
  Server& server = **running;
  const uint16_t port = server.port();
  for (int round = 0; round < 30; ++round) {
    clock.fail(true);
    std::vector<std::unique_ptr<WebSocketClient>> viewers;
    for (int i = 0; i < 3; ++i) {
      viewers.push_back(std::make_unique<WebSocketClient>(port));
      viewers.back()->send(proto::encode(requestView()));
      viewers.back()->send(proto::encode(proto::PoseUpdate{{steadyNow(), poseAt(steadyNow())}, 0, {}}));
      httpGet(port, "/readyz");
    }
    for (auto& viewer : viewers) viewer->receiveClose();  // they fail, or are idle
    clock.fail(false);
    EXPECT_TRUE(httpGet(port, "/livez").starts_with("HTTP/1.1 200")) << round;
  }
  EXPECT_TRUE(eventually([&] { return metric(port, "sessions") == 0; })) << "nobody is forgotten";
  EXPECT_GT(metric(port, "failures_total"), 0);
  WebSocketClient last(port);
  ASSERT_TRUE(last.isOpen());
  clock.fail(true);
  server.drain(Duration::seconds(1));
  server.stop();
}

// Would wait for an hour if the answer did not end it.
TEST(Server, StopsAsSoonAsItsViewersAnswer) {
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

TEST(Server, NamesThePortThatIsTaken) {
  const auto first = serve(testOptions());
  ServeOptions options = testOptions();
  options.listen.port = first->port();
  const auto second = Server::listen(hillWorld(), options, steadyNow);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find(std::to_string(first->port())), std::string::npos) << second.error().message;
  EXPECT_NE(second.error().message.find("--listen"), std::string::npos);
}

TEST(Server, NamesTheAddressThatIsNotHere) {
  ServeOptions options = testOptions();
  options.listen.host = "192.0.2.1";  // reserved for documentation
  const auto server = Server::listen(hillWorld(), options, steadyNow);
  ASSERT_FALSE(server.ok());
  EXPECT_NE(server.error().message.find("192.0.2.1"), std::string::npos) << server.error().message;
}

}  // namespace
}  // namespace foreland::server
