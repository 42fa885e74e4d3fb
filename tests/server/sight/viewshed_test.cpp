#include "server/sight/viewshed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "tests/support/scene.h"

namespace foreland::server {
namespace {

constexpr uint64_t kMaxCells = 1u << 20;

class Viewsheds : public testing::TestWithParam<proto::FrameKind> {
 protected:
  std::shared_ptr<const terrain::Scene> scene_ = test::makeScene(90, 70, 4, GetParam());
  Hierarchy hierarchy_{scene_};
  std::shared_ptr<const SightScene> sight_ = SightScene::create(hierarchy_).value();
  ViewshedQuestion question_{{41.5, 33.25}, 5, 1, 250, std::nullopt, 0, std::nullopt};
};

TEST_P(Viewsheds, AreALineOfSightForEachCellWithinTheRadius) {
  question_.radius_m = GetParam() == proto::FrameKind::kPlanar ? 250 : 2500;
  const Viewshed viewshed(sight_, question_, Viewshed::gridOf(hierarchy_, question_, kMaxCells).value());
  const proto::FrameTransform& transform = sight_->transform();
  const SightTime time = sight_->at(std::nullopt);
  const glm::dvec3 eye = sight_->aboveGround(question_.observer, 5, time).value(),
                   foot = transform.toScene(proto::LatticePosition{41.5, 33.25, 0});
  size_t seen = 0, hidden = 0;
  for (uint32_t row = 0; row < viewshed.grid().rows; ++row)
    for (uint32_t column = 0; column < viewshed.grid().columns; ++column) {
      const glm::dvec2 at = viewshed.grid().middle(column, row);
      ASSERT_EQ(at, glm::round(at)) << "cells are samples";
      const ViewshedCell cell = viewshed.cell(column, row);
      const bool is_near =
          glm::distance(transform.toScene(proto::LatticePosition{at.x, at.y, 0}), foot) <= question_.radius_m;
      ASSERT_EQ(cell != ViewshedCell::kOutside, is_near);
      if (!is_near) continue;
      const bool sees = sight_->sees(eye, sight_->aboveGround(at, 1, time).value(), 0, time);
      ASSERT_EQ(cell == ViewshedCell::kSeen, sees);
      ++(sees ? seen : hidden);
    }
  EXPECT_GT(seen, 50u);
  EXPECT_GT(hidden, 50u);
}

// No cell within the radius lies outside of the grid.
TEST_P(Viewsheds, HoldTheWholeCircle) {
  for (const double radius_m : {3.0, 90.0, 444.0, 3000.0, 1e7}) {
    question_.radius_m = radius_m;
    question_.cell_m = GetParam() == proto::FrameKind::kPlanar ? 7 : 55;
    const auto grid = Viewshed::gridOf(hierarchy_, question_, kMaxCells);
    if (!grid.ok()) continue;  // no cell's middle
    const auto isNear = [&](const glm::dvec2& at) {
      const auto point = [&](const glm::dvec2& p) {
        return sight_->transform().toScene(proto::LatticePosition{p.x, p.y, 0});
      };
      const bool is_inside = at.x >= 0 && at.y >= 0 && at.x <= 89 && at.y <= 69;
      return is_inside && glm::distance(point(at), point(question_.observer)) <= radius_m;
    };
    for (uint32_t i = 0; i < grid->columns; ++i) {
      EXPECT_FALSE(isNear(grid->first + glm::dvec2(i, -1.0) * grid->step));
      EXPECT_FALSE(isNear(grid->first + glm::dvec2(i, grid->rows) * grid->step));
    }
    for (uint32_t j = 0; j < grid->rows; ++j) {
      EXPECT_FALSE(isNear(grid->first + glm::dvec2(-1.0, j) * grid->step));
      EXPECT_FALSE(isNear(grid->first + glm::dvec2(grid->columns, j) * grid->step));
    }
  }
}

TEST_P(Viewsheds, RefuseWhatMakesNoSense) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [&](auto change, const char* why) {
    ViewshedQuestion question = question_;
    change(question);
    const auto grid = Viewshed::gridOf(hierarchy_, question, kMaxCells);
    ASSERT_FALSE(grid.ok()) << why;
    EXPECT_NE(grid.error().message.find(why), std::string::npos) << grid.error().message;
  };
  for (const double bad : {kNaN, -1.0, 0.0, 1e300, std::numeric_limits<double>::infinity()}) {
    refuses([&](auto& q) { q.radius_m = bad; }, "radius");
    refuses([&](auto& q) { q.cell_m = bad; }, "cells");
  }
  for (const double bad : {kNaN, -1.0, 1e300}) {
    refuses([&](auto& q) { q.observer_m = bad; }, "heights");
    refuses([&](auto& q) { q.target_m = bad; }, "heights");
    refuses([&](auto& q) { q.refraction = bad; }, "refraction");
    refuses([&](auto& q) { q.observer.x = bad; }, "observer");
  }
  refuses([](auto& q) { q.cell_m = 0.01; }, "more than 1048576 cells");
  refuses([](auto& q) { q.radius_m = 0.01; }, "no cell");
}

INSTANTIATE_TEST_SUITE_P(Frames, Viewsheds, testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

}  // namespace
}  // namespace foreland::server
