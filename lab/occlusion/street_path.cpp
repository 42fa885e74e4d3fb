#include "lab/occlusion/street_path.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <queue>
#include <vector>

#include "server/view/ground.h"

namespace foreland::lab {

namespace {

constexpr double kCell_m = 2, kNearest_m = 2, kWide_m = 8;  // kWide_m: beyond that a street is as good as a place
constexpr double kSmooth_m = 15;                            // over which the way is straightened
constexpr Duration kStep = Duration::milliseconds(100);

// How far cells are from the nearest object's box, seen from above.
class Clearance {
 public:
  explicit Clearance(const server::SceneObjects& objects) {
    for (const server::ObjectBall& ball : objects.balls) {
      low_ = glm::min(low_, glm::dvec2(ball.middle) - ball.radius_m);
      high_ = glm::max(high_, glm::dvec2(ball.middle) + ball.radius_m);
    }
    columns_ = static_cast<int>((high_.x - low_.x) / kCell_m) + 1;
    rows_ = static_cast<int>((high_.y - low_.y) / kCell_m) + 1;
    metres_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), kWide_m);
    for (size_t i = 0; i < objects.set.size(); ++i) add(objects, i);
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double at(int x, int y) const { return metres_[index(x, y)]; }
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(columns_) + static_cast<size_t>(x);
  }
  glm::dvec2 middle(int x, int y) const { return low_ + kCell_m * glm::dvec2(x + 0.5, y + 0.5); }

 private:
  void add(const server::SceneObjects& objects, size_t object) {
    const proto::ObjectPlacement& placement = objects.set.placement(object);
    const terrain::DrawnBox& box = objects.hulls[placement.model].box;
    const double reach = objects.balls[object].radius_m + kWide_m;
    const glm::dvec2 from = (glm::dvec2(objects.balls[object].middle) - reach - low_) / kCell_m,
                     to = (glm::dvec2(objects.balls[object].middle) + reach - low_) / kCell_m;
    for (int y = std::max(0, static_cast<int>(from.y)); y <= std::min(rows_ - 1, static_cast<int>(to.y)); ++y)
      for (int x = std::max(0, static_cast<int>(from.x)); x <= std::min(columns_ - 1, static_cast<int>(to.x)); ++x) {
        const glm::dvec3 p = glm::conjugate(placement.orientation) *
                             (glm::dvec3(middle(x, y), placement.position.z) - placement.position) / placement.scale;
        const glm::dvec2 away = glm::max(
            glm::max(glm::dvec2(box.low) - glm::dvec2(p), glm::dvec2(p) - glm::dvec2(box.high)), glm::dvec2(0));
        double& metres = metres_[index(x, y)];
        metres = std::min(metres, glm::length(away) * placement.scale);
      }
  }

  glm::dvec2 low_{std::numeric_limits<double>::infinity()}, high_{-std::numeric_limits<double>::infinity()};
  int columns_ = 0, rows_ = 0;
  std::vector<double> metres_;
};

// Dijkstra's, from the western side to the eastern one; what is close to objects costs more.
std::vector<glm::dvec2> wayThrough(const Clearance& clearance) {
  struct Reached {
    double cost;
    int x, y;
    bool operator<(const Reached& other) const { return cost > other.cost; }
  };
  const size_t cells = static_cast<size_t>(clearance.columns()) * static_cast<size_t>(clearance.rows());
  std::vector<double> cost(cells, std::numeric_limits<double>::infinity());
  std::vector<int8_t> came(cells, -1);
  std::priority_queue<Reached> next;
  constexpr int kSteps[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
  const int west = clearance.columns() / 8, east = clearance.columns() * 7 / 8;
  for (int y = clearance.rows() / 3; y < clearance.rows() * 2 / 3; ++y)
    if (clearance.at(west, y) >= kNearest_m) next.push({cost[clearance.index(west, y)] = 0, west, y});
  while (!next.empty()) {
    const Reached at = next.top();
    next.pop();
    if (at.cost > cost[clearance.index(at.x, at.y)]) continue;
    if (at.x >= east) {
      std::vector<glm::dvec2> way;
      for (int x = at.x, y = at.y;;) {
        way.push_back(clearance.middle(x, y));
        const int8_t step = came[clearance.index(x, y)];
        if (step < 0) break;
        x -= kSteps[step][0];
        y -= kSteps[step][1];
      }
      std::reverse(way.begin(), way.end());
      return way;
    }
    for (int8_t step = 0; step < 8; ++step) {
      const int x = at.x + kSteps[step][0], y = at.y + kSteps[step][1];
      if (x < west || y < 0 || x >= clearance.columns() || y >= clearance.rows() || clearance.at(x, y) < kNearest_m)
        continue;
      const double length = step < 4 ? 1 : std::sqrt(2.0);
      const double there = at.cost + length * std::pow(kWide_m / clearance.at(x, y), 2);
      if (there >= cost[clearance.index(x, y)]) continue;
      cost[clearance.index(x, y)] = there;
      came[clearance.index(x, y)] = step;
      next.push({there, x, y});
    }
  }
  return {};
}

// Each point becomes the mean of those about it.
std::vector<glm::dvec2> smoothed(const std::vector<glm::dvec2>& way) {
  const auto half = static_cast<ptrdiff_t>(kSmooth_m / kCell_m / 2), count = static_cast<ptrdiff_t>(way.size());
  std::vector<glm::dvec2> out;
  for (ptrdiff_t i = 0; i < count; ++i) {
    glm::dvec2 sum{0};
    const ptrdiff_t n = std::min({half, i, count - 1 - i});
    for (ptrdiff_t k = i - n; k <= i + n; ++k) sum += way[static_cast<size_t>(k)];
    out.push_back(sum / static_cast<double>(2 * n + 1));
  }
  return out;
}

}  // namespace

Result<proto::Path> streetPath(const server::Hierarchy& hierarchy, const StreetOptions& options) {
  if (hierarchy.objects().balls.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "the scene has no objects, so it has no streets; make a town with `foreland synth --town`"};
  const std::vector<glm::dvec2> way = smoothed(wayThrough(Clearance(hierarchy.objects())));
  if (way.size() < 2) return Error{ErrorCode::kInvalidArgument, "no street leads through the scene's objects"};
  const proto::FrameTransform& frame = hierarchy.frame().transform();
  proto::Path path{Time{}, kStep, {}};
  const double step_m = options.speed_mps * kStep.toSeconds();
  double wanted = 0, walked = 0;
  glm::dvec2 ahead = glm::normalize(way[1] - way[0]);
  for (size_t i = 0; i + 1 < way.size() && path.poses.size() * kStep.toSeconds() < options.seconds; ++i) {
    const double length = glm::distance(way[i], way[i + 1]);
    if (length <= 0) continue;
    for (; wanted < walked + length && path.poses.size() * kStep.toSeconds() < options.seconds; wanted += step_m) {
      const glm::dvec2 p = way[i] + (wanted - walked) / length * (way[i + 1] - way[i]);
      ahead = glm::normalize(0.9 * ahead + 0.1 * (way[i + 1] - way[i]) / length);
      proto::LatticePosition at = frame.toLattice(glm::dvec3(p, 0));
      at.height_m = server::groundHeight(hierarchy.scene(), at.x, at.y).value_or(0) + options.height_m;
      path.poses.push_back({frame.toScene(at), proto::lookAlong(glm::dvec3(ahead, 0), {0, 0, 1})});
    }
    walked += length;
  }
  return path;
}

}  // namespace foreland::lab
