// The ray caster against intersections that know nothing of Embree: every triangle tried in doubles, or a formula.
#include "terrain/render/ray_caster.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <vector>

#include "base/rng.h"
#include "oracle/drawn_surface.h"
#include "oracle/epoch_shares.h"
#include "oracle/scene_truth.h"
#include "proto/space/frame_grid.h"
#include "terrain/render/parameter_lookup.h"
#include "tests/support/globe_scene.h"
#include "tests/support/hand_mesh.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/surface_file.h"

namespace foreland::test {
namespace {

using terrain::Ray;
using terrain::RayCaster;
using terrain::RayHit;

struct ReferenceTriangle {
  std::array<glm::dvec3, 3> at;
  std::array<glm::dvec2, 3> lattice;
};

// Each square of 2 x 2 cells is a fan about its centre: the finest triangles of a bisection hierarchy. A square that
// the data does not fill has only the triangles inside. The ground is `shares` of the epochs.
std::vector<ReferenceTriangle> finestTriangles(const terrain::Scene& scene, const std::vector<double>& shares = {}) {
  const auto height = [&](proto::NodeId sample) {
    double quanta = scene.height(sample);
    for (size_t e = 0; e < shares.size(); ++e)
      quanta += shares[e] * scene.epochs().offset(static_cast<uint32_t>(e), scene.grid(), sample);
    return quanta * scene.frame().height_quantum_m;
  };
  static constexpr int kAround[9][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}, {0, 0}};
  const proto::GridShape& shape = scene.grid().shape();
  const proto::FrameTransform transform(scene.frame());
  std::vector<ReferenceTriangle> triangles;
  for (uint32_t y = 0; y + 1 < shape.samples_y; y += 2)
    for (uint32_t x = 0; x + 1 < shape.samples_x; x += 2)
      for (int k = 0; k < 8; ++k) {
        ReferenceTriangle t;
        const int corners[3][2] = {{1, 1}, {kAround[k][0], kAround[k][1]}, {kAround[k + 1][0], kAround[k + 1][1]}};
        bool is_inside = true;
        for (size_t i = 0; i < 3; ++i) {
          const uint32_t cx = x + static_cast<uint32_t>(corners[i][0]), cy = y + static_cast<uint32_t>(corners[i][1]);
          is_inside = is_inside && cx < shape.samples_x && cy < shape.samples_y;
          if (!is_inside) break;
          t.lattice[i] = {cx, cy};
          t.at[i] = transform.toScene(
              proto::LatticePosition{t.lattice[i].x, t.lattice[i].y, height(proto::NodeId::at(cx, cy))});
        }
        if (is_inside) triangles.push_back(t);
      }
  return triangles;
}

// By halving, face by face, as long as a node is there. Heights and positions are those of names.
std::vector<ReferenceTriangle> trianglesOfGlobe(const terrain::Scene& scene) {
  const proto::GridTopology& grid = scene.grid();
  const proto::FrameTransform transform(scene.frame());
  const auto w = static_cast<int>(grid.rootSize());
  std::vector<ReferenceTriangle> triangles;
  for (uint32_t face = 0; face < 6; ++face) {
    const auto nameOf = [&](glm::ivec2 p) { return grid.cube().name({face, p.x, p.y}); };
    const std::function<void(glm::ivec2, glm::ivec2, glm::ivec2, int)> halve = [&](glm::ivec2 a, glm::ivec2 b,
                                                                                   glm::ivec2 apex, int level) {
      const glm::ivec2 m = (a + b) / 2;
      if (level <= grid.maxLevel() && scene.pages().hasPage(grid.slot(nameOf(m), level))) {
        halve(a, apex, m, level + 1);
        halve(apex, b, m, level + 1);
        return;
      }
      ReferenceTriangle t;
      for (size_t i = 0; i < 3; ++i) {
        const glm::ivec2 p = i == 0 ? a : i == 1 ? b : apex;
        const proto::NodeId n = nameOf(p);
        t.lattice[i] = glm::dvec2(p) + glm::dvec2(face * static_cast<uint32_t>(w), 0);
        t.at[i] = transform.vertexOfGlobe(n.x(), n.y(), scene.height(n) * scene.frame().height_quantum_m);
      }
      triangles.push_back(t);
    };
    const glm::ivec2 corners[] = {{0, 0}, {w, 0}, {w, w}, {0, w}};
    for (int i = 0; i < 4; ++i) halve(corners[i], corners[(i + 1) % 4], glm::ivec2(w / 2), 1);
  }
  return triangles;
}

struct ReferenceHit {
  double distance_m = std::numeric_limits<double>::infinity();
  double border = 0;  // least weight of a corner: how far inside the triangle
  glm::dvec2 lattice{0};
  const ReferenceTriangle* triangle = nullptr;
};

// Moeller and Trumbore 1997.
ReferenceHit tryAll(const std::vector<ReferenceTriangle>& triangles, const Ray& ray) {
  ReferenceHit best;
  for (const ReferenceTriangle& t : triangles) {
    const glm::dvec3 u = t.at[1] - t.at[0], v = t.at[2] - t.at[0], p = glm::cross(ray.direction, v);
    const double determinant = glm::dot(u, p);
    const glm::dvec3 from = ray.origin - t.at[0], q = glm::cross(from, u);
    const double a = glm::dot(from, p) / determinant, b = glm::dot(ray.direction, q) / determinant;
    const double distance = glm::dot(v, q) / determinant;
    if (!(a >= 0 && b >= 0 && a + b <= 1 && distance >= 0 && distance < best.distance_m)) continue;
    best = {distance, std::min({a, b, 1 - a - b}), (1 - a - b) * t.lattice[0] + a * t.lattice[1] + b * t.lattice[2],
            &t};
  }
  return best;
}

glm::dvec3 anyDirection(Rng& rng) {
  const double z = rng.uniform(-1, 0.2), turn = rng.uniform(0, 6.283185307179586);
  return {std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
}

// How much farther from the point the corner is than the triangle's nearest one; infinite if it is none of its corners.
double fartherThanNearest(const ReferenceTriangle& t, const glm::dvec3& point, const glm::dvec2& corner) {
  double nearest = std::numeric_limits<double>::infinity(), found = nearest;
  for (size_t i = 0; i < 3; ++i) {
    const double distance = glm::distance(t.at[i], point);
    nearest = std::min(nearest, distance);
    if (t.lattice[i] == corner) found = distance;
  }
  return found - nearest;
}

// Rays from above the ground, in all directions. Those that pass within the floats' error of a border may choose a
// neighbour, so they are compared by position only.
void expectWhatTryingEveryTriangleFinds(const terrain::Scene& scene, const RayCaster& caster,
                                        const std::vector<ReferenceTriangle>& triangles, uint64_t seed, int rays) {
  const proto::FrameTransform transform(scene.frame());
  Rng rng(seed);
  int hits = 0;
  for (int i = 0; i < rays; ++i) {
    const Ray ray{
        transform.toScene(proto::LatticePosition{rng.uniform(5, 60), rng.uniform(5, 45), rng.uniform(200, 1400)}),
        anyDirection(rng)};
    const ReferenceHit expected = tryAll(triangles, ray);
    const std::optional<RayHit> hit = caster.hit(ray);
    ASSERT_EQ(hit.has_value(), std::isfinite(expected.distance_m)) << "seed " << seed << " ray " << i;
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR(hit->distance_m, expected.distance_m, expected.border > 1e-4 ? 1e-6 : 0.1) << i;
    ASSERT_NEAR(glm::distance(hit->parameter, expected.lattice), 0, expected.border > 1e-4 ? 1e-6 : 0.01) << i;
    ASSERT_NEAR(glm::distance(hit->position, ray.origin + hit->distance_m * ray.direction), 0, 1e-3) << i;
    const bool is_inside = expected.border > 1e-4;
    ASSERT_LE(is_inside ? fartherThanNearest(*expected.triangle, hit->position, hit->corner) : 0, 1e-3) << i;
    ASSERT_EQ(hit->object, RayHit::kTerrain);
  }
  EXPECT_GT(hits, rays / 10);
}

class RayCasterFrames : public testing::TestWithParam<proto::FrameKind> {};

TEST_P(RayCasterFrames, FindsWhatTryingEveryTriangleFinds) {
  const auto scene = makeScene(70, 53, hills(11), GetParam());
  const auto caster = RayCaster::ofScene(scene);
  ASSERT_TRUE(caster.ok());
  expectWhatTryingEveryTriangleFinds(*scene, *caster, finestTriangles(*scene), 11, 2000);
}

// At dates, between them, and before and after all.
TEST_P(RayCasterFrames, FindsTheGroundOfASceneTime) {
  for (const proto::EpochBlend blend :
       {proto::EpochBlend::kLinear, proto::EpochBlend::kCatmullRom, proto::EpochBlend::kBSpline}) {
    const auto scene = makeMovingScene(70, 53, 11, 4, GetParam(), blend);
    const oracle::Truth truth = oracle::truthOf(scene);
    for (const double at : {-0.1, 0.0, 0.13, 0.5, 0.71, 1.0, 1.2}) {
      const Time time =
          truth.epochs.front() +
          Duration{static_cast<int64_t>(at * static_cast<double>((truth.epochs.back() - truth.epochs.front()).us))};
      const auto caster = RayCaster::ofScene(scene, time);
      ASSERT_TRUE(caster.ok());
      SCOPED_TRACE(testing::Message() << "blend " << static_cast<int>(blend) << ", " << at << " of the time");
      expectWhatTryingEveryTriangleFinds(
          *scene, *caster, finestTriangles(*scene, oracle::epochShares(truth.epochs, truth.blend, time)), 12, 300);
      if (HasFatalFailure()) return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Both, RayCasterFrames,
                         testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

// From a few metres above the ground of a globe that is fine in places to a body's radius above it.
TEST(RayCaster, FindsWhatTryingEveryTriangleOfAGlobeFinds) {
  const uint64_t seed = randomSeed();
  Rng rng(seed);
  const auto scene = makeGlobeScene(6, seed, 2);
  const std::vector<ReferenceTriangle> triangles = trianglesOfGlobe(*scene);
  const proto::FrameTransform transform(scene->frame());
  int hits = 0, fine = 0;
  for (int k = 0; k < 12; ++k) {
    // Every other time above what is fine, next to a corner of the cube.
    const glm::dvec3 d = k % 2 == 0 ? glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1))
                                    : glm::dvec3(1, -0.97 + rng.uniform(0, 0.05), -0.97);
    const glm::dvec3 eye = transform.spheroid().position(d, k < 6 ? rng.uniform(500, 1'500) : 2e4);
    const auto caster = RayCaster::ofGlobe(scene, eye);
    ASSERT_TRUE(caster.ok());
    for (int i = 0; i < 200; ++i) {
      const glm::dvec3 aside(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const Ray ray{eye, glm::normalize(glm::normalize(aside) - (k < 6 ? 0.6 : 1.5) * glm::normalize(eye))};
      const ReferenceHit expected = tryAll(triangles, ray);
      const std::optional<RayHit> hit = caster->hit(ray);
      ASSERT_EQ(hit.has_value(), std::isfinite(expected.distance_m)) << "seed " << seed << " eye " << k << " ray " << i;
      if (!hit) continue;
      ++hits;
      const bool is_inside = expected.border > 1e-4;
      ASSERT_NEAR(hit->distance_m, expected.distance_m, is_inside ? 1e-6 : 1) << "seed " << seed;
      if (!is_inside) continue;
      ASSERT_NEAR(glm::distance(hit->parameter, expected.lattice), 0, 1e-6) << "seed " << seed;
      fine += glm::distance(expected.triangle->lattice[0], expected.triangle->lattice[1]) < 2.5 ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 800);
  EXPECT_GT(fine, 20);
  EXPECT_FALSE(RayCaster::ofScene(scene).ok());
}

// z = 100 + 0.2 x + 0.5 y, which whole steps of 0.1 m hold at every sample; spacing 10 m.
TEST(RayCaster, GivesThePlanesOwnDepth) {
  const auto scene = makeScene(41, 33, [](uint32_t x, uint32_t y) { return 100 + 2.0 * x + 5.0 * y; });
  const auto caster = RayCaster::ofScene(scene);
  ASSERT_TRUE(caster.ok());
  const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.2, -0.5, 1));
  const glm::dvec3 foot(0, 0, scene->height(proto::NodeId::at(20, 16)) * 0.1), eye = foot + glm::dvec3(3, 4, 200);
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 target = foot + glm::dvec3(rng.uniform(-190, 190), rng.uniform(-150, 150), 0);
    const glm::dvec3 on_plane = target + glm::dvec3(0, 0, 0.2 * (target.x - foot.x) + 0.5 * (target.y - foot.y));
    const auto hit = caster->hit({eye, glm::normalize(on_plane - eye)});
    ASSERT_TRUE(hit.has_value()) << i;
    EXPECT_NEAR(hit->distance_m, glm::distance(on_plane, eye), 1e-9) << i;
    EXPECT_NEAR(glm::distance(hit->normal, normal), 0, 1e-9) << i;
    EXPECT_NEAR(hit->height_m, hit->position.z, 1e-9) << i;
  }
}

TEST(RayCaster, FindsNothingBeyondTheDataOrTheRaysEnd) {
  const auto scene =
      makeScene(20, 20, [](uint32_t, uint32_t) { return 0.0; });  // its roots reach farther than its data
  const auto caster = RayCaster::ofScene(scene);
  ASSERT_TRUE(caster.ok());
  const glm::dvec3 down(0, 0, -1),
      corner = proto::FrameTransform(scene->frame()).toScene(proto::LatticePosition{19, 19, 50});
  EXPECT_TRUE(caster->hit({corner - glm::dvec3(0.01, 0.01, 0), down}).has_value());
  EXPECT_FALSE(caster->hit({corner + glm::dvec3(0.01, 0, 0), down}).has_value());
  EXPECT_FALSE(caster->hit({corner + glm::dvec3(0, 0.01, 0), down}).has_value());
  EXPECT_TRUE(caster->hit({glm::dvec3(0, 0, 50), down, 50.01}).has_value());
  EXPECT_FALSE(caster->hit({glm::dvec3(0, 0, 50), down, 49.99}).has_value());
  EXPECT_FALSE(caster->hit({glm::dvec3(0, 0, 50), -down}).has_value());
}

TEST(RayCaster, GivesTheSameToAnyNumberOfThreads) {
  const auto scene = makeScene(65, 65, hills(2));
  const auto caster = RayCaster::ofScene(scene);
  ASSERT_TRUE(caster.ok());
  Rng rng(5);
  std::vector<Ray> rays(10'000);
  for (Ray& ray : rays) ray = {{rng.uniform(-200, 200), rng.uniform(-200, 200), 2000}, anyDirection(rng)};
  std::vector<std::optional<RayHit>> one(rays.size()), three(rays.size());
  caster->hit(rays, one, 1);
  caster->hit(rays, three, 3);
  for (size_t i = 0; i < rays.size(); ++i) {
    ASSERT_EQ(one[i].has_value(), three[i].has_value());
    if (!one[i]) continue;
    ASSERT_EQ(one[i]->position, three[i]->position);
  }
}

TEST(RayCaster, MeetsObjectsWhereTheyStand) {
  const TemporaryFolder folder;
  const std::string model = folder / "sphere.fls", path = folder / "land.fls";
  writeSphere(model);  // radius 2
  FormulaSource source(33, 33, [](uint32_t, uint32_t) { return 0.0; });
  const std::vector<terrain::ObjectRequest> requests{{model, {0, 0}, 0, 0, 1}, {model, {50, 20}, 10, 30, 5}};
  ASSERT_TRUE(
      terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1, .additions = {.objects = requests}}).ok());
  const auto caster = RayCaster::ofScene(*terrain::Scene::open(path));
  ASSERT_TRUE(caster.ok());
  const auto small = caster->hit({{0, 0, 100}, {0, 0, -1}}), large = caster->hit({{50, 20, 100}, {0, 0, -1}}),
             between = caster->hit({{25, 10, 100}, {0, 0, -1}});
  ASSERT_TRUE(small && large && between);
  EXPECT_EQ(small->object, 0);
  EXPECT_EQ(large->object, 1);
  EXPECT_EQ(between->object, RayHit::kTerrain);
  EXPECT_NEAR(small->distance_m, 100 - 4, 0.01);
  EXPECT_NEAR(large->distance_m, 100 - (10 + 20), 0.01);
  EXPECT_NEAR(between->distance_m, 100, 1e-9);
}

// A sphere that doubles while the ground under it rises by 100 m: half way it has one and a half times its radius,
// about a centre that has risen by 50 m.
TEST(RayCaster, MeetsObjectsThatMoveWhereTheyAreThen) {
  const TemporaryFolder folder;
  const std::string model = folder / "sphere.fls", path = folder / "land.fls";
  const Time first{}, last{100 * 86'400'000'000};
  writeGrowingSphere(model, first, last);
  FormulaSource source(33, 33, [](uint32_t, uint32_t) { return 0.0; });
  FormulaSource later(33, 33, [](uint32_t, uint32_t) { return 100.0; });
  ASSERT_TRUE(terrain::buildScene(source, {.output = path,
                                           .height_quantum_m = 0.1,
                                           .epochs = {{first, "first", &source}, {last, "later", &later}},
                                           .additions = {.objects = {{model, {0, 0}, 0, 0, 1}}}})
                  .ok());
  const auto scene = *terrain::Scene::open(path);
  double centre_m = 0;
  for (const double at : {0.0, 0.5, 0.8, 1.0}) {
    const auto caster =
        RayCaster::ofScene(scene, first + Duration{static_cast<int64_t>(at * static_cast<double>(last.us))});
    ASSERT_TRUE(caster.ok());
    const auto top = caster->hit({{0, 0, 1000}, {0, 0, -1}});
    ASSERT_TRUE(top);
    EXPECT_EQ(top->object, 0);
    if (at == 0) centre_m = top->position.z - 2;
    EXPECT_NEAR(top->position.z, centre_m + 100 * at + 2 * (1 + at), 0.01) << at;
  }
}

// A square of two triangles, lifted at one end: drawn at a weight, positions are the mix and parameters stay.
TEST(DrawnSurface, IsCastAndLookedUpAtItsWeight) {
  client::KeyframeMesh mesh = flatMesh(1, 8);
  mesh.origin = {1000, 2000, 300};
  for (glm::vec4& p : mesh.to_positions) p.z = 4;
  const terrain::DrawnSurface drawn = oracle::drawnSurface(mesh, 0.25);
  const auto caster = RayCaster::ofSurface(drawn);
  const auto lookup = terrain::ParameterLookup::of(drawn);
  ASSERT_TRUE(caster.ok() && lookup.ok());
  const auto hit = caster->hit({{1003, 2005, 400}, {0, 0, -1}});
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->distance_m, 99, 1e-9);
  EXPECT_NEAR(glm::distance(hit->parameter, {3, 5}), 0, 1e-9);
  const auto found = lookup->terrainAt({3, 5});
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(glm::distance(*found, {1003, 2005, 301}), 0, 1e-9);
  EXPECT_FALSE(lookup->terrainAt({8.01, 5}).has_value());
  EXPECT_FALSE(lookup->objectAt(0, {0.5, 0.5}).has_value());
}

}  // namespace
}  // namespace foreland::test
