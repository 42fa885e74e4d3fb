// The plan by which node flies rivals says what the scene and the path are; node's part has laws of its own
// (lab/rivals/tests), which are run where its packages are installed.
#include "lab/rivals/flight_plan.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "base/bytes.h"
#include "lab/programs/run_program.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

namespace fs = std::filesystem;

std::shared_ptr<const terrain::Scene> sceneOf(proto::FrameKind kind, const fs::path& file) {
  test::FormulaSource source(
      33, 21, [](uint32_t x, uint32_t y) { return 100.0 + 3 * x + 0.1 * (y * y); }, kind);
  EXPECT_TRUE(terrain::buildScene(source, {file, 0.1, 1}).ok());
  auto scene = terrain::Scene::open(file);
  EXPECT_TRUE(scene.ok());
  return scene.ok() ? *scene : nullptr;
}

proto::Path northward() {
  proto::Path path{.start = {}, .step = Duration::seconds(1), .poses = {}};
  for (int i = 0; i < 4; ++i) path.poses.push_back({.eye = {0, 100.0 * i, 2000}, .orientation = {1, 0, 0, 0}});
  return path;
}

TEST(FlightPlan, SaysWhatTheSceneAndThePathAre) {
  const test::TemporaryFolder folder;
  const auto scene = sceneOf(proto::FrameKind::kGeographic, folder / "scene.fls");
  const auto path = northward();
  const auto plan = writeFlightPlan(
      {.scene = scene, .scene_path = folder / "scene.fls", .path = path, .seconds = 2, .poses_per_s = 5},
      folder.path());
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  std::ifstream file(folder / "heights.f64", std::ios::binary);
  const Bytes bytes((std::istreambuf_iterator<char>(file)), {});
  ASSERT_EQ(bytes.size(), 33 * 21 * sizeof(double));
  ByteReader r(bytes);
  for (uint32_t y = 0; y < 21; ++y)
    for (uint32_t x = 0; x < 33; ++x) EXPECT_NEAR(r.get<double>(), 100.0 + 3 * x + 0.1 * (y * y), 0.0501);
  EXPECT_NEAR(plan->at("ground").at("west_deg").get<double>(), 8, 1e-9);
  EXPECT_NEAR(plan->at("ground").at("step_deg").at(1).get<double>(), 1.0 / 1200, 1e-12);
  ASSERT_EQ(plan->at("poses").size(), 11u);
  for (size_t i = 0; i < 11; ++i)
    EXPECT_NEAR(plan->at("poses").at(i).at("eye").at(1).get<double>(),
                path.at(path.start + Duration::seconds(0.2) * static_cast<int64_t>(i)).eye.y, 1e-6);
}

TEST(FlightPlan, RefusesAMap) {
  const test::TemporaryFolder folder;
  const auto scene = sceneOf(proto::FrameKind::kPlanar, folder / "scene.fls");
  const auto plan =
      writeFlightPlan({.scene = scene, .scene_path = folder / "scene.fls", .path = northward()}, folder.path());
  ASSERT_FALSE(plan.ok());
  EXPECT_NE(plan.error().message.find("--frame geographic"), std::string::npos);
}

TEST(Rivals, KeepTheLawsOfTilesAndOfTheirJudge) {
  const fs::path sources = rivalsSources();
  if (!fs::exists(sources / "node_modules/cesium/package.json"))
    GTEST_SKIP() << "the rivals are not installed; run: npm ci --prefix " << sources.string();
  const auto said = runProgram({"node", "--test", (sources / "tests/laws.test.mjs").string()});
  EXPECT_TRUE(said.ok()) << said.error().message;
}

// What the program says where rivals are to be found in `sources`.
std::string refusalFor(const fs::path& sources) {
  const auto said = runProgram(
      {"/bin/sh", "-c",
       FORELAND_BIN_DIR "/foreland-bench rivals none.fls --sources " + sources.string() + " 2>&1; test $? = 2"});
  return said.ok() ? *said : said.error().message;
}

TEST(Rivals, SayHowTheyAreInstalled) {
  const test::TemporaryFolder folder;
  EXPECT_NE(refusalFor(folder.path()).find("lab/rivals by --sources"), std::string::npos);
  std::ofstream(folder / "measure.mjs") << "";
  EXPECT_NE(refusalFor(folder.path()).find("npm ci --prefix"), std::string::npos);
}

}  // namespace
}  // namespace foreland::lab
