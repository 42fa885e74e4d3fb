#include <gtest/gtest.h>

#include "client/fly/net/web_socket_client.h"

namespace foreland::client {
namespace {

TEST(WebSocketUrl, ReadsHostPortAndPath) {
  const auto url = parseWebSocketUrl("ws://127.0.0.1:8080/fly?x=1");
  ASSERT_TRUE(url.ok());
  EXPECT_EQ(url->host, "127.0.0.1");
  EXPECT_EQ(url->port, "8080");
  EXPECT_EQ(url->target, "/fly?x=1");
}

TEST(WebSocketUrl, TakesPort80AndThePagesPathWhenNoneIsGiven) {
  const auto url = parseWebSocketUrl("ws://example.org");
  ASSERT_TRUE(url.ok());
  EXPECT_EQ(url->port, "80");
  EXPECT_EQ(url->target, "/fly");
}

TEST(WebSocketUrl, ReadsAnAddressInBrackets) {
  const auto url = parseWebSocketUrl("ws://[::1]:8080");
  ASSERT_TRUE(url.ok());
  EXPECT_EQ(url->host, "::1");
  EXPECT_EQ(url->port, "8080");
}

TEST(WebSocketUrl, RefusesWhatIsNotOneAndSaysHowToWriteIt) {
  for (const char* bad : {"", "http://a:1", "wss://a:1", "ws://", "ws://:80", "ws://a:0", "ws://a:70000", "ws://a:x",
                          "ws://a b:1", "ws://[", "ws://[]:1"}) {
    const auto url = parseWebSocketUrl(bad);
    ASSERT_FALSE(url.ok()) << bad;
    EXPECT_NE(url.error().message.find("ws://HOST:PORT"), std::string::npos) << url.error().message;
  }
}

TEST(WebSocketClient, SaysSoWhenNobodyListens) {
  const auto client = WebSocketClient::connect("ws://127.0.0.1:1", std::chrono::seconds(5));
  ASSERT_FALSE(client.ok());
  EXPECT_NE(client.error().message.find("cannot connect"), std::string::npos) << client.error().message;
}

}  // namespace
}  // namespace foreland::client
