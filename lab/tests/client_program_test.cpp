// `foreland bench client` on a tiny scene: the report has the keys of lab/README.md.
#include "lab/tests/scene_program.h"

namespace foreland::lab {
namespace {

class ClientProgram : public test::SceneProgram {
 protected:
  ClientProgram() : SceneProgram("client", 257) {}
  nlohmann::json report(std::vector<std::string> more) const { return SceneProgram::report(4, std::move(more)); }
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
}  // namespace foreland::lab
