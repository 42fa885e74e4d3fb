#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/crack_checker.h"
#include "tests/support/hand_mesh.h"

namespace foreland::oracle {
namespace {

const proto::GridShape kShape = test::squareShape(3);

client::KeyframeMesh soundMesh() { return test::flatMesh(4, 2); }

TEST(CrackChecker, PassesASoundMesh) { EXPECT_TRUE(test::hasNoCracks(soundMesh(), kShape)); }

TEST(CrackChecker, PassesAVertexThatIsStoredTwice) {
  client::KeyframeMesh mesh = soundMesh();
  mesh.parameters.push_back(mesh.parameters[6]);
  mesh.from_positions.push_back(mesh.from_positions[6]);
  mesh.to_positions.push_back(mesh.to_positions[6]);
  *std::ranges::find(mesh.indices, 6u) = static_cast<uint32_t>(mesh.parameters.size() - 1);
  EXPECT_TRUE(test::hasNoCracks(mesh, kShape));
}

TEST(CrackChecker, FindsAGapBetweenTwoVerticesAtOnePlace) {
  client::KeyframeMesh mesh = soundMesh();
  mesh.parameters.push_back(mesh.parameters[6]);
  mesh.from_positions.push_back(mesh.from_positions[6]);
  mesh.to_positions.push_back(mesh.to_positions[6] + glm::vec4(0, 0, 1, 1));
  *std::ranges::find(mesh.indices, 6u) = static_cast<uint32_t>(mesh.parameters.size() - 1);
  EXPECT_FALSE(test::hasNoCracks(mesh, kShape));
}

TEST(CrackChecker, FindsAMissingTriangle) {
  client::KeyframeMesh mesh = soundMesh();
  mesh.indices.resize(mesh.indices.size() - 3);
  EXPECT_FALSE(test::hasNoCracks(mesh, kShape));
}

TEST(CrackChecker, FindsATriangleDrawnTwice) {
  client::KeyframeMesh mesh = soundMesh();
  for (int i = 0; i < 3; ++i) mesh.indices.push_back(mesh.indices[static_cast<size_t>(i)]);
  EXPECT_FALSE(test::hasNoCracks(mesh, kShape));
}

TEST(CrackChecker, FindsAFlippedTriangle) {
  client::KeyframeMesh mesh = soundMesh();
  std::swap(mesh.indices[0], mesh.indices[1]);
  EXPECT_FALSE(test::hasNoCracks(mesh, kShape));
}

// Halves one triangle at the middle of its diagonal and leaves the other side of the diagonal whole.
TEST(CrackChecker, FindsAVertexInTheInsideOfAnEdge) {
  client::KeyframeMesh mesh = soundMesh();
  const uint32_t a = mesh.indices[0], b = mesh.indices[1], d = mesh.indices[2],
                 m = static_cast<uint32_t>(mesh.parameters.size());
  mesh.parameters.push_back((mesh.parameters[a] + mesh.parameters[d]) * 0.5f);
  mesh.from_positions.push_back((mesh.from_positions[a] + mesh.from_positions[d]) * 0.5f);
  mesh.to_positions.push_back(mesh.from_positions.back());
  mesh.indices[2] = m;
  for (uint32_t i : {b, d, m}) mesh.indices.push_back(i);
  const CrackReport report = findCracks(mesh, kShape);
  EXPECT_EQ(report.cracks, 3u) << report.first;  // the whole edge and its two halves have one triangle each
}

TEST(CrackChecker, FindsAMeshThatEndsBeforeTheDataDoes) {
  proto::GridShape larger = kShape;
  larger.samples_x += 1;
  EXPECT_FALSE(test::hasNoCracks(soundMesh(), larger));
}

TEST(CrackChecker, FindsIndicesPastTheVertices) {
  client::KeyframeMesh mesh = soundMesh();
  mesh.indices[4] = 1000;
  EXPECT_FALSE(test::hasNoCracks(mesh, kShape));
}

}  // namespace
}  // namespace foreland::oracle
