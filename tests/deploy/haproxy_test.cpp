// Two servers behind HAProxy with the configurations of deploy/: whichever stops, dies or is replaced, its viewers
// resume at the other one, and none starts afresh; viewers of one scene meet.
//
// FORELAND_VIEWERS says how many fly (12), FORELAND_FLY_SECONDS for how long. What they noticed is printed.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "terrain/pipeline/build.h"
#include "tests/deploy/proxy.h"
#include "tests/server/net/client.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

constexpr const char* kHaproxy = "/usr/sbin/haproxy";  // Debian's

int fromEnvironment(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

class BehindHaproxy : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(std::filesystem::exists(kHaproxy)) << "install it: tools/install_packages.sh test";
    FormulaSource source(257, 257, hills(8));
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "land.fls", 0.1, 1}).ok());
    start(0);
    start(1);
    startProxy();
    ASSERT_TRUE(eventually([&] { return isUp("a") && isUp("b"); }));
  }

  void start(size_t i) {
    const std::string listen = local(ports_[i]);
    servers_[i].emplace("serve", std::vector<std::string>{folder_ / "land.fls", "--listen", listen, "--agent-listen",
                                                          local(agents_[i]), "--trusted-proxy", "127.0.0.1",
                                                          "--drain-seconds", "10", "--log-level", "off"});
    ports_[i] = portOf(servers_[i]->readLine());
    ASSERT_GT(ports_[i], 0);
  }

  // The configuration as it is shipped, and a page that tells which servers HAProxy believes to be up.
  void startProxy() {
    const std::filesystem::path shipped = std::filesystem::path(FORELAND_SOURCE_DIR) / "deploy/haproxy.cfg";
    std::ofstream(folder_ / "haproxy.cfg") << textOf(shipped) << "\nlisten statistics\n  bind " << local(statistics_)
                                           << "\n  stats enable\n  stats uri /\n";
    ::setenv("FORELAND_PUBLIC", local(public_).c_str(), 1);
    ::setenv("FORELAND_A", local(ports_[0]).c_str(), 1);
    ::setenv("FORELAND_B", local(ports_[1]).c_str(), 1);
    ::setenv("FORELAND_A_AGENT", std::to_string(agents_[0]).c_str(), 1);
    ::setenv("FORELAND_B_AGENT", std::to_string(agents_[1]).c_str(), 1);
    proxy_.emplace(kHaproxy, std::vector<std::string>{"-q", "-f", folder_ / "haproxy.cfg"});
  }

  // A server's line of HAProxy's table.
  std::string stateOf(const std::string& server) const {
    const std::string table = httpGet(statistics_, "/;csv");
    const size_t at = table.find("\nready," + server + ",");
    return at == std::string::npos ? "" : table.substr(at + 1, table.find('\n', at + 1) - at);
  }
  bool isUp(const std::string& server) const { return stateOf(server).find(",UP,") != std::string::npos; }

  // Begins to fly, and returns when every viewer has been sent keyframes.
  void fly() {
    viewers_.emplace(
        "fly",
        std::vector<std::string>{"ws://" + local(public_), "--viewers", std::to_string(count_), "--tour", "survey",
                                 "--seconds", seconds_, "--viewport", "320x240", "--keyframe-ms", "250", "--json"},
        ProgramOptions{.streams = Streams::kOutputOnly});
    ASSERT_TRUE(eventually([&] { return metric(ports_[0], "flying") + metric(ports_[1], "flying") >= count_; }));
    ASSERT_GT(metric(ports_[0], "flying"), 0);
    ASSERT_GT(metric(ports_[1], "flying"), 0);
  }

  // All have flown to the end, at least `resumed` times from what they held and never from nothing.
  void expectResumed(int resumed) {
    const std::string output = viewers_->readToEnd();
    EXPECT_EQ(viewers_->wait(), 0) << output;
    const auto report = nlohmann::json::parse(output, nullptr, false);
    ASSERT_FALSE(report.is_discarded()) << output;
    EXPECT_EQ(report["landed"], count_) << output;
    EXPECT_GE(report["resumed"], resumed) << output;
    EXPECT_EQ(report["started_afresh"], 0) << output;
    std::printf("%d viewers, %d resumed; longest gap between keyframes: median %.0f ms, p99 %.0f ms, all %.0f ms\n",
                count_, report["resumed"].get<int>(), report["longest_gap_p50_ms"].get<double>(),
                report["longest_gap_p99_ms"].get<double>(), report["longest_gap_ms"].get<double>());
  }

  // A new one takes the stopped one's place and is sent viewers.
  void replace(size_t i, const std::string& name) {
    servers_[i]->signal(SIGTERM);
    ASSERT_EQ(servers_[i]->wait(), 0);
    start(i);
    ASSERT_TRUE(eventually([&] { return isUp(name); }));
  }

  const int count_ = fromEnvironment("FORELAND_VIEWERS", 12);
  const std::string seconds_ = std::to_string(fromEnvironment("FORELAND_FLY_SECONDS", 10));
  TemporaryFolder folder_;
  uint16_t public_ = freePort(), statistics_ = freePort();
  uint16_t ports_[2] = {0, 0}, agents_[2] = {freePort(), freePort()};
  std::optional<Program> servers_[2];
  std::optional<Program> proxy_;
  std::optional<Program> viewers_;
};

TEST_F(BehindHaproxy, ViewersOfAServerThatStopsResumeAtTheOther) {
  fly();
  const double moved = metric(ports_[0], "sessions");
  servers_[0]->signal(SIGTERM);
  EXPECT_EQ(servers_[0]->wait(), 0);
  EXPECT_TRUE(eventually([&] { return metric(ports_[1], "sessions") == count_; }));
  expectResumed(static_cast<int>(moved));
}

TEST_F(BehindHaproxy, ViewersOfAServerThatIsKilledResumeAtTheOther) {
  fly();
  const double moved = metric(ports_[0], "sessions");
  servers_[0]->signal(SIGKILL);
  EXPECT_EQ(servers_[0]->wait(), -1);
  EXPECT_TRUE(eventually([&] { return metric(ports_[1], "sessions") == count_; }));
  expectResumed(static_cast<int>(moved));
}

// With the checks: no server is busy. What a client says of the fleet through the proxy is not passed on.
TEST_F(BehindHaproxy, ServersAreToldHowBusyTheFleetIs) {
  for (const uint16_t port : ports_) EXPECT_TRUE(eventually([&] { return metric(port, "fleet_load") == 0; }));
  const std::string made_up = "X-Haproxy-Server-State: UP; weight=1/1\r\nX-Foreland-Servers: 1\r\n";
  EXPECT_NE(httpGet(public_, "/readyz", made_up).find(" 200 "), std::string::npos);
  for (const uint16_t port : ports_) EXPECT_EQ(metric(port, "fleet_load"), 0);
  EXPECT_NE(httpGet(ports_[0], "/readyz", made_up).find(" 200 "), std::string::npos);
  EXPECT_GT(metric(ports_[0], "fleet_load"), 0) << "who is trusted is believed";
}

// The agent's answer has been taken, and leaves each server all of its weight, for nobody flies.
TEST_F(BehindHaproxy, ServersTellItHowBusyTheyAre) {
  for (const std::string server : {"a", "b"}) {
    EXPECT_TRUE(eventually([&] { return stateOf(server).find(",CHECKED,") != std::string::npos; })) << stateOf(server);
    EXPECT_NE(stateOf(server).find(",UP,100,"), std::string::npos) << stateOf(server);
  }
}

TEST_F(BehindHaproxy, ViewersResumeWhenBothServersAreReplacedInTurn) {
  fly();
  replace(0, "a");
  replace(1, "b");
  expectResumed(count_);
}

// Servers of a fleet by their addresses, as a test has no name server, behind the configuration as it is shipped.
class HaproxyFleet : public testing::Test {
 protected:
  void start(const std::vector<std::string>& scenes) {
    ASSERT_TRUE(std::filesystem::exists(kHaproxy)) << "install it: tools/install_packages.sh test";
    std::vector<std::string> words;
    for (size_t i = 0; i < scenes.size(); ++i) {
      FormulaSource source(65, 65, hills(static_cast<uint64_t>(i)));
      words.push_back(folder_ / (scenes[i] + ".fls"));
      ASSERT_TRUE(terrain::buildScene(source, {words.back(), 0.1, 1}).ok());
    }
    words.insert(words.end(), {"--log-level", "off", "--listen", local(0), "--agent-listen", ""});
    std::string lines;
    for (const char* name : {"a", "b"}) {
      const uint16_t agent = freePort();
      words.back() = local(agent);
      servers_.push_back(std::make_unique<Program>("serve", words));
      ports_.push_back(portOf(servers_.back()->readLine()));
      lines +=
          "server " + std::string(name) + " " + local(ports_.back()) + " agent-port " + std::to_string(agent) + "\n  ";
    }
    const std::filesystem::path shipped = std::filesystem::path(FORELAND_SOURCE_DIR) / "deploy/haproxy-fleet.cfg";
    const std::string few = std::regex_replace(textOf(shipped), std::regex("maxconn [0-9]+"), "maxconn 100");
    std::ofstream(folder_ / "fleet.cfg") << std::regex_replace(few, std::regex("server-template [^\n]*"), lines);
    ::setenv("FORELAND_PUBLIC", local(open_).c_str(), 1);
    proxy_.emplace(kHaproxy, std::vector<std::string>{"-q", "-f", folder_ / "fleet.cfg"});
    // Until the proxy has looked at its servers it answers for them.
    for (const std::string& scene : scenes) {
      const std::string path = scenes.size() == 1 ? "/fly" : "/" + scene + "/fly";
      ASSERT_TRUE(eventually([&] { return httpGet(open_, path).find(" 426 ") != std::string::npos; }))
          << httpGet(open_, path);
    }
  }

  // The server to which a viewer of an address is led while there is nobody else.
  size_t serverOf(const std::string& address) const {
    const auto all = [&] { return metric(ports_[0], "sessions") + metric(ports_[1], "sessions"); };
    EXPECT_TRUE(eventually([&] { return all() == 0; }));
    const WebSocketClient viewer(open_, 0, address);
    EXPECT_TRUE(viewer.isOpen()) << address << ": " << viewer.reply();
    EXPECT_TRUE(eventually([&] { return all() == 1; })) << address;
    return metric(ports_[1], "sessions") == 1;
  }

  const TemporaryFolder folder_;
  const uint16_t open_ = freePort();
  std::vector<uint16_t> ports_;
  std::vector<std::unique_ptr<Program>> servers_;
  std::optional<Program> proxy_;
};

// Of a large scene viewers of one area meet, and areas are spread. What is no area is not looked at.
TEST_F(HaproxyFleet, LeadsViewersOfAnAreaToOneServer) {
  start({"alps", "fuji"});
  const auto at = [](const std::string& area) { return "/alps/fly?x=y&area=" + area + "&token=t"; };
  size_t at_second = 0;
  constexpr size_t kAreas = 16;
  for (size_t area = 0; area < kAreas; ++area) {
    const size_t server = serverOf(at(std::to_string(area)));
    EXPECT_EQ(serverOf(at(std::to_string(area))), server) << area;
    EXPECT_EQ(serverOf("/alps/fly?area=" + std::to_string(area)), server) << area;
    at_second += server;
  }
  EXPECT_GT(at_second, 0u);
  EXPECT_LT(at_second, kAreas);
  const size_t server = serverOf("/alps/fly");
  for (size_t i = 0; i < 20; ++i) {
    const std::string text = std::to_string(i);
    for (const std::string& bad : {std::string(), "x" + text, "-" + text, text + ".5", std::string(10, '1') + text,
                                   text + "%00", "%0a" + text, text + "/"})
      EXPECT_EQ(serverOf(at(bad)), server) << bad;
  }
}

TEST_F(HaproxyFleet, LeadsViewersOfAnAreaOfTheOnlySceneToOneServer) {
  start({"alps"});
  size_t at_second = 0;
  for (size_t area = 0; area < 16; ++area) {
    const std::string address = "/fly?area=" + std::to_string(area);
    const size_t server = serverOf(address);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(serverOf(address), server) << area;
    at_second += server;
  }
  EXPECT_GT(at_second, 0u);
  EXPECT_LT(at_second, 16u);
}

// Viewers of one scene are at one server, and no server has more than a quarter above the mean.
TEST_F(HaproxyFleet, LeadsViewersOfASceneToOneServer) {
  const std::vector<std::string> scenes{"alps", "fuji", "helens"};
  start(scenes);
  constexpr int kOfEach = 2;
  std::vector<std::unique_ptr<Program>> flights;
  const auto flying = [&] { return metric(ports_[0], "flying") + metric(ports_[1], "flying"); };
  for (const std::string& scene : scenes) {
    flights.push_back(std::make_unique<Program>(
        "fly",
        std::vector<std::string>{"ws://" + local(open_) + "/" + scene + "/", "--viewers", std::to_string(kOfEach),
                                 "--tour", "survey", "--seconds", "20", "--viewport", "320x240"},
        ProgramOptions{.streams = Streams::kOutputOnly}));
    const double before = kOfEach * static_cast<double>(flights.size());
    ASSERT_TRUE(eventually([&] { return flying() >= before; })) << scene;
  }

  size_t pairs = 0;
  for (const uint16_t port : ports_) {
    EXPECT_LE(metric(port, "sessions"), std::ceil(1.25 * kOfEach * static_cast<double>(scenes.size()) / 2));
    const std::string text = httpGet(port, "/metrics");
    for (const std::string& scene : scenes) {
      const size_t at = text.find("foreland_scene_sessions{scene=\"" + scene + "\"} ");
      ASSERT_NE(at, std::string::npos) << text;
      pairs += text.substr(text.find("} ", at) + 2, 2) != "0\n";
    }
  }
  EXPECT_LE(pairs, scenes.size() + 1);  // of viewers in turn each scene would be at both
}

// A proxy that leads those who say their area to another server than those who do not, and the first one stops.
TEST(AreaOfAViewer, IsInItsAddressWhenItConnectsAgain) {
  ASSERT_TRUE(std::filesystem::exists(kHaproxy)) << "install it: tools/install_packages.sh test";
  const TemporaryFolder folder;
  FormulaSource source(4200, 65, hills(8));  // a large scene: three areas side by side
  ASSERT_TRUE(terrain::buildScene(source, {folder / "land.fls", 0.1, 1}).ok());
  std::vector<std::unique_ptr<Program>> servers;
  std::vector<uint16_t> ports;
  for (int i = 0; i < 2; ++i) {
    servers.push_back(std::make_unique<Program>(
        "serve", std::vector<std::string>{folder / "land.fls", "--listen", local(0), "--log-level", "off"}));
    ports.push_back(portOf(servers.back()->readLine()));
  }
  const uint16_t open = freePort();
  std::ofstream(folder / "proxy.cfg")
      << "global\n  maxconn 100\ndefaults\n  mode http\n  timeout connect 1s\n  timeout client 60s\n  timeout server "
         "60s\nfrontend viewers\n  bind "
      << local(open) << "\n  use_backend there if { url_param(area) 0 1 2 }\n  default_backend first\nbackend first\n"
      << "  server a " << local(ports[0]) << "\nbackend there\n  server b " << local(ports[1]) << "\n";
  const Program proxy(kHaproxy, {"-q", "-f", folder / "proxy.cfg"});
  ASSERT_TRUE(eventually([&] { return httpGet(open, "/fly").find(" 426 ") != std::string::npos; }));
  constexpr int kViewers = 3;
  Program flights("fly",
                  {"ws://" + local(open) + "/fly?area=x&a=b", "--viewers", std::to_string(kViewers), "--tour", "survey",
                   "--seconds", "6", "--viewport", "320x240", "--json"},
                  ProgramOptions{.streams = Streams::kOutputOnly});
  ASSERT_TRUE(eventually([&] { return metric(ports[0], "flying") >= kViewers; }));
  EXPECT_EQ(metric(ports[1], "sessions"), 0);
  servers[0]->signal(SIGTERM);
  EXPECT_EQ(servers[0]->wait(), 0);
  const auto report = nlohmann::json::parse(flights.readToEnd(), nullptr, false);
  EXPECT_EQ(flights.wait(), 0);
  ASSERT_FALSE(report.is_discarded());
  EXPECT_EQ(report["landed"], kViewers) << report;
  EXPECT_EQ(report["resumed"], kViewers) << report;
}

}  // namespace
}  // namespace foreland::test
