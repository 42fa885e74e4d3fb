#include "server/occlusion/horizon/globe_heights.h"

#include <algorithm>
#include <numbers>

#include "server/occlusion/horizon/lowest_cells.h"
#include "server/section/globe_triangles.h"

namespace foreland::server {

namespace {

constexpr double kReach_m = 24e3;          // of heights from the place, at most
constexpr double kReachOfRadius = 0.25;    // of a small body's
constexpr uint32_t kMostSteps = 1536;      // along a side
constexpr double kFinest = 0.25;           // of the finest lattice's spacing
constexpr double kWithin = 0.25;           // of the spacing, within which ground need not be looked at in detail
constexpr double kFloatRounding_m = 0.01;  // of heights as floats
constexpr uint32_t kLevels = 5;
constexpr uint32_t kMargin = 2u << (kLevels - 1);  // cells beside the vertices: what those of the last level look at

// All ground that lies over the cells.
class Walk {
 public:
  Walk(const Hierarchy& hierarchy, const LocalPlane& plane, double reach_m, LowestCells& cells,
       const std::stop_token& stop)
      : hierarchy_(hierarchy),
        triangles_(hierarchy),
        plane_(plane),
        reach_m_(reach_m),
        below_m_(-hierarchy.frame().transform().frame().semiMinor()),
        within_m_(kWithin * cells.spacing()),
        cells_(cells),
        stop_(stop) {}

  bool overAll() {
    const int32_t side = triangles_.side();
    for (uint32_t face = 0; face < proto::Cube::kFaces && !stop_.stop_requested(); ++face) {
      const auto at = [&](int32_t x, int32_t y) { return placed(triangles_.base(face, x, y)); };
      const std::array<Corner, 4> corners{at(0, 0), at(side, 0), at(side, side), at(0, side)};
      const Corner middle = at(side / 2, side / 2);
      for (size_t i = 0; i < 4; ++i) over(face, corners[i], corners[(i + 1) % 4], middle, 1);
    }
    return !stop_.stop_requested();
  }

 private:
  struct Corner {
    int32_t x, y;
    glm::dvec3 position;  // in the plane's axes
  };
  Corner placed(const GlobeTriangles::Vertex& v) const {
    return {v.x, v.y, plane_.point(hierarchy_.frame().position(v.name, v.height))};
  }

  // The triangle whose longest edge, from a to b, a node of this level halves; or none.
  void over(uint32_t face, const Corner& a, const Corner& b, const Corner& apex, int level) {
    const auto node = triangles_.halfway(face, a.x, a.y, b.x, b.y, level);
    const double error_m = node ? node->error_m : 0;
    const glm::dvec3 low = glm::min(glm::min(a.position, b.position), apex.position) - error_m,
                     high = glm::max(glm::max(a.position, b.position), apex.position) + error_m;
    const bool is_beside = low.x > reach_m_ || low.y > reach_m_ || high.x < -reach_m_ || high.y < -reach_m_;
    if (is_beside || high.z < below_m_) return;  // or on the other side of the globe
    if (!node || error_m <= within_m_) return cells_.include({a.position, b.position, apex.position}, error_m);
    if (stop_.stop_requested()) return;
    const Corner half = placed(node->vertex);
    over(face, apex, a, half, level + 1);
    over(face, b, apex, half, level + 1);
  }

  const Hierarchy& hierarchy_;
  const GlobeTriangles triangles_;
  const LocalPlane& plane_;
  const double reach_m_, below_m_, within_m_;
  LowestCells& cells_;
  const std::stop_token& stop_;
};

// The lowest of squares of cells, each from its own cell on; of twice as many along both axes each time.
class LowestSquares {
 public:
  explicit LowestSquares(const LowestCells& cells) : columns_(cells.columns()), rows_(cells.rows()) {
    lowest_.reserve(size_t{columns_} * rows_);
    for (uint32_t j = 0; j < rows_; ++j)
      for (uint32_t i = 0; i < columns_; ++i) lowest_.push_back(cells.of(i, j));
  }
  // Squares that reach beyond the last cells are of those that are there.
  void widen() {
    for (uint32_t j = 0; j < rows_; ++j) {
      float* const row = &lowest_[size_t{j} * columns_];
      for (uint32_t i = 0; i + side_ < columns_; ++i) row[i] = std::min(row[i], row[i + side_]);
    }
    const size_t further = size_t{side_} * columns_;
    for (size_t k = 0; k + further < lowest_.size(); ++k) lowest_[k] = std::min(lowest_[k], lowest_[k + further]);
    side_ *= 2;
  }
  uint32_t side() const { return side_; }  // cells
  float from(uint32_t i, uint32_t j) const { return lowest_[size_t{j} * columns_ + i]; }

 private:
  uint32_t columns_, rows_, side_ = 1;
  std::vector<float> lowest_;
};

// A vertex has the ground of two spacings of its level to each side: so has a point between it and the next one that
// of one spacing.
std::vector<LevelHeights> levelsOf(const LowestCells& cells) {
  LowestSquares squares(cells);
  std::vector<LevelHeights> levels;
  const uint32_t vertices = cells.columns() - 2 * kMargin + 1;
  for (uint32_t level = 0; level < kLevels; ++level) {
    const uint32_t spacing = 1u << level, side = (vertices - 1) / spacing + 1;
    while (squares.side() < 4 * spacing) squares.widen();
    LevelHeights heights{side, side, {}};
    heights.heights_m.reserve(size_t{side} * side);
    for (uint32_t j = 0; j < side; ++j)
      for (uint32_t i = 0; i < side; ++i)
        heights.heights_m.push_back(
            squares.from(kMargin + i * spacing - 2 * spacing, kMargin + j * spacing - 2 * spacing) -
            static_cast<float>(kFloatRounding_m));
    levels.push_back(std::move(heights));
  }
  return levels;
}

}  // namespace

double globeHeightsReach(const proto::Frame& frame) { return std::min(kReach_m, kReachOfRadius * frame.semiMinor()); }

std::optional<GlobeHeights> globeHeights(const Hierarchy& hierarchy, const LocalPlane& plane,
                                         const std::stop_token& stop) {
  const proto::Frame& frame = hierarchy.frame().transform().frame();
  const double reach_m = globeHeightsReach(frame),
               finest_m = 0.5 * std::numbers::pi * frame.semi_major_m / frame.face_steps,
               wanted_m = std::max(kFinest * finest_m, 2 * reach_m / kMostSteps);
  const auto steps = static_cast<uint32_t>(2 * reach_m / wanted_m);
  GlobeHeights heights{plane, glm::dvec2(-reach_m), 2 * reach_m / steps, {}};
  const double margin_m = kMargin * heights.spacing_m;
  LowestCells cells(heights.low_m - margin_m, heights.spacing_m, steps + 2 * kMargin, steps + 2 * kMargin);
  if (!Walk(hierarchy, plane, reach_m + margin_m, cells, stop).overAll()) return std::nullopt;
  heights.levels = levelsOf(cells);
  return heights;
}

}  // namespace foreland::server
