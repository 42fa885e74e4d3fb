// `foreland bench occlusion` on a tiny scene: the report has the keys of lab/README.md.
#include <nlohmann/json.hpp>

#include "lab/programs/run_program.h"
#include "lab/tests/occlusion/ridge.h"

namespace foreland::lab {
namespace {

class OcclusionProgram : public testing::Test {
 protected:
  void SetUp() override {
    test::FormulaSource source(257, 257, test::ridgeHeight);
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1}).ok());
  }
  Result<std::string> run(std::vector<std::string> more) const {
    std::vector<std::string> words{FORELAND_BIN_DIR "/foreland-bench",
                                   "occlusion",
                                   folder_ / "scene.fls",
                                   "--seconds",
                                   "1",
                                   "--json",
                                   "--width",
                                   "160",
                                   "--height",
                                   "90"};
    words.insert(words.end(), more.begin(), more.end());
    return runProgram(words);
  }
  test::TemporaryFolder folder_;
};

TEST_F(OcclusionProgram, Reports) {
  const auto text = run({"--tour", "canyon", "--judge", "1"});
  ASSERT_TRUE(text.ok()) << text.error().message;
  const nlohmann::json report = nlohmann::json::parse(*text);
  for (const char* key :
       {"saving", "first_section_saving", "bytes_saving", "first_bytes_saving", "possible_saving",
        "keyframe_cost_ratio", "first_keyframe_cost_ratio", "occluder_mib", "occluder_build_s", "pixels_keyframes"})
    EXPECT_GT(report.at(key).get<double>(), 0) << key;
  for (const char* key : {"visible_pixels_over_tau_keyframes", "visible_pixels_over_tau_frames",
                          "drawn_pixels_over_tau_keyframes", "drawn_pixels_over_tau_frames", "late_reveals"})
    EXPECT_EQ(report.at(key).get<double>(), 0) << key;
  EXPECT_EQ(report.at("tour"), "canyon");
  EXPECT_EQ(report.at("predictor"), "path");
}

TEST_F(OcclusionProgram, JudgesNothingIfAskedTo) {
  const auto text = run({"--judge", "0", "--predictor", "velocity"});
  ASSERT_TRUE(text.ok()) << text.error().message;
  const nlohmann::json report = nlohmann::json::parse(*text);
  EXPECT_EQ(report.at("predictor"), "velocity");
  EXPECT_FALSE(report.contains("possible_saving"));
}

TEST_F(OcclusionProgram, RefusesAnUnknownPredictor) { EXPECT_FALSE(run({"--predictor", "oracle"}).ok()); }

}  // namespace
}  // namespace foreland::lab
