// `foreland bench sections` along what `foreland fly --record` wrote.
#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

TEST(RecordedTrack, IsMeasuredOverItsOwnSceneOnly) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.fls", other = folder / "other.fls", recording = folder / "flight.rec";
  FormulaSource source(65, 65, hills(1)), another(65, 65, hills(2));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  ASSERT_TRUE(terrain::buildScene(another, {other, 0.1, 1}).ok());
  Program server("serve", {scene, "--listen", "127.0.0.1:0", "--log-level", "off"});
  const std::string url = "ws://127.0.0.1:" + std::to_string(portOf(server.readLine()));
  const ProgramResult flown = runProgram("fly", {url, "--tour", "survey", "--seconds", "2", "--record", recording});
  ASSERT_EQ(flown.exit_code, 0) << flown.output;

  const auto benchOver = [&](const std::string& file) {
    return std::vector<std::string>{"sections", file, "--track", recording, "--seconds", "1", "--no-errors"};
  };
  const ProgramResult measured = runProgram("bench", benchOver(scene));
  EXPECT_EQ(measured.exit_code, 0) << measured.output;
  expectRefusal("bench", benchOver(other), {recording, "another scene", other});
}

}  // namespace
}  // namespace foreland::test
