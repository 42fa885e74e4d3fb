// Base meshes: who is whose neighbour, and what is refused.
#include "proto/topology/base_mesh.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/base_meshes.h"

namespace foreland::proto {
namespace {

TEST(BaseMeshes, TwinsRunAlongTheSameEdgeTheOtherWay) {
  for (const test::NamedBase& base : test::baseMeshes()) {
    SCOPED_TRACE(base.name);
    const BaseMesh mesh = *BaseMesh::create(base.vertices, base.faces);
    uint32_t borders = 0;
    for (HalfEdge h = 0; h < 3 * mesh.faceCount(); ++h) {
      EXPECT_EQ(BaseMesh::next(BaseMesh::previous(h)), h);
      EXPECT_EQ(BaseMesh::next(BaseMesh::next(h)), BaseMesh::previous(h));
      const HalfEdge twin = mesh.twin(h), first = mesh.first(mesh.edge(h));
      EXPECT_EQ(mesh.isFirst(h), first == h);
      if (twin == kNoHalfEdge) {
        ++borders;
        EXPECT_EQ(first, h);
        continue;
      }
      EXPECT_EQ(mesh.twin(twin), h);
      EXPECT_NE(BaseMesh::face(twin), BaseMesh::face(h));
      EXPECT_EQ(mesh.vertex(twin), mesh.vertex(BaseMesh::next(h)));
      EXPECT_EQ(mesh.vertex(BaseMesh::next(twin)), mesh.vertex(h));
      EXPECT_EQ(mesh.edge(twin), mesh.edge(h));
      EXPECT_EQ(first, std::min(h, twin));
    }
    EXPECT_EQ(borders == 0, base.closed);
    EXPECT_EQ(3 * mesh.faceCount() + borders, 2 * mesh.edgeCount());
    for (uint32_t v = 0; v < base.vertices; ++v) EXPECT_EQ(mesh.vertex(mesh.leaving(v)), v);
  }
}

std::string refusal(uint32_t vertices, const std::vector<BaseFace>& faces) {
  const auto mesh = BaseMesh::create(vertices, faces);
  return mesh.ok() ? std::string() : mesh.error().message;
}

TEST(BaseMeshes, AreRefusedWithTheFirstThingThatIsWrong) {
  const auto expect = [](const std::string& message, const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  expect(refusal(0, {}), "no faces");
  expect(refusal(3, {{0, 1, 2}, {0, 1, 3}}), "face 1 names vertex 3");
  expect(refusal(4, {{0, 1, 2}}), "vertex 3 belongs to no face");
  expect(refusal(3, {{0, 1, 1}}), "face 0 names a vertex twice");
  expect(refusal(4, {{0, 1, 2}, {0, 1, 3}}), "edge (0, 1) of face 1 runs the same way in face 0");
  expect(refusal(5, {{0, 1, 2}, {1, 0, 3}, {4, 0, 1}}), "edge (0, 1) of face 2 has two faces already");
  expect(refusal(5, {{0, 1, 2}, {0, 3, 4}}), "vertex 0 hang together");
  expect(refusal(7, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}}), "vertex 0 hang together");
  expect(refusal(BaseMesh::kMaxVertices + 1, {{0, 1, 2}}), "at most");
  expect(refusal(3, std::vector<BaseFace>(BaseMesh::kMaxFaces + 1, BaseFace{0, 1, 2})), "at most");
}

// Vertices of a strip of five triangles, turned over once: a Moebius strip has no outside.
TEST(BaseMeshes, AreRefusedIfTheyHaveNoOutside) {
  std::vector<BaseFace> strip;
  for (uint32_t i = 0; i < 5; ++i)
    strip.push_back(i % 2 == 0 ? BaseFace{i, (i + 1) % 5, (i + 2) % 5} : BaseFace{(i + 1) % 5, i, (i + 2) % 5});
  EXPECT_NE(refusal(5, strip).find("runs the same way"), std::string::npos);
}

}  // namespace
}  // namespace foreland::proto
