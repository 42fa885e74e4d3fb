// A synthetic town: its houses are closed surfaces of one piece, they stand along streets and not on each other, and
// the scene of it holds what was planned.
#include "terrain/town/build_town.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <set>

#include "terrain/remesh/original/original.h"
#include "terrain/town/buildings.h"
#include "terrain/town/street_plan.h"
#include "tests/support/files.h"

namespace foreland::test {
namespace {

using glm::dvec2, glm::dvec3;
using terrain::Building, terrain::BuildingUse;

TEST(Buildings, AreClosedSurfacesOfOnePieceWithFoundations) {
  const std::vector<Building> buildings = terrain::makeBuildings();
  EXPECT_GE(buildings.size(), 12u);
  std::set<std::string> names;
  for (const Building& building : buildings) {
    SCOPED_TRACE(building.name);
    EXPECT_TRUE(names.insert(building.name).second);
    const auto original = terrain::makeOriginal(building.model);
    ASSERT_TRUE(original.ok()) << original.error().message;
    EXPECT_EQ(original->flipped, 0u);
    EXPECT_EQ(original->repairs, terrain::Repairs{});
    for (const terrain::Triangle& twins : original->twins)
      for (const uint32_t twin : twins) EXPECT_NE(twin, terrain::kNoIndex);
    double lowest = 0, volume = 0;
    for (const dvec3& p : original->positions) lowest = std::min(lowest, p.z);
    for (const auto& [a, b, c] : original->faces)
      volume += glm::dot(original->positions[a], glm::cross(original->positions[b], original->positions[c])) / 6;
    EXPECT_EQ(lowest, -terrain::kFoundation_m);
    EXPECT_GT(volume, 0.3 * building.size.x * building.size.y * building.height);
    const bool is_high = building.use == BuildingUse::kChurch || building.use == BuildingUse::kTower;
    EXPECT_GE(building.height, 6);
    EXPECT_LE(building.height, is_high ? 50 : 30);
  }
}

// The corners of the ground of a building.
std::vector<dvec2> groundOf(const terrain::PlacedBuilding& placed, const Building& building) {
  const double c = std::cos(placed.heading_rad), s = std::sin(placed.heading_rad);
  std::vector<dvec2> corners;
  for (const dvec2 k : {dvec2(-1, -1), dvec2(1, -1), dvec2(1, 1), dvec2(-1, 1)}) {
    const dvec2 p = k * building.size / 2.0;
    corners.push_back(placed.at + dvec2(c * p.x + s * p.y, c * p.y - s * p.x));
  }
  return corners;
}
// Whether a line between them separates two convex outlines, by any of their sides.
bool areApart(const std::vector<dvec2>& one, const std::vector<dvec2>& other) {
  for (const auto& [a, b] : {std::pair(&one, &other), std::pair(&other, &one)})
    for (size_t i = 0; i < a->size(); ++i) {
      const dvec2 p = (*a)[i], d = glm::normalize((*a)[(i + 1) % a->size()] - p);
      if (std::ranges::all_of(*b, [&](const dvec2& q) { return d.x * (q.y - p.y) - d.y * (q.x - p.x) < 1e-6; }))
        return true;
    }
  return false;
}

TEST(StreetPlan, PutsEachBuildingOnGroundOfItsOwn) {
  const std::vector<Building> buildings = terrain::makeBuildings();
  for (const uint64_t seed : {1, 2, 3})
    for (const uint32_t count : {1u, 40u, 2000u}) {
      SCOPED_TRACE(seed);
      const terrain::StreetPlan plan = terrain::planStreets(count, buildings, seed);
      ASSERT_EQ(plan.buildings.size(), count);
      std::map<uint32_t, size_t> placed;
      std::vector<std::vector<dvec2>> grounds;
      for (const terrain::PlacedBuilding& p : plan.buildings) {
        ++placed[p.building];
        grounds.push_back(groundOf(p, buildings[p.building]));
        for (const dvec2& corner : grounds.back()) EXPECT_LE(glm::length(corner), plan.radius_m + 1e-6);
      }
      const auto areNear = [&](size_t i, size_t k) {
        return glm::distance(plan.buildings[i].at, plan.buildings[k].at) < 60;
      };
      for (size_t i = 0; i < grounds.size(); ++i)
        for (size_t k = 0; k < i; ++k) EXPECT_TRUE(!areNear(i, k) || areApart(grounds[i], grounds[k]));
      if (count < 2000) continue;
      EXPECT_EQ(placed.size(), buildings.size()) << "all models stand somewhere";
      for (uint32_t i = 0; i < buildings.size(); ++i)
        EXPECT_EQ(placed[i] == 1, buildings[i].use == BuildingUse::kChurch || buildings[i].use == BuildingUse::kTower);
    }
}

// Over all houses: what is in front of their doors until the next house's front is as wide as a street, mostly.
TEST(StreetPlan, LeavesStreetsBetweenTheFronts) {
  const std::vector<Building> buildings = terrain::makeBuildings();
  const terrain::StreetPlan plan = terrain::planStreets(2000, buildings, 1);
  std::vector<std::vector<dvec2>> grounds;
  for (const auto& p : plan.buildings) grounds.push_back(groundOf(p, buildings[p.building]));
  std::vector<double> widths;
  for (size_t i = 0; i < 1000; ++i) {
    const terrain::PlacedBuilding& p = plan.buildings[i];
    const dvec2 front = -dvec2(std::sin(p.heading_rad), std::cos(p.heading_rad));
    const dvec2 door = p.at + front * (buildings[p.building].size.y / 2);
    double nearest = 40;
    for (double ahead = 0.5; ahead < nearest; ahead += 0.5)
      for (size_t k = 0; k < grounds.size(); ++k)
        if (k != i && glm::distance(plan.buildings[k].at, door) < 60 &&
            !areApart(grounds[k], {door + front * (ahead - 0.01), door + front * ahead + dvec2(0.01, 0),
                                   door + front * ahead + dvec2(0, 0.01)}))
          nearest = std::min(nearest, ahead);
    if (nearest < 40) widths.push_back(nearest);
  }
  ASSERT_GT(widths.size(), 500u);
  std::ranges::sort(widths);
  EXPECT_GE(widths[widths.size() / 20], 11.5);
  EXPECT_LE(widths[widths.size() * 9 / 10], 22);
}

TEST(Town, HoldsWhatWasPlannedAndIsTheSameForASeed) {
  const TemporaryFolder folder;
  const auto build = [&](const std::string& name, uint64_t seed) {
    auto made = terrain::buildTown(
        {.output = folder / name, .buildings = 60, .seed = seed, .base_triangles = 60, .levels = 2, .threads = 2});
    EXPECT_TRUE(made.ok()) << made.error().message;
    return std::move(made).value();
  };
  const terrain::TownReport report = build("town.fls", 5);
  build("again.fls", 5);
  EXPECT_EQ(slurp(folder / "town.fls"), slurp(folder / "again.fls"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2) << "the models are in the scenes";
  const auto scene = terrain::Scene::open(folder / "town.fls");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  const auto objects = terrain::readObjects(*scene);
  ASSERT_TRUE(objects.ok()) << objects.error().message;
  EXPECT_EQ(objects->set.size(), 60u);
  EXPECT_GE(objects->models.size(), 10u);
  for (const auto& model : objects->models) {
    EXPECT_TRUE(model->isClosed());
    EXPECT_FALSE(model->innerSolids().solids.empty());
  }
  EXPECT_EQ(objects->models.size(),
            static_cast<size_t>(std::ranges::count_if(report.models, [](const auto& m) { return m.placed > 0; })));
}

TEST(Town, LeavesAFolderAloneThatIsInTheWay) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "town.fls.models");
  spit(folder / "town.fls.models/mine", {'1'});
  const auto made = terrain::buildTown({.output = folder / "town.fls", .buildings = 1});
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().message.find("town.fls.models"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder / "town.fls.models/mine"));
}

TEST(Town, IsRefusedWithoutBuildingsOrWithTooMany) {
  const TemporaryFolder folder;
  for (const uint32_t count : {0u, 4097u}) {
    const auto made = terrain::buildTown({.output = folder / "town.fls", .buildings = count});
    ASSERT_FALSE(made.ok());
    EXPECT_NE(made.error().message.find(std::to_string(count)), std::string::npos);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace foreland::test
