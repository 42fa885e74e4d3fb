// Objects in a scene's file: what is asked for is what is read, they stand on the ground, and damage is found.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "proto/space/frame_grid.h"
#include "terrain/objects/placed_objects.h"
#include "tests/support/scene.h"
#include "tests/support/surface_file.h"

namespace foreland::test {
namespace {

using terrain::ObjectRequest;
using terrain::parseObject;

std::string writeSphere(const TemporaryFolder& folder) {
  const std::string path = folder / "sphere.fls";
  test::writeSphere(path);
  return path;
}

TEST(ObjectFlag, IsReadWithAndWithoutWhatMayBeLeftOut) {
  const auto all = parseObject("a@b/m.fls@46.5,-8.25,3,90,1.5");
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->model, "a@b/m.fls");
  EXPECT_EQ(all->at, glm::dvec2(46.5, -8.25));
  EXPECT_EQ(all->height_m, 3);
  EXPECT_EQ(all->heading_deg, 90);
  EXPECT_EQ(all->scale, 1.5);
  const auto least = parseObject("m.fls@1,2");
  ASSERT_TRUE(least.ok());
  EXPECT_EQ(least->height_m, 0);
  EXPECT_EQ(least->heading_deg, 0);
  EXPECT_EQ(least->scale, 1);
  EXPECT_FALSE(least->is_at_own_place);
  const auto here = parseObject("m.fls@here,2,90,0.3048");
  ASSERT_TRUE(here.ok());
  EXPECT_TRUE(here->is_at_own_place);
  EXPECT_EQ(here->height_m, 2);
  EXPECT_EQ(here->heading_deg, 90);
  EXPECT_EQ(here->scale, 0.3048);
  EXPECT_TRUE(parseObject("m.fls@here").ok());
  for (const char* wrong :
       {"m.fls", "@1,2", "m.fls@1", "m.fls@1,", "m.fls@1,x", "m.fls@1,2,3,4,5,6", "m.fls@nan,2", "m.fls@1,2,0,0,0",
        "m.fls@1,2,0,0,-1", "m.fls@1,2 ", "m.fls@here,", "m.fls@here,1,2,3,4", "m.fls@hereby"})
    EXPECT_FALSE(parseObject(wrong).ok()) << wrong;
}

class PlacedObjects : public testing::TestWithParam<proto::FrameKind> {};

TEST_P(PlacedObjects, StandOnTheGroundTurnedAndScaled) {
  const TemporaryFolder folder;
  const std::string model = writeSphere(folder), path = folder / "land.fls";
  FormulaSource source(129, 97, hills(5), GetParam());
  const proto::Frame& frame = source.info().frame;
  const proto::FrameTransform transform(frame);
  std::vector<ObjectRequest> requests;
  std::vector<glm::dvec2> places;
  for (int i = 0; i < 5; ++i) {
    places.emplace_back(10 + 20 * i, 80 - 15 * i);
    const auto point = transform.toScene(proto::LatticePosition{places.back().x, places.back().y, 0});
    glm::dvec2 at = frame.map_origin_m + glm::dvec2(point);
    if (GetParam() == proto::FrameKind::kGeographic) {
      const proto::Geodetic g = transform.toGeodetic(point);
      at = glm::dvec2(g.latitude_rad, g.longitude_rad) * 57.29577951308232;
    }
    requests.push_back({model, at, 0.5 * i, 30.0 * i, 1.0 + i});
  }
  ASSERT_TRUE(
      terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = requests}}).ok());
  const auto scene = terrain::Scene::open(path);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const auto objects = terrain::readObjects(*scene);
  ASSERT_TRUE(objects.ok()) << objects.error().message;
  ASSERT_EQ(objects->set.size(), 5u);
  ASSERT_EQ(objects->models.size(), 1u) << "the same model is stored once";
  for (size_t i = 0; i < 5; ++i) {
    const proto::ObjectPlacement& p = objects->set.placement(i);
    const double ground_m =
        (*scene)->height(proto::NodeId::at(static_cast<uint32_t>(places[i].x), static_cast<uint32_t>(places[i].y))) *
        0.1;
    const glm::dvec3 foot =
        transform.toScene(proto::LatticePosition{places[i].x, places[i].y, ground_m + requests[i].height_m});
    const glm::dvec3 up = transform.upAt(foot);
    EXPECT_LT(glm::distance(p.toScene({0, 0, -2}), foot), 0.01) << i;
    EXPECT_LT(glm::distance(p.toScene({0, 0, 1}) - p.position, up * requests[i].scale), 1e-6) << i;
    const glm::dvec3 ahead = p.orientation * glm::dvec3(0, 1, 0);
    const double heading = std::atan2(ahead.x, ahead.y) * 57.29577951308232;
    EXPECT_NEAR(heading, requests[i].heading_deg, 1) << i;
  }
}

// At every epoch, the first one among them, which is laid over what the scene was built of.
TEST_P(PlacedObjects, StandOnGroundThatMoves) {
  const TemporaryFolder folder;
  const std::string model = writeSphere(folder), path = folder / "land.fls";
  FormulaSource source(129, 97, hills(5), GetParam());
  std::vector<FormulaSource> grounds;
  for (int i = 0; i < 3; ++i)
    grounds.emplace_back(
        129, 97, [i, ground = hills(5)](uint32_t x, uint32_t y) { return ground(x, y) + 7.3 * i + 4 - 0.02 * i * x; },
        GetParam());
  const proto::FrameTransform transform(source.info().frame);
  std::vector<ObjectRequest> requests;
  std::vector<glm::uvec2> places;
  for (uint32_t i = 0; i < 5; ++i) {
    places.emplace_back(10 + 20 * i, 80 - 15 * i);
    const auto point = transform.toScene(proto::LatticePosition{double(places[i].x), double(places[i].y), 0});
    glm::dvec2 at = source.info().frame.map_origin_m + glm::dvec2(point);
    if (GetParam() == proto::FrameKind::kGeographic) {
      const proto::Geodetic g = transform.toGeodetic(point);
      at = glm::dvec2(g.latitude_rad, g.longitude_rad) * 57.29577951308232;
    }
    requests.push_back({model, at, 0, 0, 1});
  }
  std::vector<terrain::EpochRequest> epochs;
  for (int i = 0; i < 3; ++i) epochs.push_back({Time::seconds(1000 * i), std::to_string(i), &grounds[i]});
  ASSERT_TRUE(
      terrain::buildScene(
          source, {.output = path, .height_quantum_m = 0.1, .epochs = epochs, .additions = {.objects = requests}})
          .ok());
  const auto scene = terrain::Scene::open(path);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const auto objects = terrain::readObjects(*scene);
  ASSERT_TRUE(objects.ok()) << objects.error().message;
  for (size_t i = 0; i < 5; ++i) {
    const proto::ObjectPlacement& p = objects->set.placement(i);
    const proto::Epochs& all = (*scene)->epochs().epochs();
    for (int epoch = 0; epoch < 3; ++epoch) {
      const glm::dvec3 lowest = p.toScene({0, 0, -2}) + p.rise.at(all.weightsAt(all[epoch].time));
      const double ground_m = hills(5)(places[i].x, places[i].y) + 7.3 * epoch + 4 - 0.02 * epoch * places[i].x;
      EXPECT_NEAR(transform.toLattice(lowest).height_m, ground_m, 0.16) << "object " << i << ", epoch " << epoch;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, PlacedObjects,
                         testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

// A model in the map's coordinates stands where these are, at its own height.
TEST(PlacedObjects, StandAtTheirOwnPlace) {
  const TemporaryFolder folder;
  const std::string model = folder / "house.fls", path = folder / "land.fls";
  FormulaSource source(129, 97, hills(5));
  const proto::Frame& frame = source.info().frame;
  const proto::FrameTransform transform(frame);
  const glm::dvec3 centre = transform.toScene(proto::LatticePosition{40, 30, 0});
  const auto written = [&](const glm::dvec3& origin) {
    const terrain::TrueSurface sphere = *terrain::makeSphere(2, {proto::MeshRule::kQuadrisection, 3, 1e-3});
    const auto records = terrain::computeBounds(sphere, {.threads = 1});
    return terrain::writeSurface(model, {.surface = sphere, .records = records, .origin = origin}).ok();
  };
  for (const double scale : {1.0, 0.5}) {
    const glm::dvec3 on_map(glm::dvec2(centre) + frame.map_origin_m, 777.25);
    ASSERT_TRUE(written(on_map / scale));
    const auto request = parseObject(model + "@here,0,0," + std::to_string(scale));
    ASSERT_TRUE(request.ok()) << request.error().message;
    const auto built =
        terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = {*request}}});
    ASSERT_TRUE(built.ok()) << built.error().message;
    const auto scene = terrain::Scene::open(path);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    const auto objects = terrain::readObjects(*scene);
    ASSERT_TRUE(objects.ok()) << objects.error().message;
    const proto::ObjectPlacement& p = objects->set.placement(0);
    EXPECT_LT(glm::distance(p.toScene({0, 0, 0}), glm::dvec3(centre.x, centre.y, 777.25)), 1e-6);
    EXPECT_LT(glm::distance(p.toScene({1, 2, 3}) - p.position, scale * glm::dvec3(1, 2, 3)), 1e-9)
        << "axes are the map's";
  }
  ASSERT_TRUE(written({1e7, 1e7, 0}));
  const auto beyond = terrain::buildScene(
      source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = {*parseObject(model + "@here")}}});
  ASSERT_FALSE(beyond.ok());
  EXPECT_NE(beyond.error().message.find("its own place"), std::string::npos) << beyond.error().message;
  EXPECT_NE(beyond.error().message.find("beyond the data"), std::string::npos) << beyond.error().message;
  FormulaSource geographic(65, 65, hills(5), proto::FrameKind::kGeographic);
  const auto degrees = terrain::buildScene(
      geographic, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = {*parseObject(model + "@here")}}});
  ASSERT_FALSE(degrees.ok());
  EXPECT_NE(degrees.error().message.find("latitude and longitude"), std::string::npos) << degrees.error().message;
}

// A scene holds models whole, so what is known of their insides is known without the models' files.
TEST(PlacedObjects, KeepTheInnerSolidsOfTheirModels) {
  const TemporaryFolder folder;
  const std::string model = folder / "solid.fls", plain = writeSphere(folder), path = folder / "land.fls";
  const terrain::TrueSurface sphere = *terrain::makeSphere(2, {proto::MeshRule::kQuadrisection, 2, 1e-3});
  const auto records = terrain::computeBounds(sphere, {.threads = 1});
  const terrain::ConvexSolid cube = cubeAbout({0, 0, 0.1}, 0.5);
  ASSERT_TRUE(terrain::writeSurface(model, {.surface = sphere, .records = records, .inner = {{cube}, 0.125}}).ok());
  FormulaSource source(65, 65, hills(6));
  const glm::dvec2 at = source.info().frame.map_origin_m;
  const std::vector<ObjectRequest> requests{{plain, at}, {model, at}, {model, at, 3, 45, 2}};
  ASSERT_TRUE(
      terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = requests}}).ok());
  std::filesystem::remove(model);
  const auto scene = terrain::Scene::open(path);
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const auto objects = terrain::readObjects(*scene);
  ASSERT_TRUE(objects.ok()) << objects.error().message;
  const auto solidsOf = [&](size_t object) -> const terrain::InnerSolids& {
    return objects->models[objects->set.placement(object).model]->innerSolids();
  };
  EXPECT_TRUE(solidsOf(0).solids.empty());
  for (const size_t object : {1, 2}) {
    ASSERT_EQ(solidsOf(object).solids.size(), 1u);
    EXPECT_TRUE(std::ranges::equal(solidsOf(object).solids.front().planes(), cube.planes()));
    EXPECT_EQ(solidsOf(object).volume_share, 0.125);
  }
  EXPECT_TRUE(terrain::verifyObjects(path).ok());
}

TEST(PlacedObjects, AreRefusedBeyondTheDataOrWithoutAModel) {
  const TemporaryFolder folder;
  const std::string model = writeSphere(folder), path = folder / "land.fls";
  FormulaSource source(65, 65, hills(6));
  const auto built = [&](const ObjectRequest& request) {
    return terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = {request}}});
  };
  const auto beyond = built({model, {1e7, 1e7}});
  ASSERT_FALSE(beyond.ok());
  EXPECT_NE(beyond.error().message.find("sphere.fls"), std::string::npos) << beyond.error().message;
  EXPECT_NE(beyond.error().message.find("beyond the data"), std::string::npos) << beyond.error().message;
  EXPECT_FALSE(built({folder / "none.fls", {0, 0}}).ok());
  EXPECT_FALSE(std::filesystem::exists(path)) << "nothing half-made stays";
}

}  // namespace
}  // namespace foreland::test
