// A scene that Embree has no memory for is an Error, whichever part of it is the first that does not fit.
#include "terrain/render/embree_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace foreland::terrain {
namespace {

constexpr uint32_t kSide = 300;

std::vector<glm::vec3> vertices() {
  std::vector<glm::vec3> at;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) at.emplace_back(x, y, 0);
  return at;
}

template <class Square>
void forEachSquare(const Square& square) {
  for (uint32_t y = 0; y + 1 < kSide; ++y)
    for (uint32_t x = 0; x + 1 < kSide; ++x) square(y * kSide + x);
}

void addTriangles(EmbreeScene& scene) {
  std::vector<uint32_t> corners;
  forEachSquare([&](uint32_t v) { corners.insert(corners.end(), {v, v + 1, v + kSide}); });
  scene.addTriangles(vertices(), corners);
}

void addQuads(EmbreeScene& scene) {
  scene.addQuads(size_t{kSide} * kSide, size_t{kSide - 1} * (kSide - 1),
                 [](std::span<glm::vec3> at, std::span<glm::uvec4> corners) {
                   std::ranges::copy(vertices(), at.begin());
                   size_t quad = 0;
                   forEachSquare([&](uint32_t v) { corners[quad++] = {v, v + 1, v + kSide + 1, v + kSide}; });
                 });
}

class Adding : public testing::TestWithParam<void (*)(EmbreeScene&)> {};

TEST_P(Adding, MoreThanFitsIntoMemoryIsAnError) {
  EmbreeScene whole;
  GetParam()(whole);
  ASSERT_TRUE(whole.commit().ok());
  EXPECT_TRUE(whole.cast({10.3f, 10.2f, 5}, {0, 0, -1}, 0, 10));
  const auto bytes = static_cast<int64_t>(whole.bytes());
  for (const int64_t max_bytes : {int64_t{0}, int64_t{1} << 20, int64_t{3} << 19, bytes / 3, bytes / 2}) {
    EmbreeScene scene(max_bytes);
    GetParam()(scene);
    const Status status = scene.commit();
    ASSERT_FALSE(status.ok()) << max_bytes << " of " << bytes;
    EXPECT_EQ(status.error().code, ErrorCode::kLimit) << status.error().message;
  }
  EmbreeScene scene(4 * bytes);
  GetParam()(scene);
  EXPECT_TRUE(scene.commit().ok());
}

INSTANTIATE_TEST_SUITE_P(Meshes, Adding, testing::Values(&addTriangles, &addQuads));

TEST(EmbreeScene, MayHoldNothing) {
  EmbreeScene scene;
  scene.addTriangles({}, {});
  ASSERT_TRUE(scene.commit().ok());
  EXPECT_FALSE(scene.cast({0, 0, 1}, {0, 0, -1}, 0, 10));
}

}  // namespace
}  // namespace foreland::terrain
