// `foreland bench wire` on a tiny scene: the report has the keys of lab/README.md.
#include "lab/tests/scene_program.h"

namespace foreland::lab {
namespace {

class WireProgram : public test::SceneProgram {
 protected:
  WireProgram() : SceneProgram("wire", 129) {}
  nlohmann::json report(std::vector<std::string> more) const { return SceneProgram::report(2, std::move(more)); }
};

TEST_F(WireProgram, ComparesWithOthersOnTheSameMeshes) {
  const nlohmann::json peers = report({"--peer-samples", "3", "--quantized-mesh", folder_.path()}).at("peers");
  EXPECT_NE(peers.at("quantized_mesh_skipped").get<std::string>().find("npm ci --prefix"), std::string::npos);
  for (const char* kind : {"first_section", "first_section_half_tau", "in_flight"}) {
    const nlohmann::json& meshes = peers.at(kind);
    EXPECT_EQ(meshes.at("meshes"), std::string(kind) == "in_flight" ? 3 : 1);
    EXPECT_TRUE(meshes.at("quantized_mesh_gzip").is_null());
    for (const char* codec :
         {"foreland", "meshoptimizer_zstd", "meshoptimizer_exact_zstd", "draco_qp14", "draco_exact"}) {
      EXPECT_NEAR(meshes.at(codec).at("bits_per_vertex").get<double>(),
                  8 * meshes.at(codec).at("bytes").get<double>() / meshes.at("vertices").get<double>(), 1e-9)
          << codec;
    }
    for (const char* codec : {"draco_exact", "meshoptimizer_exact_zstd"})
      EXPECT_EQ(meshes.at(codec).at("max_error_m"), 0) << codec;
    EXPECT_GT(meshes.at("draco_qp14").at("max_error_m"), 0);
    EXPECT_GT(meshes.at("height_entropy_bits_per_node"), meshes.at("displacement_entropy_bits_per_node"));
    EXPECT_LT(meshes.at("foreland_over_draco_exact"), 1);
  }
  EXPECT_GT(peers.at("first_section_half_tau").at("vertices"), peers.at("first_section").at("vertices"));
}

TEST_F(WireProgram, SaysWhyNothingIsDecodedInWebAssembly) {
  const nlohmann::json wire = report({"--no-peers", "--wasm-decoder", folder_ / "none.wasm"});
  EXPECT_TRUE(wire.at("decode_wasm_mnodes_per_s").is_null());
  EXPECT_NE(wire.at("decode_wasm_skipped").get<std::string>().find("none.wasm is not built"), std::string::npos);
  EXPECT_GT(wire.at("decode_mnodes_per_s"), 0);
}

// It fails if it ends with other nodes or heights than the client does that is compiled for this machine.
TEST_F(WireProgram, DecodesInWebAssembly) {
  const nlohmann::json wire = report({"--no-peers"});
  if (wire.contains("decode_wasm_skipped")) GTEST_SKIP() << wire.at("decode_wasm_skipped");
  EXPECT_GT(wire.at("decode_wasm_mnodes_per_s"), 0);
  EXPECT_GT(wire.at("first_decode_wasm_mnodes_per_s"), 0);
}

TEST_F(WireProgram, LeavesTheOthersOut) { EXPECT_FALSE(report({"--no-peers"}).contains("peers")); }

}  // namespace
}  // namespace foreland::lab
