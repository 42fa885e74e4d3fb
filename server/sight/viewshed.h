// A viewshed: of which cells of a grid something so high above the ground is seen from a point. Each cell is a line of
// sight of its own to the cell's middle, so no cell depends on another, and it can be made in any order and in slices.
// The grid lies on the scene's lattice, so that a viewshed of as many metres a cell as the elevation has agrees with it
// sample by sample; over a globe it ends with the observer's face of the cube. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "proto/message/sight_message.h"
#include "server/sight/sight_line.h"
#include "server/sight/sight_scene.h"

namespace foreland::server {

struct ViewshedQuestion {
  glm::dvec2 observer{0};        // lattice position
  double observer_m = 1.75;      // of the eye, above the ground
  double target_m = 0;           // of what is looked at, above the ground
  double radius_m = 10e3;        // across the zero surface
  std::optional<double> cell_m;  // without one as the samples are
  double refraction = proto::kUsualRefraction;
  std::optional<Time> scene_time;  // without one the last epoch's
};

// Cells by their middles: lattice positions first + (i, j) * step, rows from the south.
struct ViewshedGrid {
  glm::dvec2 first{0}, step{1};
  uint32_t columns = 0, rows = 0;

  uint64_t cells() const { return uint64_t{columns} * rows; }
  glm::dvec2 middle(uint32_t column, uint32_t row) const { return first + glm::dvec2(column, row) * step; }
};

using proto::ViewshedCell;

class Viewshed {
 public:
  static constexpr double kMinLength_m = proto::kMinSightLength_m, kMaxRadius_m = proto::kMaxSightRadius_m,
                          kMaxHeight_m = proto::kMaxSightHeight_m, kMaxRefraction = 1;

  // An Error names what is wrong with the question and what it may be: not finite, out of range, from beyond the data,
  // or of more than `max_cells`.
  static Result<ViewshedGrid> gridOf(const Hierarchy& hierarchy, const ViewshedQuestion& question, uint64_t max_cells);

  // Of a question that gridOf has accepted, with its grid.
  Viewshed(std::shared_ptr<const SightScene> scene, const ViewshedQuestion& question, const ViewshedGrid& grid);

  const ViewshedGrid& grid() const { return grid_; }
  // `work` as SightScene::sees.
  ViewshedCell cell(uint32_t column, uint32_t row, uint64_t* work = nullptr) const;

 private:
  std::shared_ptr<const SightScene> scene_;
  ViewshedQuestion question_;
  ViewshedGrid grid_;
  SightTime time_;
  glm::dvec3 eye_{0}, foot_{0};  // of the observer; the foot on the zero surface
};

}  // namespace foreland::server
