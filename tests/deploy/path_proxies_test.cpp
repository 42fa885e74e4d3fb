// A server behind nginx and behind Caddy, with the configurations of deploy/: the page is under a path, viewers connect
// beside it, and nobody passes for another address. And behind an nginx that passes no WebSocket on.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "terrain/pipeline/build.h"
#include "tests/deploy/proxy.h"
#include "tests/server/net/client.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

constexpr const char* kNginxProgram = "/usr/sbin/nginx";  // Debian's
constexpr const char* kCaddyProgram = "/usr/bin/caddy";

class BehindAPath : public testing::Test {
 protected:
  void SetUp() override {
    FormulaSource source(65, 65, hills(1));
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "land.fls", 0.1, 1}).ok());
    std::filesystem::create_directory(folder_ / "web");
    std::ofstream(folder_ / "web/index.html") << "<html>the page</html>";
    server_.emplace("serve", std::vector<std::string>{folder_ / "land.fls", "--listen", "127.0.0.1:0", "--web",
                                                      folder_ / "web", "--trusted-proxy", "127.0.0.1",
                                                      "--max-per-address", "1", "--log-level", "off"});
    port_ = portOf(server_->readLine());
    ASSERT_GT(port_, 0);
  }

  // nginx with the content of its block `http`.
  void startNginx(const std::string& http) {
    ASSERT_TRUE(std::filesystem::exists(kNginxProgram)) << "install it: tools/install_packages.sh test";
    std::string temporary;
    for (const char* kind : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"})
      temporary += std::string(kind) + "_temp_path " + (folder_ / kind).string() + ";\n";
    std::ofstream(folder_ / "nginx.conf") << "daemon off; master_process off; pid " << (folder_ / "pid").string()
                                          << ";\nevents {}\nhttp {\naccess_log off;\n"
                                          << temporary << http << "}\n";
    proxy_.emplace(kNginxProgram, std::vector<std::string>{"-p", folder_.path(), "-c", folder_ / "nginx.conf", "-e",
                                                           folder_ / "error.log"});
  }
  void startCaddy() {
    ASSERT_TRUE(std::filesystem::exists(kCaddyProgram)) << "install it: tools/install_packages.sh test";
    std::ofstream(folder_ / "Caddyfile") << "{\n\tadmin off\n}\n" << textOf(shipped("Caddyfile"));
    ::setenv("FORELAND_PUBLIC", (":" + std::to_string(public_)).c_str(), 1);
    ::setenv("FORELAND_A", local(port_).c_str(), 1);
    ::setenv("XDG_DATA_HOME", folder_.path().c_str(), 1);
    ::setenv("XDG_CONFIG_HOME", folder_.path().c_str(), 1);
    proxy_.emplace(kCaddyProgram,
                   std::vector<std::string>{"run", "--adapter", "caddyfile", "--config", folder_ / "Caddyfile"});
  }
  static std::filesystem::path shipped(const std::string& name) {
    return std::filesystem::path(FORELAND_SOURCE_DIR) / "deploy" / name;
  }
  bool answers(const std::string& path, const std::string& words) const {
    return eventually([&] { return httpGet(public_, path).find(words) != std::string::npos; });
  }
  ProgramResult fly(const std::string& path) const {
    return runProgram("fly",
                      {"ws://" + local(public_) + path, "--tour", "orbit", "--seconds", "1", "--viewport", "320x240"});
  }
  // The status of a viewer's handshake with further fields.
  std::string handshake(std::vector<Socket>& open, const std::string& fields) const {
    Socket& socket = open.emplace_back(public_);
    socket.send(
        "GET /terrain/fly HTTP/1.1\r\nHost: test\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
        fields + "\r\n");
    return socket.receive(12).value_or("").substr(9);
  }

  TemporaryFolder folder_;
  uint16_t public_ = freePort(), port_ = 0;
  std::optional<Program> server_, proxy_;
};

enum class Kind : uint8_t { kNginx, kCaddy };
void PrintTo(Kind kind, std::ostream* out) { *out << (kind == Kind::kNginx ? "nginx" : "Caddy"); }

class ShippedProxy : public BehindAPath, public testing::WithParamInterface<Kind> {
 protected:
  void SetUp() override {
    BehindAPath::SetUp();
    if (GetParam() == Kind::kCaddy) {
      startCaddy();
    } else {
      std::string text = textOf(shipped("nginx.conf"));
      for (const auto& [from, to] : {std::pair{"127.0.0.1:8080", local(public_)}, {"127.0.0.1:8081", local(port_)}}) {
        const size_t at = text.find(std::string(from) + (to == local(port_) ? "/" : ";"));
        ASSERT_NE(at, std::string::npos) << from;
        text.replace(at, std::string(from).size(), to);
      }
      startNginx(text);
    }
  }
};

TEST_P(ShippedProxy, HasThePageUnderAPathAndViewersBesideIt) {
  EXPECT_TRUE(answers("/terrain/", "the page"));
  const std::string without_slash = httpGet(public_, "/terrain");
  EXPECT_NE(without_slash.find("/terrain/\r\n"), std::string::npos) << without_slash;
  for (const char* path : {"/terrain/", "/terrain/fly"}) {
    const ProgramResult flown = fly(path);
    EXPECT_EQ(flown.exit_code, 0) << flown.output;
  }
}

// Two viewers of one client, who names another address each time. The proxy's own connections are not limited, so both
// would be let in if they were believed: as one address, of which the server takes one connection.
TEST_P(ShippedProxy, BelievesNobodyThatHeIsAnother) {
  ASSERT_TRUE(answers("/terrain/livez", "ok"));
  std::vector<Socket> open;
  for (const char* field : {"X-Forwarded-For: 198.51.100.7\r\n", "X-Forwarded-For: 198.51.100.7\r\n",
                            "Forwarded: for=198.51.100.7\r\n", "Forwarded: for=198.51.100.7\r\n"})
    EXPECT_EQ(handshake(open, field), "101") << field << " is believed";
}

INSTANTIATE_TEST_SUITE_P(All, ShippedProxy, testing::Values(Kind::kNginx, Kind::kCaddy),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

// nginx as it is without a word of WebSockets.
TEST_F(BehindAPath, SaysWhatAProxyLacksThatPassesNoUpgradeOn) {
  startNginx("server { listen " + local(public_) + "; location / { proxy_pass http://" + local(port_) + "; } }");
  ASSERT_TRUE(answers("/livez", "ok"));
  const ProgramResult flown = fly("/");
  EXPECT_EQ(flown.exit_code, 2);
  for (const char* words : {"HTTP 426", "does not pass that on", "proxy_set_header Upgrade"})
    EXPECT_NE(flown.output.find(words), std::string::npos) << words << ": " << flown.output;
}

// As gateways write the address of whom they pass on, with its port.
TEST_F(BehindAPath, CountsForAnAddressThatComesWithItsPort) {
  startNginx("server { listen " + local(public_) + "; location /terrain/ { proxy_pass http://" + local(port_) +
             "/; proxy_http_version 1.1; proxy_set_header Upgrade $http_upgrade; proxy_set_header Connection "
             "\"upgrade\"; proxy_set_header X-Forwarded-For 10.0.0.1:$remote_port; } }");
  ASSERT_TRUE(answers("/terrain/livez", "ok"));
  std::vector<Socket> open;
  EXPECT_EQ(handshake(open, ""), "101");
  EXPECT_EQ(handshake(open, ""), "503");
}

}  // namespace
}  // namespace foreland::test
