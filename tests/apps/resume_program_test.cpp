// The server is killed under twenty flying clients and started again: all fly on from the sections that they hold.
#include <gtest/gtest.h>

#include <deque>
#include <nlohmann/json.hpp>

#include "tests/server/net/client.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

constexpr int kClients = 20;

// Until all clients are there, and then each has had so many keyframes more on average.
void waitForKeyframes(uint16_t port, int each) {
  ASSERT_TRUE(eventually([&] { return metric(port, "sessions") >= kClients; }));
  const double before = metric(port, "keyframes_total");
  ASSERT_TRUE(eventually([&] { return metric(port, "keyframes_total") >= before + kClients * each; }));
}

TEST(ResumeProgram, TwentyClientsFlyOnWhenTheServerIsKilledAndStartedAgain) {
  const TemporaryFolder folder;
  const std::string scene = folder / "land.fls";
  FormulaSource source(257, 257, hills(8));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());

  std::optional<Program> server(std::in_place, "serve",
                                std::vector<std::string>{scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const uint16_t port = portOf(server->readLine());
  const std::string address = "127.0.0.1:" + std::to_string(port);
  std::deque<Program> clients;
  for (int i = 0; i < kClients; ++i)
    clients.emplace_back(
        "fly",
        std::vector<std::string>{"ws://" + address, "--tour", i % 2 == 0 ? "survey" : "orbit", "--seconds", "15",
                                 "--viewport", "320x240", "--keyframe-ms", "250", "--json"},
        ProgramOptions{.streams = Streams::kOutputOnly});
  waitForKeyframes(port, 8);
  server->signal(SIGKILL);
  EXPECT_EQ(server->wait(), -1);

  server.emplace("serve", std::vector<std::string>{scene, "--listen", address, "--log-level", "off"});
  ASSERT_EQ(portOf(server->readLine()), port);
  for (Program& client : clients) {
    const std::string output = client.readToEnd();
    EXPECT_EQ(client.wait(), 0) << output;  // a section unlike the server's would have ended it
    const auto report = nlohmann::json::parse(output, nullptr, false);
    ASSERT_FALSE(report.is_discarded()) << output;
    EXPECT_EQ(report["resumed"], 1);
    EXPECT_EQ(report["started_afresh"], 0);
  }
}

}  // namespace
}  // namespace foreland::test
