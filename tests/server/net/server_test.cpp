// The server through real sockets on the loopback: what a viewer gets, and what happens to whoever misbehaves.
#include "server/net/server.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/net/live_server.h"

namespace foreland::server {
namespace {

using test::eventually;
using test::hillWorld;
using test::httpGet;
using test::LiveViewer;
using test::metric;
using test::Opcode;
using test::poseAt;
using test::requestAll;
using test::requestView;
using test::roughWorld;
using test::serve;
using test::Socket;
using test::testOptions;
using test::WebSocketClient;

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

// The scenes hills and rough.
auto serveTwo() {
  auto listening = Server::listen(std::vector<ServedScene>{{"hills", hillWorld()}, {"rough", roughWorld()}},
                                  testOptions(), test::steadyNow);
  EXPECT_TRUE(listening.ok()) << listening.error().message;
  return std::move(listening).value();
}

// Each viewer is shown the scene at whose path it connects.
TEST(Server, ShowsEachOfSeveralScenesAtItsPath) {
  const auto server = serveTwo();
  const uint16_t port = server->port();
  std::vector<std::unique_ptr<LiveViewer>> viewers;
  for (const char* path : {"/hills/fly", "/rough/", "/rough"})
    viewers.push_back(std::make_unique<LiveViewer>(port, requestView(), path));
  ASSERT_TRUE(eventually([&] {
    return std::ranges::all_of(viewers,
                               [](const auto& viewer) { return viewer->advance() && viewer->keyframes() > 1; });
  }));
  EXPECT_EQ(viewers[0]->viewer().welcome()->scene_id, hillWorld()->hierarchy.scene().id());
  for (size_t i : {1u, 2u}) EXPECT_EQ(viewers[i]->viewer().welcome()->scene_id, roughWorld()->hierarchy.scene().id());
  EXPECT_EQ(metric(port, "sessions"), 3);
  EXPECT_EQ(metric(port, "scene_sessions{scene=\"hills\"}"), 1);
  EXPECT_EQ(metric(port, "scene_sessions{scene=\"rough\"}"), 2);
  for (const char* path : {"/fly", "/", "/alps/fly", "/hills/flyx", "/hills/../rough/fly"}) {
    WebSocketClient lost(port, 0, path);
    EXPECT_FALSE(lost.isOpen()) << path;
    EXPECT_TRUE(lost.reply().starts_with("HTTP/1.1 404")) << lost.reply();
  }
  viewers.pop_back();
  EXPECT_TRUE(eventually([&] { return metric(port, "scene_sessions{scene=\"rough\"}") == 1; }));
  EXPECT_EQ(metric(port, "scene_sessions{scene=\"hills\"}"), 1);
}

// The area that a viewer is in is for proxies (docs/decisions/0026): a server takes any, and looks at none.
TEST(Server, IgnoresTheAreaOfAnAddress) {
  for (const bool has_scenes : {false, true}) {
    const auto server = has_scenes ? serveTwo() : serve(testOptions());
    const std::string path = has_scenes ? "/hills/fly" : "/fly";
    for (const std::string query :
         {"?area=17", "?area=", "?area", "?area=-1", "?area=99999999999999999999", "?area=%00%ff%",
          "?area=../../rough/fly", "?area=1&area=2", "?x=y&area=3&token=t", "?area=1?area=2#/rough/fly"})
      EXPECT_TRUE(WebSocketClient(server->port(), 0, path + query).isOpen()) << path << query;
    EXPECT_TRUE(WebSocketClient(server->port(), 0, path + "?area=" + std::string(1000, '9')).isOpen());
  }
}

TEST(Server, WithOneSceneNamesNone) {
  const auto server = serve(testOptions());
  LiveViewer viewer(server->port(), requestView(), "/whatever/path");
  EXPECT_TRUE(eventually([&] { return viewer.advance() && viewer.keyframes() > 0; }));
  EXPECT_EQ(httpGet(server->port(), "/metrics").find("scene_sessions"), std::string::npos);
}

TEST(Server, EveryReplyTellsBrowsersItsRules) {
  const test::TemporaryFolder web;
  std::ofstream(web / "index.html") << "<html>the page</html>";
  std::ofstream(web / "worker.js") << "postMessage(1)";
  std::ofstream(web / "foreland.wasm") << "module";
  ServeOptions options = testOptions();
  options.web = web.path();
  options.metrics_listen = ListenAddress{.port = 0};
  options.max_connections = 50;
  const auto server = serve(options);
  const uint16_t port = server->port();
  const auto expectRules = [](const std::string& reply, const std::string& status, bool is_run = false) {
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 " + status)) << reply;
    for (const char* rule : {"X-Content-Type-Options: nosniff\r\n", "Referrer-Policy: no-referrer\r\n"})
      EXPECT_NE(reply.find(rule), std::string::npos) << rule << reply;
    for (const char* rule :
         {"Content-Security-Policy: default-src 'self'; ", "frame-ancestors 'self'\r\n",
          "Cross-Origin-Opener-Policy: same-origin\r\n", "Cross-Origin-Embedder-Policy: require-corp\r\n"})
      EXPECT_EQ(reply.find(rule) != std::string::npos, is_run) << rule << reply;
  };
  expectRules(httpGet(port, "/"), "200", true);
  expectRules(httpGet(port, "/", "", "HEAD"), "200", true);
  expectRules(httpGet(port, "/", "Range: bytes=0-3\r\n"), "206", true);
  expectRules(httpGet(port, "/worker.js"), "200", true);
  expectRules(httpGet(port, "/foreland.wasm"), "200");
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

TEST(Server, SaysThatTheFieldsOfARequestAreTooLong) {
  ServeOptions options = testOptions();
  const auto server = serve(options);
  const auto ask = [&](size_t bytes) {
    return httpGet(server->port(), "/livez", "Cookie: " + std::string(bytes, 'c') + "\r\n");
  };
  EXPECT_TRUE(ask(7u << 10).starts_with("HTTP/1.1 200"));
  for (const size_t bytes : {size_t{9} << 10, size_t{60} << 10, size_t{2000} << 10}) {
    const std::string reply = ask(bytes);
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 431 Request Header Fields Too Large\r\n")) << bytes << ": " << reply;
    EXPECT_NE(reply.find("--max-header-kib"), std::string::npos) << reply;
  }
  options.max_header_bytes = 64u << 10;
  const auto generous = serve(options);
  EXPECT_TRUE(httpGet(generous->port(), "/livez", "Cookie: " + std::string(60u << 10, 'c') + "\r\n")
                  .starts_with("HTTP/1.1 200"));
}

TEST(Server, SaysThatAProxyHasNotPassedOnTheUpgrade) {
  const auto server = serve(testOptions());
  const std::string handshake = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  for (const char* target : {"/fly", "/terrain/fly"})
    for (const char* rest : {"", "Upgrade: websocket\r\n"}) {  // with Connection: close
      const std::string reply = httpGet(server->port(), target, handshake + rest);
      EXPECT_TRUE(reply.starts_with("HTTP/1.1 426")) << reply;
      EXPECT_NE(reply.find("proxy_set_header Upgrade"), std::string::npos) << reply;
    }
  EXPECT_EQ(httpGet(server->port(), "/fly").find("proxy_set_header"), std::string::npos) << "somebody else";
}

// What its WebSocket is refused for a page cannot read, of whatever origin it is.
TEST(Server, TellsAPageWhyItsWebSocketIsRefused) {
  ServeOptions options = testOptions();
  options.gate.token_secret = std::string(48, 's');
  options.gate.allowed_origins = {"https://maps.example"};
  const auto server = serve(options);
  const auto ask = [&](const std::string& origin, const std::string& query = "") {
    const std::string reply = httpGet(server->port(), "/fly" + query, "Origin: " + origin + "\r\n");
    EXPECT_NE(reply.find("Access-Control-Allow-Origin: *\r\n"), std::string::npos) << reply;
    return reply.substr(9, 3) + reply.substr(reply.find("\r\n\r\n"));
  };
  EXPECT_TRUE(ask("https://other.example").starts_with("403")) << ask("https://other.example");
  EXPECT_NE(ask("https://maps.example").find("A token is needed"), std::string::npos);
  EXPECT_TRUE(ask("https://maps.example", "?token=a.b.c").starts_with("401"));
  const Token token{.name = "a", .expires_s = 4'000'000'000};
  EXPECT_TRUE(ask("https://maps.example", "?token=" + signToken(token, options.gate.token_secret)).starts_with("426"));
  EXPECT_EQ(httpGet(server->port(), "/livez").find("Access-Control"), std::string::npos);
}

// Which origins' pages may read the page's files and the models' images; what else is answered is nobody else's.
TEST(Server, SharesFilesWithTheOriginsThatMayConnect) {
  const test::TemporaryFolder web;
  std::ofstream(web / "index.html") << "<html>the page</html>";
  ServeOptions options = testOptions();
  options.web = web.path();
  const std::string allow = "Access-Control-Allow-Origin: ", load = "Cross-Origin-Resource-Policy: cross-origin\r\n";
  const auto ask = [](const auto& server, const std::string& origin, const std::string& path = "/") {
    return httpGet(server->port(), path, origin.empty() ? "" : "Origin: " + origin + "\r\n");
  };
  const auto open = serve(options);
  for (const char* origin : {"", "https://anyone.example"}) {
    const std::string reply = ask(open, origin);
    EXPECT_NE(reply.find(allow + "*\r\n"), std::string::npos) << reply;
    EXPECT_NE(reply.find(load), std::string::npos) << reply;
    EXPECT_EQ(reply.find("Origin\r\n"), std::string::npos) << reply;
  }
  options.gate.allowed_origins = {"https://maps.example", "https://other.example:8443"};
  const auto choosy = serve(options);
  for (const std::string origin : {"https://maps.example", "https://other.example:8443"}) {
    const std::string reply = ask(choosy, origin);
    EXPECT_NE(reply.find(allow + origin + "\r\n"), std::string::npos) << reply;
    EXPECT_NE(reply.find(load), std::string::npos) << reply;
    EXPECT_NE(reply.find("Vary: Origin\r\n"), std::string::npos) << reply;
  }
  for (const char* origin : {"", "https://elsewhere.example", "https://maps.example:8443", "null"}) {
    const std::string reply = ask(choosy, origin);
    EXPECT_EQ(reply.find(allow), std::string::npos) << reply;
    EXPECT_EQ(reply.find(load), std::string::npos) << reply;
    EXPECT_NE(reply.find("Vary: Origin\r\n"), std::string::npos) << reply;
  }
  for (const char* path : {"/livez", "/none"}) {
    const std::string reply = ask(open, "https://anyone.example", path);
    EXPECT_EQ(reply.find(allow), std::string::npos) << path << reply;
    EXPECT_EQ(reply.find(load), std::string::npos) << path << reply;
  }
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

// The line that HAProxy's agent-check reads: https://docs.haproxy.org/2.6/configuration.html#5.2-agent-check
TEST(Server, TellsAnAgentWhatWeightItShouldHave) {
  ServeOptions options = testOptions();
  options.agent_listen = ListenAddress{.port = 0};
  const auto server = serve(options);
  const auto ask = [&] {
    Socket agent(server->agentPort());
    std::string line;
    for (std::string more = agent.receiveSome(99); !more.empty(); more = agent.receiveSome(99)) line += more;
    return line;
  };
  EXPECT_EQ(ask(), "ready 100%\n") << "nobody flies";
  EXPECT_EQ(ask(), "ready 100%\n") << "as often as one asks";
  const std::string page = httpGet(server->port(), "/metrics");
  EXPECT_NE(page.find("\nforeland_pool_load 0\n"), std::string::npos) << page;
  server->drain(Duration::seconds(1));
  EXPECT_EQ(ask(), "drain\n");
}

TEST(Server, TellsTheToleranceInForce) {
  const auto server = serve(testOptions());
  LiveViewer viewer(server->port());
  ASSERT_TRUE(eventually([&] { return !viewer.advance() || viewer.keyframes() > 0; }));
  EXPECT_EQ(metric(server->port(), "tolerance_px"), 1);
  EXPECT_EQ(metric(server->port(), "coarse"), 0);
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
