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

// Servers of a fleet by their addresses, as a test has no name server. Their viewers of one scene are at one server,
// and no server has more than a quarter above the mean.
TEST(HaproxyFleet, LeadsViewersOfASceneToOneServer) {
  ASSERT_TRUE(std::filesystem::exists(kHaproxy)) << "install it: tools/install_packages.sh test";
  const TemporaryFolder folder;
  const std::vector<std::string> scenes{"alps", "fuji", "helens"};
  std::vector<std::string> words;
  for (size_t i = 0; i < scenes.size(); ++i) {
    FormulaSource source(65, 65, hills(static_cast<uint64_t>(i)));
    words.push_back(folder / (scenes[i] + ".fls"));
    ASSERT_TRUE(terrain::buildScene(source, {words.back(), 0.1, 1}).ok());
  }
  words.insert(words.end(), {"--log-level", "off", "--listen", local(0), "--agent-listen", ""});

  std::vector<std::unique_ptr<Program>> servers;
  std::vector<uint16_t> ports;
  std::string lines;
  for (const char* name : {"a", "b"}) {
    const uint16_t agent = freePort();
    words.back() = local(agent);
    servers.push_back(std::make_unique<Program>("serve", words));
    ports.push_back(portOf(servers.back()->readLine()));
    lines +=
        "server " + std::string(name) + " " + local(ports.back()) + " agent-port " + std::to_string(agent) + "\n  ";
  }
  const std::filesystem::path shipped = std::filesystem::path(FORELAND_SOURCE_DIR) / "deploy/haproxy-fleet.cfg";
  const std::string few = std::regex_replace(textOf(shipped), std::regex("maxconn [0-9]+"), "maxconn 100");
  std::ofstream(folder / "fleet.cfg") << std::regex_replace(few, std::regex("server-template [^\n]*"), lines);
  const uint16_t open = freePort();
  ::setenv("FORELAND_PUBLIC", local(open).c_str(), 1);
  Program proxy(kHaproxy, {"-q", "-f", folder / "fleet.cfg"});

  constexpr int kOfEach = 2;
  std::vector<std::unique_ptr<Program>> flights;
  const auto flying = [&] { return metric(ports[0], "flying") + metric(ports[1], "flying"); };
  for (const std::string& scene : scenes) {
    // Until the proxy has looked at its servers it answers for them.
    ASSERT_TRUE(eventually([&] { return httpGet(open, "/" + scene + "/fly").find(" 426 ") != std::string::npos; }))
        << httpGet(open, "/" + scene + "/fly");
    flights.push_back(std::make_unique<Program>(
        "fly",
        std::vector<std::string>{"ws://" + local(open) + "/" + scene + "/", "--viewers", std::to_string(kOfEach),
                                 "--tour", "survey", "--seconds", "20", "--viewport", "320x240"},
        ProgramOptions{.streams = Streams::kOutputOnly}));
    const double before = kOfEach * static_cast<double>(flights.size());
    ASSERT_TRUE(eventually([&] { return flying() >= before; })) << scene;
  }

  size_t pairs = 0;
  for (const uint16_t port : ports) {
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

}  // namespace
}  // namespace foreland::test
