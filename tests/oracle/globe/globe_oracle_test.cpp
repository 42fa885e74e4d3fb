// The judge of globes agrees with the engine on names and places, although they share no code; it finds nothing wrong
// with a globe drawn at full resolution, and what was done to one.
#include "oracle/globe/globe_oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "oracle/globe/cube_faces.h"
#include "tests/oracle/globe/whole_globe.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"

namespace foreland::oracle {
namespace {

using proto::NodeId;

constexpr uint32_t kGlobeLog2 = 5, kGlobeSide = 1u << kGlobeLog2;
const proto::Lens kWideLens{.vertical_fov_rad = 1.2, .width_px = 800, .height_px = 800};

TEST(CubeFaces, NamesEveryVertexAsTheEngineDoes) {
  const CubeFaces faces(kGlobeLog2);
  const proto::Cube cube(kGlobeLog2);
  for (uint32_t face = 0; face < 6; ++face)
    for (int32_t y = 0; y <= static_cast<int32_t>(kGlobeSide); ++y)
      for (int32_t x = 0; x <= static_cast<int32_t>(kGlobeSide); ++x) {
        const NodeId name = cube.name({face, x, y});
        const CubeFaces::Point point = faces.pointOn(face, {x, y});
        ASSERT_EQ(faces.nameOf(point), name) << face << ": " << x << ", " << y;
        ASSERT_EQ(faces.pointOf(name), point) << face << ": " << x << ", " << y;
        ASSERT_EQ(faces.placeOn(face, point), (glm::vec<2, int64_t>(x, y)));
      }
}

TEST(CubeFaces, PlacesVerticesByGeographicLibWhereTheEngineDoes) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGlobe;
  frame.face_steps = 1u << 20;
  const proto::FrameTransform transform(frame);
  const CubeFaces faces(20);
  for (int i = 0; i < 100'000; ++i) {
    const auto x = static_cast<uint32_t>(rng.below(6u << 20)), y = static_cast<uint32_t>(rng.below(1u << 20));
    const double height_m = rng.uniform(-11'000, 9'000);
    proto::Geodetic at = faces.geodetic(x >> 20, {x & ((1u << 20) - 1), y});
    at.height_m = height_m;
    const glm::dvec3 expected = terrain::referencePosition({frame.semi_major_m, frame.flattening}, at);
    ASSERT_LT(glm::distance(transform.vertexOfGlobe(x, y, height_m), expected), 1e-6) << "seed " << seed;
  }
}

TEST(CubeFaces, HidesWhatLinesThroughTheBodyReach) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const terrain::Ellipsoid body{10, 0.2};
  for (int i = 0; i < 20'000; ++i) {
    const auto any = [&](double reach) {
      return glm::dvec3(rng.uniform(-reach, reach), rng.uniform(-reach, reach), rng.uniform(-reach, reach));
    };
    const glm::dvec3 eye = any(40), point = any(20);
    double least = 1e9;
    for (double t = 0; t <= 1; t += 1e-3) {
      const glm::dvec3 p = eye + t * (point - eye);
      least = std::min(least, glm::length(p / glm::dvec3(10, 10, 8)));
    }
    if (std::fabs(least - 1) < 0.01) continue;  // grazing: steps are too long to tell
    ASSERT_EQ(isBehind(body, eye, point), least < 1) << "seed " << seed;
  }
}

TEST(GlobeOracle, FindsNothingWrongWithAGlobeAtFullResolution) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const auto scene = test::makeGlobeScene(kGlobeLog2, seed);
  const client::KeyframeMesh mesh = wholeGlobe(*scene, kGlobeSide);
  EXPECT_EQ(mesh.parameters.size(), 6u * kGlobeSide * kGlobeSide + 2);
  Patchwork oracle = globeOracle(scene);
  for (const glm::dvec3& d :
       {glm::dvec3(1, 1, 1), glm::dvec3(0, 0, 1), glm::dvec3(-1, 0.01, 0), glm::dvec3(1, -1, 0.2)}) {
    const Deviation found = oracle.error(mesh, 0.5, viewFrom(d, rng.uniform(5'000, 60'000)), kWideLens);
    EXPECT_LT(found.max_px, 1e-3) << "seed " << seed;
    EXPECT_EQ(found.uncovered, 0u) << "seed " << seed;
    EXPECT_GT(found.samples, 40u);
  }
}

TEST(GlobeOracle, MeasuresALiftedVertexAndFindsHoles) {
  const uint64_t seed = test::randomSeed();
  const auto scene = test::makeGlobeScene(kGlobeLog2, seed);
  client::KeyframeMesh mesh = wholeGlobe(*scene, kGlobeSide);
  Patchwork oracle = globeOracle(scene);
  oracle.setSight({{}, 1});
  // On an edge of the cube, seen from the side.
  const NodeId on_edge = NodeId::at(kGlobeSide, kGlobeSide / 2);
  size_t v = 0;
  while (mesh.parameters[v] != glm::vec2(on_edge.x(), on_edge.y())) ++v;
  const glm::dvec3 n = glm::normalize(glm::dvec3(mesh.from_positions[v]));
  mesh.from_positions[v] += glm::vec4(20.0 * n, 0);
  const Deviation near = oracle.error(mesh, 0, viewFrom(n + glm::dvec3(0, 0, 0.3), 8'000), kWideLens);
  EXPECT_GT(near.max_px, 0.3) << "seed " << seed;
  EXPECT_NEAR(near.max_m, 20, 0.1);
  EXPECT_EQ(near.worst_sample, glm::uvec2(on_edge.x(), on_edge.y()));
  // Behind the body nobody sees it, as large as it may be.
  mesh.from_positions[v] -= glm::vec4(9'000.0 * n, 0);
  EXPECT_LT(oracle.error(mesh, 0, viewFrom(-n, 40'000), kWideLens).max_px, 1.001) << "seed " << seed;
  mesh.indices.resize(mesh.indices.size() - 6 * kGlobeSide);  // a row of the last face
  EXPECT_GT(oracle.error(mesh, 1, viewFrom(glm::dvec3(0, 0.3, -1), 30'000), kWideLens).uncovered, 10u);
}

TEST(GlobeOracle, JudgesDeepVerticesWhereTheyAreThere) {
  const uint64_t seed = test::randomSeed();
  const auto scene = test::makeGlobeScene(kGlobeLog2 + 2, seed, 4);
  EXPECT_TRUE(scene->isSparse());
  Patchwork oracle = globeOracle(scene);
  // Nothing is drawn: all that is there is uncovered, each vertex once but for those of edges.
  uint64_t uncovered = 0;
  for (const glm::dvec3& d : {glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0)})
    uncovered +=
        oracle.error({}, 0, viewFrom(d, 1e6), {.vertical_fov_rad = 0.2, .width_px = 800, .height_px = 800}).uncovered;
  uint64_t there = 0;
  scene->pages().forEachPage([&](proto::Slot first, uint64_t) {
    for (proto::Slot slot = first; slot < first + proto::kPageSlots; ++slot)
      there += scene->grid().node(slot) != NodeId{} ? 1 : 0;
  });
  EXPECT_GE(uncovered, 2 * there);
  EXPECT_LE(uncovered, 2 * (there + 14 + 12 * (kGlobeSide * 4 + 1)));
}

}  // namespace
}  // namespace foreland::oracle
