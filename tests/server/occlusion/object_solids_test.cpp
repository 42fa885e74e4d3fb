// What an object is called hidden behind is in the way indeed: each vertex of the hidden object, from eyes displaced
// as far as they may be, however the objects in front of it are drawn.
#include "server/occlusion/objects/object_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "base/rng.h"
#include "server/occlusion/objects/viewer_objects.h"
#include "tests/support/hiding_spheres.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

using glm::dvec3;

// Spheres, or cubes, that stand about in a square.
struct Field {
  static constexpr double kSide_m = 400;
  test::HidingSpheres shapes;
  SceneObjects objects;
  std::shared_ptr<const ObjectSolids> solids;

  Field(size_t count, Rng& rng, test::HidingSpheres of = {}) : shapes(std::move(of)) {
    std::vector<proto::ObjectPlacement> placements;
    for (size_t i = 0; i < count; ++i)
      placements.push_back({0,
                            {rng.uniform(0, kSide_m), rng.uniform(0, kSide_m), rng.uniform(-4, 4)},
                            glm::angleAxis(rng.uniform(0, 6), glm::normalize(dvec3(rng.uniform(), 1, rng.uniform()))),
                            i % 4 == 0 ? rng.uniform(15, 25) : rng.uniform(3, 8)});
    objects = shapes.at(placements);
    solids = ObjectSolids::create(objects).value();
  }
};

struct Attacked {
  uint64_t hidden = 0, lines = 0, seen = 0;
};

// A direction at right angles to a line, which looks past things as far as may be.
dvec3 across(const dvec3& line, Rng& rng) {
  const dvec3 u = glm::normalize(glm::cross(line, dvec3(0, 0, 1))), v = glm::normalize(glm::cross(line, u));
  const double angle = rng.uniform(0, 2 * std::numbers::pi);
  return std::cos(angle) * u + std::sin(angle) * v;
}

// Proofs are for `share` of the radius of the eyes that attack, which is `radius_m` at most.
Attacked attack(const Field& field, double share, double radius_m, Rng& rng) {
  const test::HidingSpheres& shapes = field.shapes;
  Attacked attacked;
  for (int path = 0; path < 12; ++path) {
    const EyeCapsule eyes{{rng.uniform(0, Field::kSide_m), -20, rng.uniform(-3, 8)},
                          {rng.uniform(-3, 3), rng.uniform(-2, 2), rng.uniform(-1, 1)},
                          rng.uniform(0.5, radius_m)};
    const EyeCapsule proved{eyes.eye, eyes.way, share * eyes.radius_m};
    for (size_t object = 0; object < field.objects.set.size(); ++object) {
      uint32_t hint = ObjectSolids::kNone;
      uint64_t queries = 0;
      if (!hideFrom(*field.solids, proved, field.solids->cornersOf(object), 0, hint, queries)) continue;
      ++attacked.hidden;
      for (const auto& t : shapes.full) {
        const dvec3 point = field.objects.set.placement(object).toScene(t[0]);
        for (const double along : {0.0, 0.5, 1.0}) {
          const dvec3 eye = eyes.eye + along * eyes.way + eyes.radius_m * across(point - eyes.eye, rng);
          ++attacked.lines;
          for (const auto* drawn : {&shapes.full, &shapes.base})
            attacked.seen += shapes.isBetween(field.objects, *drawn, object, eye, point) ? 0 : 1;
        }
      }
    }
  }
  return attacked;
}

TEST(ObjectSolids, HideFromAllEyesWhateverIsDrawn) {
  Rng rng(test::randomSeed());
  const Field field(60, rng);
  ASSERT_GT(field.solids->solidCount(), 0u);
  const Attacked attacked = attack(field, 1, 2, rng);
  EXPECT_GT(attacked.hidden, 10u);
  EXPECT_EQ(attacked.seen, 0u) << "of " << attacked.lines;
}

// Boxes and solids of cubes leave no room in which a wrong proof could go unnoticed.
TEST(ObjectSolids, CubesHideFromAllEyes) {
  Rng rng(test::randomSeed());
  uint64_t hidden = 0;
  for (int i = 0; i < 6; ++i) {
    const Attacked attacked = attack(Field(60, rng, {.surface = test::makeCube()}), 1, 20, rng);
    hidden += attacked.hidden;
    EXPECT_EQ(attacked.seen, 0u) << "of " << attacked.lines;
  }
  EXPECT_GT(hidden, 100u);
}

// That the attack finds wrong proofs: some eight a field are for four fifths of the region.
TEST(ObjectSolids, AttackFindsProofsForFewerEyes) {
  Rng rng(test::randomSeed());
  uint64_t seen = 0;
  for (int i = 0; i < 40 && seen == 0; ++i)
    seen = attack(Field(60, rng, {.surface = test::makeCube()}), 0.8, 20, rng).seen;
  EXPECT_GT(seen, 0u);
}

TEST(ObjectSolids, HideNothingFromWithinTheirObject) {
  Rng rng(test::randomSeed());
  const Field field(2, rng);
  const dvec3 inside = field.objects.set.placement(0).position;
  uint32_t hint = 0;
  uint64_t queries = 0;
  EXPECT_FALSE(hideFrom(*field.solids, {inside, {}, 0.1}, field.solids->cornersOf(1), 0, hint, queries));
}

// An object that ground carries up and down, or that has several poses, may lay bare what it hides now.
TEST(ObjectSolids, WhatMovesHidesNothing) {
  const test::HidingSpheres spheres;
  proto::ObjectPlacement still{0, {0, 0, 0}, {1, 0, 0, 0}, 20}, carried = still;
  carried.rise.quanta = {0, 7};
  EXPECT_GT(ObjectSolids::create(spheres.at({still})).value()->solidCount(), 0u);
  EXPECT_EQ(ObjectSolids::create(spheres.at({carried})).value()->solidCount(), 0u);
  EXPECT_EQ(ObjectSolids::create(spheres.at({carried, still})).value()->solidCount(),
            ObjectSolids::create(spheres.at({still})).value()->solidCount());
  SceneObjects posed = spheres.at({still});
  proto::ObjectModel model = posed.set.modelOf(0);
  model.pose_epochs = {0, 1};
  model.base_moves.assign(model.base.size(), {});
  const auto epochs = proto::Epochs::create({1, 1, 1, 3, 3}, {{Time{0}, {}}, {Time{1}, {}}});
  posed.set = proto::ObjectSet::create({model}, {still}, epochs.value()).value();
  EXPECT_EQ(ObjectSolids::create(posed).value()->solidCount(), 0u);
}

// Of ground that carries it, the box holds the object wherever that is.
TEST(ObjectSolids, BoxesHoldTheObjects) {
  Rng rng(test::randomSeed());
  const Field field(20, rng);
  for (size_t i = 0; i < 20; ++i)
    for (const auto& t : field.shapes.full)
      for (const int axis : {1, 2, 4}) {
        const ObjectSolids::Corners& corners = field.solids->cornersOf(i);
        const dvec3 side = corners[static_cast<size_t>(axis)] - corners[0],
                    at = field.objects.set.placement(i).toScene(t[0]) - corners[0];
        EXPECT_GE(glm::dot(at, side), -1e-6);
        EXPECT_LE(glm::dot(at, side), glm::dot(side, side) + 1e-6);
      }
}

}  // namespace
}  // namespace foreland::server
