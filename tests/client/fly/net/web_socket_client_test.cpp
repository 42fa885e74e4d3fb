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

TEST(WebSocketUrl, TakesThePagesPathBeforeAQuery) {
  for (const auto& [text, target] : {std::pair{"ws://a/?area=17", "/fly?area=17"},
                                     {"ws://a/alps/?x=/", "/alps/fly?x=/"},
                                     {"ws://a/alps?x=/", "/alps?x=/"}}) {
    const auto url = parseWebSocketUrl(text);
    ASSERT_TRUE(url.ok()) << text;
    EXPECT_EQ(url->target, target);
  }
}

TEST(WebSocketUrl, ReadsAnAddressInBrackets) {
  const auto url = parseWebSocketUrl("ws://[::1]:8080");
  ASSERT_TRUE(url.ok());
  EXPECT_EQ(url->host, "::1");
  EXPECT_EQ(url->port, "8080");
}

TEST(WebSocketUrl, TakesTheAddressesOfPages) {
  for (const auto& [text, port, security] : {std::tuple{"ws://a", "80", Security::kNone},
                                             {"http://a", "80", Security::kNone},
                                             {"wss://a", "443", Security::kTls},
                                             {"https://a/", "443", Security::kTls}}) {
    const auto url = parseWebSocketUrl(text);
    ASSERT_TRUE(url.ok()) << text;
    EXPECT_EQ(url->port, port) << text;
    EXPECT_EQ(url->security, security) << text;
    EXPECT_EQ(url->target, "/fly") << text;
  }
}

TEST(WebSocketUrl, RefusesWhatIsNotOneAndSaysHowToWriteIt) {
  for (const char* bad : {"", "ftp://a:1", "a:1", "wss://", "ws://", "ws://:80", "ws://a:0", "ws://a:70000", "ws://a:x",
                          "ws://a b:1", "ws://[", "ws://[]:1"}) {
    const auto url = parseWebSocketUrl(bad);
    ASSERT_FALSE(url.ok()) << bad;
    EXPECT_NE(url.error().message.find("ws://HOST:PORT"), std::string::npos) << url.error().message;
  }
}

TEST(WebSocketUrl, HoldsTheAreaOnceBesideWhatElseItHolds) {
  EXPECT_EQ(withArea("/fly", 17), "/fly?area=17");
  EXPECT_EQ(withArea("/fly?", 17), "/fly?area=17");
  EXPECT_EQ(withArea("/alps/fly?a=b&token=t", 17), "/alps/fly?a=b&token=t&area=17");
  EXPECT_EQ(withArea("/fly?area=3&subarea=4&area=5", 0), "/fly?subarea=4&area=0");
  EXPECT_EQ(withArea(withArea("/fly?a", 1), 2), withArea("/fly?a", 2));
}

TEST(WebSocketClient, SaysSoWhenNobodyListens) {
  const auto client = WebSocketClient::connect("ws://127.0.0.1:1", std::chrono::seconds(5));
  ASSERT_FALSE(client.ok());
  EXPECT_NE(client.error().message.find("cannot connect"), std::string::npos) << client.error().message;
}

}  // namespace
}  // namespace foreland::client
