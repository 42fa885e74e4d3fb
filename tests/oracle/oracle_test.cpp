#include "oracle/oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "tests/support/hand_mesh.h"

namespace foreland::oracle {
namespace {

constexpr uint32_t kLog2 = 6, kSize = 1u << kLog2;  // two blocks and one sample a side
const proto::Lens kLens{.vertical_fov_rad = 1.2, .width_px = 800, .height_px = 800};

Truth flatTruth() {
  return {.frame = {}, .shape = test::squareShape(kLog2), .heights = [](uint32_t, uint32_t, std::span<int32_t> out) {
            std::ranges::fill(out, 0);
          }};
}

// Looking straight down from above the middle.
proto::Pose fromAbove(double height_m) {
  return {{0.5 * kSize, 0.5 * kSize, height_m}, proto::lookAlong({0, 0, -1}, {0, 1, 0})};
}

Deviation errorOf(Oracle& oracle, const client::KeyframeMesh& mesh, double weight, const proto::Pose& pose) {
  const DrawnShare share{.mesh = &mesh, .weight = weight};
  return oracle.error({&share, 1}, pose, kLens);
}

TEST(Oracle, FindsNoErrorInAPlaneDrawnByTwoTriangles) {
  Oracle oracle(flatTruth());
  const Deviation d = errorOf(oracle, test::flatMesh(1, kSize), 0.3, fromAbove(200));
  EXPECT_NEAR(d.max_px, 0, 1e-9);
  EXPECT_EQ(d.samples, uint64_t{kSize + 1} * (kSize + 1));
  EXPECT_EQ(d.uncovered, 0u);
}

// A vertex at (x, y) from the point under the eye, lifted by e, seen from height h straight down, lands at f r / (h -
// e) from the centre instead of f r / h.
TEST(Oracle, MeasuresALiftedVertexInClosedForm) {
  Oracle oracle(flatTruth());
  client::KeyframeMesh mesh = test::flatMesh(4, kSize / 4);
  const size_t vertex = 3 * 5 + 1;  // lattice (16, 48): 16 m west and 16 m north of the middle
  mesh.to_positions[vertex].z = 2;
  const double h = 200, r = std::hypot(16.0, 16.0);
  for (const double weight : {0.0, 0.25, 1.0}) {
    const double e = 2 * weight, expected_px = kLens.focalPx() * (r / (h - e) - r / h);
    const Deviation d = errorOf(oracle, mesh, weight, fromAbove(h));
    EXPECT_NEAR(d.max_px, expected_px, 1e-9) << weight;
    EXPECT_NEAR(d.max_m, e, 1e-12);
    if (weight > 0) { EXPECT_EQ(d.worst_sample, glm::uvec2(16, 48)) << weight; }
  }
}

// The truth has one spike that the drawn plane lacks.
TEST(Oracle, MeasuresASpikeThatIsNotDrawn) {
  Truth truth = flatTruth();
  truth.heights = [](uint32_t x, uint32_t y, std::span<int32_t> out) {
    for (uint32_t i = 0; i < out.size(); ++i) out[i] = x + i == 40 && y == 20 ? 50 : 0;
  };
  Oracle oracle(std::move(truth));
  const Deviation d = errorOf(oracle, test::flatMesh(2, kSize / 2), 0, fromAbove(100));
  const double r = std::hypot(8.0, 12.0);
  EXPECT_NEAR(d.max_px, kLens.focalPx() * (r / 95 - r / 100), 1e-9);
  EXPECT_EQ(d.worst_sample, glm::uvec2(40, 20));
  EXPECT_NEAR(d.rms_m, 5 / std::sqrt(static_cast<double>(d.samples)), 1e-12);
}

TEST(Oracle, FindsTheSameInHeightsThatAreReadAgain) {
  Truth truth = flatTruth();
  truth.heights = [](uint32_t x, uint32_t y, std::span<int32_t> out) {
    for (uint32_t i = 0; i < out.size(); ++i) out[i] = static_cast<int32_t>((x + i) * 7 % 13 + y * 5 % 11);
  };
  truth.position = [](uint32_t x, uint32_t y, double height) { return glm::dvec3(x, y, height); };
  Oracle kept(truth);
  truth.is_read_on_demand = true;
  Oracle read(truth);
  for (const double height_m : {200.0, 15.0, 200.0}) {
    const client::KeyframeMesh mesh = test::flatMesh(2, kSize / 2);
    const Deviation a = errorOf(kept, mesh, 0, fromAbove(height_m)), b = errorOf(read, mesh, 0, fromAbove(height_m));
    EXPECT_EQ(a.max_px, b.max_px);
    EXPECT_EQ(a.rms_m, b.rms_m);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(kept.held(), 0u);
    EXPECT_EQ(read.held(), height_m == 200 ? 9u : 4u);
    read.forget();
    EXPECT_EQ(read.held(), 0u);
  }
}

TEST(Oracle, IgnoresWhatTheCameraDoesNotSee) {
  Oracle oracle(flatTruth());
  client::KeyframeMesh mesh = test::flatMesh(4, kSize / 4);
  for (size_t i = 0; i < mesh.parameters.size(); ++i)
    if (mesh.parameters[i].y == 0) mesh.from_positions[i].z = 3;  // the south edge
  const proto::Pose north{{32, 20, 1}, proto::lookAlong({0, 1, 0}, {0, 0, 1})};
  EXPECT_NEAR(errorOf(oracle, mesh, 0, north).max_px, 0, 1e-9);
  const proto::Pose south{{32, 20, 1}, proto::lookAlong({0, -1, 0}, {0, 0, 1})};
  EXPECT_GT(errorOf(oracle, mesh, 0, south).max_px, 10);
}

TEST(Oracle, CountsSeenSamplesUnderNoTriangle) {
  Oracle oracle(flatTruth());
  client::KeyframeMesh mesh = test::flatMesh(1, kSize);
  mesh.indices.resize(3);
  const Deviation d = errorOf(oracle, mesh, 0, fromAbove(200));
  EXPECT_EQ(d.uncovered, uint64_t{kSize} * (kSize + 1) / 2);
  EXPECT_EQ(d.samples + d.uncovered, uint64_t{kSize + 1} * (kSize + 1));
}

TEST(Oracle, IsHugeWhereADrawnPointFallsBehindTheEye) {
  Oracle oracle(flatTruth());
  client::KeyframeMesh mesh = test::flatMesh(1, kSize);
  for (auto& p : mesh.from_positions) p.z = 500;
  EXPECT_GT(errorOf(oracle, mesh, 0, fromAbove(200)).max_px, 1e4);
}

// The law behind `share`: blending two meshes sample by sample is the interpolated mesh.
TEST(Oracle, BlendsMeshesByShare) {
  Oracle oracle(flatTruth());
  Rng rng(7);
  client::KeyframeMesh mesh = test::flatMesh(8, kSize / 8);
  for (size_t i = 0; i < mesh.parameters.size(); ++i) {
    mesh.from_positions[i].z = static_cast<float>(rng.uniform(-3, 3));
    mesh.to_positions[i].z = static_cast<float>(rng.uniform(-3, 3));
  }
  const DrawnShare whole{.mesh = &mesh, .weight = 0.3};
  const DrawnShare parts[] = {{.mesh = &mesh, .weight = 0, .share = 0.7}, {.mesh = &mesh, .weight = 1, .share = 0.3}};
  EXPECT_LT(oracle.difference({&whole, 1}, parts, fromAbove(100), kLens).max_m, 1e-9);
  EXPECT_GT(oracle.error({&whole, 1}, fromAbove(100), kLens).max_m, 1);
}

// Against a few lines that do the same without blocks, culling or rasterising: triangles of one cell hit their own
// corners only.
TEST(Oracle, AgreesWithProjectingEveryVertexOfAFullResolutionMesh) {
  Oracle oracle(flatTruth());
  Rng rng(11);
  client::KeyframeMesh mesh = test::flatMesh(kSize, 1);
  for (auto& p : mesh.from_positions) p.z = static_cast<float>(rng.uniform(-0.5, 0.5));
  for (int round = 0; round < 20; ++round) {
    const glm::dvec3 forward(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, -0.1));
    const proto::Pose pose{{rng.uniform(0, kSize), rng.uniform(0, kSize), rng.uniform(2, 50)},
                           proto::lookAlong(forward, {0, 0, 1})};
    double expected = 0;
    uint64_t seen = 0;
    const double f = kLens.focalPx();
    const auto view = [&](glm::dvec3 p) { return glm::inverse(pose.orientation) * (p - pose.eye); };
    for (size_t i = 0; i < mesh.parameters.size(); ++i) {
      const glm::dvec3 t = view({mesh.parameters[i], 0}), d = view(glm::dvec3(mesh.from_positions[i]));
      if (-t.z <= 1 || std::fabs(t.x) * f > -t.z * 400 || std::fabs(t.y) * f > -t.z * 400) continue;
      ++seen;
      expected = std::max(expected, f * std::hypot(t.x / -t.z - d.x / -d.z, t.y / -t.z - d.y / -d.z));
    }
    const Deviation d = errorOf(oracle, mesh, 0, pose);
    EXPECT_EQ(d.samples, seen) << "seed 11, round " << round;
    EXPECT_NEAR(d.max_px, expected, 1e-6 * expected + 1e-9) << "seed 11, round " << round;
  }
}

// Ground that rises by 2 quanta in all of a window between two dates.
Truth risingTruth() {
  Truth truth = flatTruth();
  truth.epochs = {Time::seconds(0), Time::seconds(10)};
  truth.moved = {.x = 8, .y = 8, .width = 40, .height = 30};
  truth.offsets = [](size_t epoch, uint32_t x, uint32_t y, std::span<double> out) {
    for (uint32_t i = 0; i < out.size(); ++i)
      out[i] = epoch == 1 && x + i >= 8 && x + i < 48 && y >= 8 && y < 38 ? 2 : 0;
  };
  return truth;
}

TEST(Oracle, HasTwinsThatEachShowATimeOfTheirOwn) {
  Oracle oracle(risingTruth());
  Oracle twin = oracle.twin();
  const client::KeyframeMesh mesh = test::flatMesh(1, kSize);
  const auto showAt = [](Oracle& which, int64_t second) {
    which.showAt({Time::seconds(second), Time::seconds(second), 0, false});
  };
  showAt(oracle, 10);
  showAt(twin, 5);
  EXPECT_EQ(errorOf(oracle, mesh, 0, fromAbove(200)).max_m, 0.2);
  EXPECT_EQ(errorOf(twin, mesh, 0, fromAbove(200)).max_m, 0.1);
  showAt(oracle, 0);
  EXPECT_EQ(errorOf(oracle, mesh, 0, fromAbove(200)).max_m, 0);
  EXPECT_EQ(errorOf(twin, mesh, 0, fromAbove(200)).max_m, 0.1);
  EXPECT_EQ(errorOf(oracle, mesh, 0, fromAbove(200)).samples, errorOf(twin, mesh, 0, fromAbove(200)).samples);
}

}  // namespace
}  // namespace foreland::oracle
