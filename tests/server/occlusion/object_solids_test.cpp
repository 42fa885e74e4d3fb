// What an object is called hidden behind is in the way indeed: each vertex of the hidden object, from eyes displaced
// as far as they may be, however the objects in front of it are drawn.
#include "server/occlusion/objects/object_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <vector>

#include "base/rng.h"
#include "server/occlusion/objects/viewer_objects.h"
#include "tests/support/hiding_spheres.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

using glm::dvec3;

// Spheres that stand about in a square.
struct Field {
  static constexpr double kSide_m = 400;
  test::HidingSpheres spheres;
  SceneObjects objects;
  std::shared_ptr<const ObjectSolids> solids;

  Field(size_t count, Rng& rng) {
    std::vector<proto::ObjectPlacement> placements;
    for (size_t i = 0; i < count; ++i)
      placements.push_back({0,
                            {rng.uniform(0, kSide_m), rng.uniform(0, kSide_m), rng.uniform(-4, 4)},
                            glm::angleAxis(rng.uniform(0, 6), glm::normalize(dvec3(rng.uniform(), 1, rng.uniform()))),
                            i % 4 == 0 ? rng.uniform(15, 25) : rng.uniform(3, 8)});
    objects = spheres.at(placements);
    solids = ObjectSolids::create(objects).value();
  }
};

struct Attacked {
  uint64_t hidden = 0, lines = 0, seen = 0;
};

// Proofs are for `share` of the radius of the eyes that attack, which is `radius_m` at most.
Attacked attack(const Field& field, double share, double radius_m, Rng& rng) {
  const test::HidingSpheres& spheres = field.spheres;
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
      for (const auto& t : spheres.full) {
        const dvec3 point = field.objects.set.placement(object).toScene(t[0]);
        for (const double along : {0.0, 0.5, 1.0}) {
          dvec3 off{rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
          off *= eyes.radius_m / std::max(1e-6, glm::length(off));
          const dvec3 eye = eyes.eye + along * eyes.way + off;
          ++attacked.lines;
          for (const auto* drawn : {&spheres.full, &spheres.base})
            attacked.seen += spheres.isBetween(field.objects, *drawn, object, eye, point) ? 0 : 1;
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

// That the attack finds wrong proofs.
TEST(ObjectSolids, AttackFindsProofsForFewerEyes) {
  Rng rng(test::randomSeed());
  uint64_t seen = 0;
  for (int i = 0; i < 8 && seen == 0; ++i) seen = attack(Field(60, rng), 0, 8, rng).seen;
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

// Of ground that carries it, the box holds the object wherever that is.
TEST(ObjectSolids, BoxesHoldTheObjects) {
  Rng rng(test::randomSeed());
  const Field field(20, rng);
  for (size_t i = 0; i < 20; ++i)
    for (const auto& t : field.spheres.full)
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
