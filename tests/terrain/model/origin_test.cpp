#include "terrain/model/origin.h"

#include <gtest/gtest.h>

#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;

Model cubeAt(const dvec3& low, double size) {
  Model model = test::makeCube(1);
  dvec3 least = model.positions.front(), most = least;
  for (const dvec3& p : model.positions) least = glm::min(least, p), most = glm::max(most, p);
  for (dvec3& p : model.positions) p = low + (p - least) / (most - least) * size;
  return model;
}

TEST(Origin, IsThatOfTheFileForModelsNearIt) {
  EXPECT_EQ(ownOrigin(cubeAt({0, 0, 0}, 1)), dvec3(0));
  EXPECT_EQ(ownOrigin(cubeAt({9000, 0, 0}, 1)), dvec3(0)) << "a part of a larger model";
  EXPECT_EQ(ownOrigin(cubeAt({500e3, 0, 0}, 60e3)), dvec3(0)) << "large as a landscape";
  EXPECT_EQ(ownOrigin(cubeAt({-1e6, -1e6, -1e6}, 2e6)), dvec3(0)) << "about the origin";
  EXPECT_EQ(ownOrigin(Model()), dvec3(0));
}

TEST(Origin, IsAWholeNumberInTheMiddleOfModelsOnAMap) {
  Model model = cubeAt({562000.25, 5116000.75, 1200.5}, 12);
  const dvec3 origin = ownOrigin(model);
  EXPECT_EQ(origin, dvec3(562006, 5116007, 1200));
  const std::vector<dvec3> before = model.positions;
  moveTo(origin, model);
  for (size_t v = 0; v < before.size(); ++v) {
    EXPECT_EQ(model.positions[v] + origin, before[v]) << "nothing is lost";
    EXPECT_LT(glm::length(model.positions[v]), 20);
  }
  EXPECT_EQ(ownOrigin(model), dvec3(0));
}

TEST(Origin, DoesNotHeedVerticesThatNoFaceUses) {
  Model model = cubeAt({562000.25, 5116000.75, 1200.5}, 12);
  model.positions.push_back({0, 0, 0});
  EXPECT_NE(ownOrigin(model), dvec3(0));
}

}  // namespace
}  // namespace foreland::terrain
