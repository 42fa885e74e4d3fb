#include "proto/topology/cube.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace foreland::proto {
namespace {

std::vector<CubePlace> placesOf(const Cube& cube) {
  std::vector<CubePlace> all;
  for (uint32_t face = 0; face < Cube::kFaces; ++face)
    for (int32_t y = 0; y <= cube.side(); ++y)
      for (int32_t x = 0; x <= cube.side(); ++x) all.push_back({face, x, y});
  return all;
}

// A closed surface of 6 W^2 squares with eight corners of three squares: 6 W^2 + 2 points.
TEST(Cube, EachPointHasOneName) {
  for (uint32_t log2 : {0u, 1u, 2u, 4u}) {
    const Cube cube(log2);
    std::map<NodeId, int> squares;
    for (const CubePlace& p : placesOf(cube)) ++squares[cube.name(p)];
    const auto side = static_cast<size_t>(cube.side());
    EXPECT_EQ(squares.size(), 6 * side * side + 2);
    size_t edges = 0, corners = 0;
    for (const auto& [name, count] : squares) {
      edges += count == 2;
      corners += count == 3;
      ASSERT_EQ(count > 1, cube.isOnSeam(name));
    }
    EXPECT_EQ(edges, 12 * (side - 1));
    EXPECT_EQ(corners, 8u);
  }
}

TEST(Cube, APlaceOfANameHasThatName) {
  const Cube cube(3);
  for (const CubePlace& p : placesOf(cube)) {
    const NodeId name = cube.name(p);
    ASSERT_EQ(cube.name(cube.placeOf(name)), name);
    const bool is_corner = (p.x == 0 || p.x == cube.side()) && (p.y == 0 || p.y == cube.side());
    if (is_corner) continue;
    const CubePlaces places = cube.placesOf(name);
    ASSERT_EQ(places.count, cube.isOnSeam(name) ? 2 : 1);
    for (const CubePlace& place : places) {
      ASSERT_TRUE(cube.isWithin(place));
      ASSERT_EQ(cube.name(place), name);
    }
    if (places.count == 2) { ASSERT_NE(places.at[0].face, places.at[1].face); }
    ASSERT_TRUE(p == places.at[0] || (places.count == 2 && p == places.at[1]));
  }
}

}  // namespace
}  // namespace foreland::proto
