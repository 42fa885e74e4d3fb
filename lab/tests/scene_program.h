// `foreland bench COMMAND` on a tiny scene, run as a program of its own.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "lab/programs/run_program.h"
#include "tests/support/scene.h"

namespace foreland::test {

class SceneProgram : public testing::Test {
 protected:
  // The scene has `side` samples a side.
  SceneProgram(std::string command, uint32_t side) : command_(std::move(command)), side_(side) {}

  void SetUp() override {
    FormulaSource source(side_, side_, hills(3));
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1}).ok());
  }
  Result<std::string> run(const std::vector<std::string>& more) const {
    std::vector<std::string> words{FORELAND_BIN_DIR "/foreland-bench", command_, folder_ / "scene.fls"};
    words.insert(words.end(), more.begin(), more.end());
    return lab::runProgram(words);
  }
  // What it reports of a flight of some seconds.
  nlohmann::json report(int seconds, std::vector<std::string> more) const {
    more.insert(more.end(), {"--seconds", std::to_string(seconds), "--json"});
    const auto text = run(more);
    EXPECT_TRUE(text.ok());
    return text.ok() ? nlohmann::json::parse(*text) : nlohmann::json();
  }

  TemporaryFolder folder_;

 private:
  std::string command_;
  uint32_t side_;
};

}  // namespace foreland::test
