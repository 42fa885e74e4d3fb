// Who is let in: pages by their origin, viewers by their tokens, and whom a proxy speaks for.
#include "server/net/access/gate.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <deque>
#include <string>

namespace foreland::server {
namespace {

constexpr int64_t kNow = 1'800'000'000;
const std::string kSecret(48, 's');

Token tokenOf(const std::string& name, int64_t expires_s = kNow + 60) { return {.name = name, .expires_s = expires_s}; }

TEST(Token, IsReadAsItWasSigned) {
  const Token token{.name = "M\xc3\xbcller \"x\"", .expires_s = kNow + 1, .viewers = 3, .section_nodes = 1000};
  const auto read = verifyToken(signToken(token, kSecret), kSecret, kNow);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->name, token.name);
  EXPECT_EQ(read->expires_s, token.expires_s);
  EXPECT_EQ(read->viewers, token.viewers);
  EXPECT_EQ(read->section_nodes, token.section_nodes);
}

// Made by another library: RFC 7515, appendix A.1, has no name, so the signature is accepted and the claims are not.
TEST(Token, AgreesWithTheExampleOfTheStandard) {
  const std::string key =
      "\x03\x23\x35\x4b\x2b\x0f\xa5\xbc\x83\x7e\x06\x65\x77\x7b\xa6\x8f\x5a\xb3\x28\xe6\xf0\x54\xc9\x28\xa9\x0f\x84\xb2"
      "\xd2\x50\x2e\xbf\xd3\xfb\x5a\x92\xd2\x06\x47\xef\x96\x8a\xb4\xc3\x77\x62\x3d\x22\x3d\x2e\x21\x72\x05\x2e\x4f\x08"
      "\xc0\xcd\x9a\xf5\x67\xd0\x80\xa3";
  const std::string text =
      "eyJ0eXAiOiJKV1QiLA0KICJhbGciOiJIUzI1NiJ9.eyJpc3MiOiJqb2UiLA0KICJleHAiOjEzMDA4MTkzODAsDQogImh0dHA6Ly9leGFt"
      "cGxlLmNvbS9pc19yb290Ijp0cnVlfQ.dBjftJeZ4CVP-mB92K27uhbUJU1p1r_wW1gFWFOEjXk";
  const auto read = verifyToken(text, key, 1'300'000'000);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().message, "the token is malformed");
}

TEST(Token, IsRefusedIfAnyByteIsChanged) {
  const std::string good = signToken(tokenOf("a"), kSecret);
  ASSERT_TRUE(verifyToken(good, kSecret, kNow).ok());
  for (size_t i = 0; i < good.size(); ++i)
    for (const char c : {'A', 'z', '.', '=', '\0'}) {
      std::string changed = good;
      changed[i] = c;
      const bool is_same = changed == good;
      // The last character of a signature has two bits that mean nothing.
      if (i + 1 < good.size()) { EXPECT_EQ(verifyToken(changed, kSecret, kNow).ok(), is_same) << changed; }
    }
  for (size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(verifyToken(good.substr(0, size), kSecret, kNow).ok()) << size;
  EXPECT_FALSE(verifyToken(good, std::string(48, 't'), kNow).ok());
}

TEST(Token, ExpiresAndIsOfNoOtherKind) {
  EXPECT_FALSE(verifyToken(signToken(tokenOf("a", kNow), kSecret), kSecret, kNow).ok());
  EXPECT_FALSE(verifyToken("eyJhbGciOiJub25lIn0.eyJzdWIiOiJhIiwiZXhwIjo5OTk5OTk5OTk5fQ.", kSecret, kNow).ok());
}

class GateTest : public testing::Test {
 protected:
  static std::variant<Pass, Rejection> visit(Gate& gate, const std::string& token) {
    const std::string target = "/fly?a=b&token=" + token + "&c=d";
    return gate.admit({.target = target}, kNow);
  }
  static unsigned statusOf(const std::variant<Pass, Rejection>& result) {
    const auto* rejection = std::get_if<Rejection>(&result);
    return rejection ? rejection->status : 101;
  }
};

TEST_F(GateTest, LetsEverybodyInUnlessToldOtherwise) {
  Gate gate({});
  EXPECT_EQ(statusOf(gate.admit({.origin = "https://evil.example"}, kNow)), 101u);
}

TEST_F(GateTest, AsksForTheOrigin) {
  Gate gate({.allowed_origins = {"https://maps.example"}});
  const auto from = [&](const char* origin) {
    return statusOf(gate.admit({.origin = origin, .host = "own.example:8080"}, kNow));
  };
  EXPECT_EQ(from("https://maps.example"), 101u);
  EXPECT_EQ(from("https://own.example:8080"), 101u) << "its own page";
  EXPECT_EQ(from(""), 101u) << "not a browser";
  for (const char* other : {"https://maps.example.evil", "http://maps.example", "https://own.example", "null", "://"})
    EXPECT_EQ(from(other), 403u) << other;
}

TEST_F(GateTest, AsksForATokenInTheHeaderOrInTheQuery) {
  Gate gate({.token_secret = kSecret});
  const std::string token = signToken(tokenOf("a"), kSecret), header = "Bearer " + token;
  EXPECT_EQ(statusOf(gate.admit({.target = "/fly", .authorization = header}, kNow)), 101u);
  EXPECT_EQ(statusOf(visit(gate, token)), 101u);
  EXPECT_EQ(statusOf(gate.admit({.target = "/fly?token=" + token + "&area=17"}, kNow)), 101u);
  EXPECT_EQ(statusOf(gate.admit({.target = "/fly?mytoken=" + token}, kNow)), 401u);
  EXPECT_EQ(statusOf(visit(gate, "")), 401u);
  EXPECT_EQ(statusOf(visit(gate, signToken(tokenOf("a", kNow - 1), kSecret))), 401u);
}

TEST_F(GateTest, CountsTheViewersOfAName) {
  Gate gate({.token_secret = kSecret});
  Token token = tokenOf("a");
  token.viewers = 2;
  const std::string text = signToken(token, kSecret);
  std::deque<std::variant<Pass, Rejection>> inside;
  for (int i = 0; i < 2; ++i) EXPECT_EQ(statusOf(inside.emplace_back(visit(gate, text))), 101u);
  EXPECT_EQ(statusOf(visit(gate, text)), 503u);
  EXPECT_EQ(statusOf(visit(gate, signToken(tokenOf("b"), kSecret))), 101u) << "another name";
  inside.pop_back();
  EXPECT_EQ(statusOf(visit(gate, text)), 101u);
}

TEST_F(GateTest, BelievesProxiesThatItTrustsAndNobodyElse) {
  const Gate gate({.trusted_proxies = {"127.0.0.1", "10.0.0.0/8", "fd00::/16"}});
  EXPECT_EQ(gate.clientOf("127.0.0.1", "198.51.100.7"), "198.51.100.7");
  EXPECT_EQ(gate.clientOf("127.0.0.1", "1.2.3.4, 198.51.100.7 ,10.255.0.1"), "198.51.100.7") << "the first is hearsay";
  EXPECT_EQ(gate.clientOf("fd00::1", "2001:db8::1"), "2001:db8::1");
  EXPECT_EQ(gate.clientOf("11.0.0.1", "198.51.100.7"), "11.0.0.1") << "not trusted";
  EXPECT_EQ(gate.clientOf("127.0.0.1", ""), "127.0.0.1");
  EXPECT_EQ(gate.clientOf("127.0.0.1", "bogus\x01"), "127.0.0.1");
}

// Azure's gateways add the port, as RFC 7239 allows; each connection has another one.
TEST_F(GateTest, LeavesOutPortsAndBrackets) {
  const Gate gate({.trusted_proxies = {"127.0.0.1", "10.0.0.0/8", "fd00::/16"}});
  const auto client = [&](const char* list) { return gate.clientOf("127.0.0.1", list); };
  EXPECT_EQ(client("198.51.100.7:9001"), "198.51.100.7");
  EXPECT_EQ(client("[2001:db8::1]:9001"), "2001:db8::1");
  EXPECT_EQ(client("[2001:db8::1]"), "2001:db8::1");
  EXPECT_EQ(client("2001:db8::1"), "2001:db8::1");
  EXPECT_EQ(client("[::ffff:198.51.100.7]:1"), "198.51.100.7");
  EXPECT_EQ(client("198.51.100.7:1, 10.1.2.3:4444, [fd00::2]:5"), "198.51.100.7") << "proxies of ours with ports";
  for (const char* none : {"198.51.100.7:80:90", "[2001:db8::1", "[2001:db8::1]80", "[]", "[", "]", ":", "\"", "\"\""})
    EXPECT_EQ(client(none), "127.0.0.1") << none;
}

TEST_F(GateTest, ReadsTheForwardedField) {
  const Gate gate({.trusted_proxies = {"127.0.0.1", "10.0.0.0/8"}});
  const auto client = [&](const char* list) { return gate.clientOf("127.0.0.1", list); };
  EXPECT_EQ(client("for=192.0.2.60"), "192.0.2.60");
  EXPECT_EQ(client("by=203.0.113.43;For=\"192.0.2.60:4711\" ; proto=https"), "192.0.2.60");
  EXPECT_EQ(client("for=1.2.3.4, for=\"[2001:db8:cafe::17]:4711\";proto=http, for=10.2.2.2"), "2001:db8:cafe::17");
  EXPECT_EQ(client("for=\"_hidden-7.b\""), "_hidden-7.b") << "a name that the proxy has made up";
  for (const char* none : {"for=unknown", "proto=https", "for=", "for", "=", ";=;", "for=_a b", "for=_\x01"})
    EXPECT_EQ(client(none), "127.0.0.1") << none;
}

// What clients write comes before what the proxy adds.
TEST_F(GateTest, NothingThatAClientMakesUpHidesWhatItsProxyAdds) {
  const Gate gate({.trusted_proxies = {"127.0.0.1"}});
  for (const char* made_up : {"for=\"", "for=\"\\", "\"", "for=[", "for=1.2.3.4;by=\"", ","})
    EXPECT_EQ(gate.clientOf("127.0.0.1", std::string(made_up) + ", for=198.51.100.7"), "198.51.100.7") << made_up;
}

TEST_F(GateTest, AnyListGivesAnAddressOrAMadeUpName) {
  const Gate gate({.trusted_proxies = {"127.0.0.1"}});
  EXPECT_TRUE(rc::check([&](const std::string& text) {
    for (const char* before : {"", "for=", "for=\"[", "["}) {
      const std::string client = gate.clientOf("127.0.0.1", before + text);
      boost::system::error_code error;
      boost::asio::ip::make_address(client, error);
      RC_ASSERT(!error || client.starts_with('_'));
    }
  }));
}

TEST_F(GateTest, ComparesAddressesHoweverTheyAreWritten) {
  const Gate gate({.trusted_proxies = {"10.0.0.0/8"}});
  const auto text = [](const char* address) { return addressText(boost::asio::ip::make_address(address)); };
  EXPECT_EQ(text("::ffff:10.1.2.3"), "10.1.2.3");
  EXPECT_EQ(text("10.1.2.3"), "10.1.2.3");
  EXPECT_EQ(text("2001:db8::1"), "2001:db8::1");
  EXPECT_EQ(gate.clientOf("10.1.2.3", "198.51.100.7, ::ffff:10.9.9.9"), "198.51.100.7");
}

TEST_F(GateTest, CountsACustomerOfIpv6Once) {
  EXPECT_EQ(networkOf("198.51.100.7"), "198.51.100.7");
  EXPECT_EQ(networkOf("2001:db8:1:2:3:4:5:6"), networkOf("2001:db8:1:2::"));
  EXPECT_NE(networkOf("2001:db8:1:2::1"), networkOf("2001:db8:1:3::1"));
  EXPECT_EQ(networkOf(""), "");
}

TEST_F(GateTest, NamesFlagsWithBadValues) {
  for (const char* origin : {"example.org", "https://", "https://a/b", ""})
    EXPECT_NE(check({.allowed_origins = {origin}}).error().message.find("--allow-origin"), std::string::npos);
  for (const char* proxy : {"proxy.example", "10.0.0.0/33", "10.0.0.0/", "10.0.0.0/x", "::/129", ""})
    EXPECT_NE(check({.trusted_proxies = {proxy}}).error().message.find("--trusted-proxy"), std::string::npos) << proxy;
}

}  // namespace
}  // namespace foreland::server
