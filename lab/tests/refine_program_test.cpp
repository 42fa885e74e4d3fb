// `foreland bench refine` on a tiny scene, without the JavaScript MARTINI: the report has what lab/README.md says.
#include "lab/tests/scene_program.h"

namespace foreland::lab {
namespace {

class RefineProgram : public test::SceneProgram {
 protected:
  RefineProgram() : SceneProgram("refine", 65) {}
};

TEST_F(RefineProgram, ReportsWithoutJavascript) {
  const auto text = run({"--tour", "survey", "--seconds", "2", "--tau", "2", "--json", "--martini", folder_.path()});
  ASSERT_TRUE(text.ok()) << text.error().message;
  const nlohmann::json report = nlohmann::json::parse(*text);
  for (const char* key : {"nodes", "triangles", "refine_ms", "refine_mtri_per_s"})
    EXPECT_GT(report.at(key).get<double>(), 0) << key;
  EXPECT_EQ(report.at("tour"), "survey");
  EXPECT_EQ(report.at("tau_px"), 2);
  EXPECT_EQ(report.at("samples"), nlohmann::json({65, 65}));
  EXPECT_EQ(report.at("views"), 11);
  for (const char* key : {"triangles", "mtri_per_s", "ratio"}) EXPECT_GT(report.at("martini").at(key), 0) << key;
  EXPECT_EQ(report.at("soar_published_mtri_per_s"), 37);
  EXPECT_TRUE(report.at("martini_javascript").is_null());
  EXPECT_NE(report.at("martini_javascript_skipped").get<std::string>().find("npm ci --prefix"), std::string::npos);
}

TEST_F(RefineProgram, RefusesAnUnknownTour) {
  const auto text = run({"--tour", "voyage"});
  ASSERT_FALSE(text.ok());
  EXPECT_NE(text.error().message.find("exited with 2"), std::string::npos);
}

}  // namespace
}  // namespace foreland::lab
