#include "client/drawn_mesh.h"

#include <gtest/gtest.h>

namespace foreland::client {
namespace {

// A mesh of two vertices at a height, made anew or as a change of all of them.
std::shared_ptr<const MeshPatch> patchOf(uint32_t keyframe, bool is_whole, float height) {
  auto patch = std::make_shared<MeshPatch>();
  patch->to.index = keyframe;
  for (BlendPatch* part : {&patch->terrain, &patch->objects}) {
    part->is_whole = is_whole;
    part->vertex_count = 2;
    for (uint32_t v = 0; v < 2; ++v) part->positions.push_back({v, glm::vec4(height), glm::vec4(height)});
  }
  return patch;
}

void expectShown(const DrawnMesh& drawn, uint32_t keyframe) {
  EXPECT_EQ(drawn.mesh().to.index, keyframe);
  ASSERT_EQ(drawn.mesh().to_positions.size(), 2u);
  EXPECT_EQ(drawn.mesh().to_positions[1], glm::vec4(static_cast<float>(keyframe)));
  EXPECT_EQ(drawn.mesh().objects.from_positions[0], glm::vec4(static_cast<float>(keyframe)));
}

// A mesh that waits is shown though one that comes after it was made anew.
TEST(DrawnMesh, ShowsEveryMeshThatWaits) {
  DrawnMesh drawn;
  for (uint32_t i = 1; i <= 6; ++i) drawn.add(i, patchOf(i, i == 1 || i == 4, static_cast<float>(i)));
  for (uint32_t i = 1; i <= 6; ++i) {
    drawn.show(i);
    expectShown(drawn, i);
  }
}

TEST(DrawnMesh, SkipsToBeforeAVersion) {
  DrawnMesh drawn;
  for (uint32_t i = 1; i <= 6; ++i) drawn.add(i, patchOf(i, i == 1, static_cast<float>(i)));
  drawn.skipTo(5);
  expectShown(drawn, 4);
  drawn.show(6);
  expectShown(drawn, 6);
}

}  // namespace
}  // namespace foreland::client
