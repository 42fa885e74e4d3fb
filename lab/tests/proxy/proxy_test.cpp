// The proxy on real sockets of 127.0.0.1: bytes, ends and breaks of connections. When bytes arrive is tested without a
// clock in link_stream_test.cpp.
#include "lab/proxy/proxy.h"

#include <gtest/gtest.h>

#include <thread>

#include "server/net/steady_clock.h"
#include "tests/server/net/client.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

using test::Socket;

// A server's port, and who comes to it.
class Port {
 public:
  Port() : fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(fd_, 16), 0);
    EXPECT_EQ(::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    number_ = ntohs(address.sin_port);
  }
  ~Port() { ::close(fd_); }
  Port(const Port&) = delete;
  Port& operator=(const Port&) = delete;
  uint16_t number() const { return number_; }
  Socket accept() { return Socket::of(::accept(fd_, nullptr, nullptr)); }

 private:
  int fd_;
  uint16_t number_ = 0;
};

// One that changes the times of bytes in every way, by little.
sim::LinkPair quickLink() {
  sim::LinkOptions link;
  link.latency = Duration{2000};
  link.jitter = Duration{1000};
  link.bytes_per_second = 20e6;
  link.queue_bytes = 20'000;
  link.loss = 0.1;
  link.repeat_after = Duration{3000};
  return {link, link};
}

std::unique_ptr<Proxy> proxyTo(uint16_t port, size_t doors = 1) {
  ProxyOptions options{.doors = std::vector<ProxyDoor>(doors, {{"127.0.0.1", 0}, quickLink(), 5}),
                       .to = {"127.0.0.1", port}};
  auto proxy = Proxy::open(std::move(options), server::steadyNow);
  EXPECT_TRUE(proxy.ok()) << proxy.error().message;
  return std::move(*proxy);
}

bool isEmpty(const Proxy& proxy) {
  return test::eventually([&] {
    std::this_thread::yield();
    return proxy.connections() == 0;
  });
}

std::string anyText(Rng& rng, size_t size) {
  std::string text(size, '\0');
  for (char& c : text) c = static_cast<char>(rng.next());
  return text;
}

TEST(Proxy, CarriesAllBytesInOrderBothWaysThroughEachDoor) {
  Rng rng(test::randomSeed());
  Port port;
  const auto proxy = proxyTo(port.number(), 2);
  ASSERT_NE(proxy->port(0), proxy->port(1));
  for (size_t door = 0; door < 2; ++door) {
    Socket viewer(proxy->port(door));
    Socket server = port.accept();
    const std::string up = anyText(rng, 1 + rng.below(300'000)), down = anyText(rng, 1 + rng.below(900'000));
    std::jthread sends_up([&] { EXPECT_TRUE(viewer.send(up)); });
    std::jthread sends_down([&] { EXPECT_TRUE(server.send(down)); });
    std::jthread receives_up([&] { EXPECT_TRUE(server.receive(up.size()) == up); });
    EXPECT_TRUE(viewer.receive(down.size()) == down);
  }
  EXPECT_TRUE(isEmpty(*proxy));
}

// The other end gets what was sent before, then the end, and can still answer.
TEST(Proxy, EndsOneDirectionBehindItsBytes) {
  Port port;
  const auto proxy = proxyTo(port.number());
  Socket viewer(proxy->port(0));
  Socket server = port.accept();
  ASSERT_TRUE(viewer.send(std::string(200'000, 'x')));
  viewer.endSending();
  EXPECT_EQ(server.receiveToEnd().size(), 200'000u);
  ASSERT_TRUE(server.send("good bye"));
  EXPECT_EQ(viewer.receive(8), "good bye");
  EXPECT_EQ(proxy->connections(), 1u);
  server.endSending();
  EXPECT_EQ(viewer.receiveToEnd(), "");
  EXPECT_TRUE(isEmpty(*proxy));
}

TEST(Proxy, DropsBothSidesWhenOneBreaks) {
  Port port;
  const auto proxy = proxyTo(port.number());
  for (const bool is_viewer : {true, false}) {
    Socket viewer(proxy->port(0));
    Socket server = port.accept();
    ASSERT_TRUE(viewer.send("here"));
    ASSERT_EQ(server.receive(4), "here");
    (is_viewer ? viewer : server).reset();
    EXPECT_EQ((is_viewer ? server : viewer).receiveToEnd(), "");
    EXPECT_TRUE(isEmpty(*proxy));
  }
}

TEST(Proxy, ClosesWhomItCannotConnect) {
  auto gone = std::make_unique<Port>();
  const auto proxy = proxyTo(gone->number());
  gone.reset();
  Socket viewer(proxy->port(0));
  EXPECT_EQ(viewer.receiveToEnd(), "");
  EXPECT_TRUE(isEmpty(*proxy));
}

TEST(Proxy, StopsWithBytesOnTheWay) {
  Port port;
  const auto proxy = proxyTo(port.number());
  Socket viewer(proxy->port(0));
  Socket server = port.accept();
  ASSERT_TRUE(viewer.send(std::string(50'000, 'x')));
  proxy->stop();
  EXPECT_EQ(proxy->connections(), 0u);
  server.receiveToEnd();
  EXPECT_EQ(viewer.receiveToEnd(), "");
}

TEST(Proxy, RefusesAPortInUseByName) {
  Port port;
  const auto proxy = Proxy::open({.doors = {{{"127.0.0.1", port.number()}, quickLink(), 1}}, .to = {"127.0.0.1", 1}},
                                 server::steadyNow);
  ASSERT_FALSE(proxy.ok());
  EXPECT_NE(proxy.error().message.find("127.0.0.1:" + std::to_string(port.number())), std::string::npos);
  EXPECT_NE(proxy.error().message.find("another program uses the port"), std::string::npos);
}

}  // namespace
}  // namespace foreland::lab
