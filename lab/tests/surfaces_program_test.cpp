// `foreland bench surfaces` on a small sphere: the report has the keys of lab/README.md, and its figures agree.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "lab/programs/run_program.h"
#include "tests/support/files.h"
#include "tests/support/surface_file.h"

namespace foreland::lab {
namespace {

Result<std::string> run(std::vector<std::string> more) {
  std::vector<std::string> words{FORELAND_BIN_DIR "/foreland-bench", "surfaces"};
  words.insert(words.end(), more.begin(), more.end());
  return runProgram(words);
}

TEST(SurfacesProgram, ReportsWithinTheTolerances) {
  const auto text = run({"--shape", "sphere", "--halvings", "4", "--frames", "6", "--silhouette", "1", "--json"});
  ASSERT_TRUE(text.ok()) << text.error().message;
  const nlohmann::json report = nlohmann::json::parse(*text), &sphere = report.at("sphere");
  EXPECT_FALSE(report.contains("torus"));
  EXPECT_EQ(sphere.at("base_faces"), 8);
  EXPECT_EQ(sphere.at("full_faces"), 2048);
  EXPECT_EQ(sphere.at("session").at("frames"), 9);
  EXPECT_EQ(sphere.at("session").at("faces").size(), 9u);
  for (const nlohmann::json& measured :
       {sphere.at("session"), sphere.at("whole_in_view"), sphere.at("by_disc").at(7)}) {
    EXPECT_LE(measured.at("max_silhouette_error_px").get<double>(), 1);
    EXPECT_LE(measured.at("max_interior_error_px").get<double>(), 3.5);
    EXPECT_EQ(measured.at("uncovered"), 0);
  }
  EXPECT_NEAR(sphere.at("shapes").at("spheroid").at("tolerance_scale_at_equal_measured_error").get<double>(), 1, 0.05);
  for (const char* shape : {"spheroid_by_largest", "hoppe_by_largest"})
    EXPECT_GT(sphere.at("shapes").at(shape).at("tolerance_scale_at_equal_measured_error").get<double>(), 1) << shape;
  EXPECT_DOUBLE_EQ(sphere.at("shapes").at("spheroid").at("mean_faces").get<double>(),
                   sphere.at("session").at("mean_faces").get<double>());
  EXPECT_GT(sphere.at("refine_share_of_full_draw").get<double>(), 0);
}

TEST(SurfacesProgram, MeasuresModelsAndSurfaceFiles) {
  const test::TemporaryFolder folder;
  const std::string model = FORELAND_SOURCE_DIR "/tests/fuzz/corpus/models/tetrahedron.obj",
                    surface = folder / "sphere.fls";
  test::writeSphere(surface);
  const auto text = run({model, surface, "--base-triangles", "4", "--halvings", "3", "--frames", "2", "--json"});
  ASSERT_TRUE(text.ok()) << text.error().message;
  const nlohmann::json report = nlohmann::json::parse(*text);
  ASSERT_EQ(report.size(), 2u);
  for (const auto& [name, base_faces] : {std::pair{model, 4}, {surface, 8}}) {
    EXPECT_EQ(report.at(name).at("base_faces"), base_faces) << name;
    EXPECT_LE(report.at(name).at("session").at("max_silhouette_error_px").get<double>(), 0.5) << name;
  }
  EXPECT_EQ(report.at(model).at("full_faces"), 64);
  EXPECT_LE(report.at(model).at("session").at("most_faces"), 64);
}

TEST(SurfacesProgram, RefusesWhatItCannotMake) {
  for (const auto& [flag, value] : {std::pair{"--shape", "cube"},
                                    {"--halvings", "40"},
                                    {"--silhouette", "nan"},
                                    {"--json", "missing.obj"},
                                    {"--json", FORELAND_SOURCE_DIR "/README.md"}}) {
    const auto text = run({flag, value});
    ASSERT_FALSE(text.ok()) << flag;
    EXPECT_NE(text.error().message.find("exited with 2"), std::string::npos) << text.error().message;
  }
}

}  // namespace
}  // namespace foreland::lab
