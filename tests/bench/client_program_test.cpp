// `foreland bench client` on a tiny scene: the report has the keys of bench/README.md.
#include <nlohmann/json.hpp>

#include "bench/programs/run_program.h"
#include "tests/support/scene.h"

namespace foreland::bench {
namespace {

class ClientProgram : public testing::Test {
 protected:
  void SetUp() override {
    test::FormulaSource source(257, 257, test::hills(3));
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1}).ok());
  }
  nlohmann::json report(std::vector<std::string> more) const {
    std::vector<std::string> words{
        FORELAND_BIN_DIR "/foreland-bench", "client", folder_ / "scene.fls", "--seconds", "4", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const auto text = runProgram(words);
    EXPECT_TRUE(text.ok());
    return text.ok() ? nlohmann::json::parse(*text) : nlohmann::json();
  }
  test::TemporaryFolder folder_;
};

TEST_F(ClientProgram, SaysWhyThereAreNoFiguresOfWebAssembly) {
  const nlohmann::json costs = report({"--wasm-mesher", folder_ / "none.wasm"});
  EXPECT_NE(costs.at("wasm_skipped").get<std::string>().find("none.wasm is not built"), std::string::npos);
  EXPECT_FALSE(costs.contains("wasm_mesh_ms_p50"));
  EXPECT_GT(costs.at("changes"), 0);
  EXPECT_GT(costs.at("upload_share"), 0);
  EXPECT_LT(costs.at("upload_share"), 1);
  EXPECT_GT(costs.at("mesh_ratio"), 0);
}

// It fails if a mesh has other triangles there than the one that is made for this machine.
TEST_F(ClientProgram, MakesMeshesInWebAssembly) {
  const nlohmann::json costs = report({});
  if (costs.contains("wasm_skipped")) GTEST_SKIP() << costs.at("wasm_skipped");
  for (const char* key : {"mesh_ms_p50", "mesh_ms_p99", "mesh_us_per_change", "full_mesh_ms", "mesh_ratio",
                          "decode_ms_p50", "mesh_memory_bytes"})
    EXPECT_GT(costs.at(std::string("wasm_") + key), 0) << key;
}

}  // namespace
}  // namespace foreland::bench
