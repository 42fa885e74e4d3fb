#include "server/sight/viewshed.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "base/check.h"

namespace foreland::server {

namespace {

Error refused(const std::string& what) { return {ErrorCode::kInvalidArgument, "viewshed: " + what}; }

// Metres of a lattice step along either axis, at a position, on the zero surface.
glm::dvec2 spacingAt(const proto::FrameTransform& transform, const glm::dvec2& at) {
  const auto point = [&](double x, double y) { return transform.toScene(proto::LatticePosition{x, y, 0}); };
  return {glm::distance(point(at.x - 0.5, at.y), point(at.x + 0.5, at.y)),
          glm::distance(point(at.x, at.y - 0.5), point(at.x, at.y + 0.5))};
}

Status check(const ViewshedQuestion& q) {
  const auto isWithin = [](double value, double least, double most) { return value >= least && value <= most; };
  if (!isWithin(q.radius_m, Viewshed::kMinLength_m, Viewshed::kMaxRadius_m))
    return refused("the radius must be 0.001 to 10,000,000 m");
  if (q.cell_m && !isWithin(*q.cell_m, Viewshed::kMinLength_m, Viewshed::kMaxRadius_m))
    return refused("cells must be 0.001 to 10,000,000 m wide");
  if (!isWithin(q.observer_m, 0, Viewshed::kMaxHeight_m) || !isWithin(q.target_m, 0, Viewshed::kMaxHeight_m))
    return refused("heights must be 0 to 1,000,000 m above the ground");
  if (!isWithin(q.refraction, 0, Viewshed::kMaxRefraction)) return refused("the refraction must be 0 to 1");
  return {};
}

// How many lattice steps the radius is, at most, along either axis.
glm::dvec2 planarReach(const proto::Frame& frame, double radius_m) {
  const glm::dvec2 x = frame.axis_x_m, y = frame.axis_y_m;
  return radius_m / (x.x * y.y - x.y * y.x) * glm::dvec2(glm::length(y), glm::length(x)) + 1e-9;
}

// The same: rows of geographic scenes are shorter towards the poles.
glm::dvec2 reachOf(const proto::FrameTransform& transform, const proto::GridShape& shape, const glm::dvec2& observer,
                   double radius_m) {
  if (transform.frame().kind == proto::FrameKind::kPlanar) return planarReach(transform.frame(), radius_m);
  // Steps of a face differ by a factor of 1.42 at most.
  if (shape.is_cube) return 2 * radius_m / spacingAt(transform, observer);
  const glm::dvec2 here = spacingAt(transform, observer);
  // The chord is shorter than the way along the surface; both are the same to the fourth digit up to 300 km.
  const double reach_y = std::min(1.3 * radius_m / here.y, 2.0 * shape.samples_y);
  double shortest = here.x;
  for (double y : {observer.y - reach_y, observer.y + reach_y})
    shortest = std::min(shortest, spacingAt(transform, {observer.x, std::clamp(y, 0.0, shape.samples_y - 1.0)}).x);
  return {std::min(1.3 * radius_m / std::max(shortest, 1e-9), 2.0 * shape.samples_x), reach_y};
}

// Where cells may lie: the data, of a globe the observer's face of them, whose east side may be named by another one.
struct Reachable {
  glm::dvec2 low{0}, high{0};
};
Reachable reachableFrom(const proto::GridTopology& grid, const glm::dvec2& observer) {
  const proto::GridShape& shape = grid.shape();
  if (!shape.is_cube) return {{0, 0}, {shape.samples_x - 1.0, shape.samples_y - 1.0}};
  const double side = grid.rootSize(), face = std::min(std::floor(observer.x / side), proto::Cube::kFaces - 1.0);
  return {{face * side, 0}, {std::nextafter((face + 1) * side, 0), side}};
}

// The multiples of `step` within `reach` of `at` and within first..last: the first and how many.
std::pair<double, double> multiples(double at, double reach, double step, double first, double last) {
  const double low = std::ceil(std::max(first, at - reach) / step),
               high = std::floor(std::min(last, at + reach) / step);
  return {low * step, std::max(0.0, high - low + 1)};
}

}  // namespace

Result<ViewshedGrid> Viewshed::gridOf(const Hierarchy& hierarchy, const ViewshedQuestion& q, uint64_t max_cells) {
  if (Status s = check(q); !s.ok()) return s.error();
  const proto::GridShape& shape = hierarchy.grid().shape();
  const double last_x = shape.samples_x - 1.0, last_y = shape.samples_y - 1.0;
  if (!(q.observer.x >= 0 && q.observer.y >= 0 && q.observer.x <= last_x && q.observer.y <= last_y))
    return refused("the observer stands beyond the data");
  const proto::FrameTransform& transform = hierarchy.frame().transform();
  ViewshedGrid grid;
  const auto [low, high] = reachableFrom(hierarchy.grid(), q.observer);
  const glm::dvec2 inside = shape.is_cube ? glm::clamp(q.observer, low + 0.5, high - 0.5) : q.observer;
  if (q.cell_m) grid.step = *q.cell_m / spacingAt(transform, inside);
  const glm::dvec2 reach = reachOf(transform, shape, inside, q.radius_m);
  const auto [x, columns] = multiples(q.observer.x, reach.x, grid.step.x, low.x, high.x);
  const auto [y, rows] = multiples(q.observer.y, reach.y, grid.step.y, low.y, high.y);
  if (columns * rows > static_cast<double>(max_cells))
    return Error{ErrorCode::kLimit, "viewshed: more than " + std::to_string(max_cells) +
                                        " cells; ask for a smaller radius or for larger cells"};
  if (columns * rows < 1) return refused("no cell lies within the radius; ask for a larger one, or for smaller cells");
  grid.first = {x, y};
  grid.columns = static_cast<uint32_t>(columns), grid.rows = static_cast<uint32_t>(rows);
  return grid;
}

Viewshed::Viewshed(std::shared_ptr<const SightScene> scene, const ViewshedQuestion& question, const ViewshedGrid& grid)
    : scene_(std::move(scene)),
      question_(question),
      grid_(grid),
      time_(scene_->at(question.scene_time)),
      eye_(scene_->aboveGround(question.observer, question.observer_m, time_).value()),
      foot_(scene_->transform().toScene(proto::LatticePosition{question.observer.x, question.observer.y, 0})) {}

ViewshedCell Viewshed::cell(uint32_t column, uint32_t row, uint64_t* work) const {
  const glm::dvec2 at = grid_.middle(column, row);
  const glm::dvec3 foot = scene_->transform().toScene(proto::LatticePosition{at.x, at.y, 0});
  if (glm::distance(foot, foot_) > question_.radius_m) return ViewshedCell::kOutside;
  const std::optional<glm::dvec3> target = scene_->aboveGround(at, question_.target_m, time_);
  if (!target) return ViewshedCell::kOutside;
  return scene_->sees(eye_, *target, question_.refraction, time_, work) ? ViewshedCell::kSeen : ViewshedCell::kHidden;
}

}  // namespace foreland::server
