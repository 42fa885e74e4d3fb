// `foreland link` as people run it: a flight through it, and what it says about bad input. When bytes arrive is tested
// in lab/tests/proxy.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

TEST(LinkProgram, CarriesAFlightToItsEnd) {
  const TemporaryFolder folder;
  const std::string scene = folder / "land.fls";
  FormulaSource source(129, 129, hills(8));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  Program server("serve", {scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string to = "127.0.0.1:" + std::to_string(portOf(server.readLine()));
  Program link("link", {"--listen", "127.0.0.1:0", "--to", to, "--model", "lte", "--seed", "3"});
  const std::string line = link.readLine();
  EXPECT_NE(line.find("link 'lte' to " + to), std::string::npos) << line;
  const ProgramResult flown = runProgram(
      "fly", {"ws://127.0.0.1:" + std::to_string(portOf(line)), "--seconds", "1", "--viewport", "320x240", "--json"},
      {.streams = Streams::kOutputOnly});
  EXPECT_EQ(flown.exit_code, 0) << flown.output;
  EXPECT_GT(nlohmann::json::parse(flown.output, nullptr, false).value("keyframes", 0), 0) << flown.output;
  link.signal(SIGTERM);
  EXPECT_EQ(link.wait(), 0);
}

TEST(LinkProgram, RefusesWhatCannotBeUsedByName) {
  const TemporaryFolder folder;
  const std::string trace = folder / "up.trace";
  std::ofstream(trace) << "5\n4\n";
  expectRefusal("link", {"--model", "pigeon"}, {"--model", "'pigeon'", "starlink"});
  expectRefusal("link", {"--trace-up", folder / "none"}, {(folder / "none").string()});
  expectRefusal("link", {"--trace-down", trace}, {trace + ":2"});
  expectRefusal("link", {"--listen", "nowhere:1"}, {"--listen", "nowhere"});
  expectRefusal("link", {"--to", "nowhere:1"}, {"--to", "nowhere"});
  expectRefusal("link", {"--to", "127.0.0.1:0"}, {"--to", "127.0.0.1:0"});
  expectRefusal("link", {"--loss", "nan"}, {"--loss"});
  expectRefusal("link", {"--stall", "100", "--stall-every", "0.05"}, {"--stall-every"});
  Program other("link", {"--listen", "127.0.0.1:0"});
  const std::string used = "127.0.0.1:" + std::to_string(portOf(other.readLine()));
  expectRefusal("link", {"--listen", used}, {used, "another program uses the port"});
}

}  // namespace
}  // namespace foreland::test
