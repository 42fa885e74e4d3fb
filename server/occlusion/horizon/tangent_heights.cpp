#include "server/occlusion/horizon/tangent_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "proto/space/geographic_tables.h"
#include "server/occlusion/horizon/lowest_cells.h"
#include "server/section/height_bounds.h"
#include "terrain/store/flat_squares.h"

namespace foreland::server {

namespace {

constexpr double kMaxExtent_m = 200e3;     // from the origin
constexpr double kMaxLatitude_rad = 1.3;   // 75 degrees
constexpr double kFinest = 0.25;           // of the samples' spacing
constexpr double kCoarse = 1.2;            // the same, from which on corners will do
constexpr double kFloatRounding_m = 0.01;  // of heights as floats

using Corners = LowestCells::Corners;

class Ground {
 public:
  explicit Ground(const Hierarchy& hierarchy)
      : columns(hierarchy.grid().shape().samples_x),
        rows(hierarchy.grid().shape().samples_y),
        scene_(hierarchy.scene()),
        bounds_(hierarchy),
        transform_(hierarchy.frame().transform()),
        tables_(transform_, columns - 1, rows - 1) {}
  glm::dvec3 at(uint32_t x, uint32_t y) const {
    const proto::NodeId v = proto::NodeId::at(x, y);
    // Between nodes heights are rounded.
    const int32_t lowest = scene_.isSparse() ? scene_.height(v) - 1 : bounds_.lowest(v);
    return transform_.fromTables(tables_.rows[y], tables_.columns[x], lowest * transform_.frame().height_quantum_m);
  }

  const uint32_t columns, rows;

 private:
  const terrain::Scene& scene_;
  HeightBounds bounds_;
  proto::FrameTransform transform_;
  proto::GeographicTables tables_;
};

// A rectangle along the scene's axes that the ground fills.
struct Inside {
  glm::dvec2 low{-kMaxExtent_m}, high{kMaxExtent_m};
  double farthest_m = 0;  // of the border, from the origin
};

Inside insideOf(const Ground& ground) {
  Inside inside;
  const auto include = [&](const glm::dvec3& p) { inside.farthest_m = std::max(inside.farthest_m, glm::length(p)); };
  for (uint32_t y = 0; y < ground.rows; ++y) {
    const glm::dvec3 west = ground.at(0, y), east = ground.at(ground.columns - 1, y);
    inside.low.x = std::max(inside.low.x, west.x), inside.high.x = std::min(inside.high.x, east.x);
    include(west), include(east);
  }
  for (uint32_t x = 0; x < ground.columns; ++x) {
    const glm::dvec3 south = ground.at(x, 0), north = ground.at(x, ground.rows - 1);
    inside.low.y = std::max(inside.low.y, south.y), inside.high.y = std::min(inside.high.y, north.y);
    include(south), include(north);
  }
  return inside;
}

// Of coarser cells planes say little more than corners, which take less than half the time.
bool isByPlanes(double spacing_m, const glm::dvec2& cell) { return spacing_m < kCoarse * std::max(cell.x, cell.y); }

// The ground over a square with these corners, cut by either diagonal.
void includeSquare(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, bool by_planes,
                   LowestCells& cells) {
  if (!by_planes)
    return cells.include(glm::min(glm::min(a, b), glm::min(c, d)), glm::max(glm::max(a, b), glm::max(c, d)));
  for (const Corners& corners : {Corners{a, b, c}, Corners{d, c, b}, Corners{a, b, d}, Corners{a, d, c}})
    cells.include(corners);
}

// Each gives the side of its widest square, in samples.
uint32_t includeSamples(const Ground& ground, const glm::dvec2& cell, LowestCells& cells) {
  const bool by_planes = isByPlanes(cells.spacing(), cell);
  std::vector<glm::dvec3> south(ground.columns), north(ground.columns);
  const auto readRow = [&](uint32_t row, std::vector<glm::dvec3>& into) {
    for (uint32_t i = 0; i < ground.columns; ++i) into[i] = ground.at(i, row);
  };
  readRow(0, south);
  for (uint32_t j = 1; j < ground.rows; ++j) {
    readRow(j, north);
    for (uint32_t i = 1; i < ground.columns; ++i)
      includeSquare(south[i - 1], south[i], north[i - 1], north[i], by_planes, cells);
    south.swap(north);
  }
  return 1;
}
uint32_t includeFlatSquares(const terrain::Scene& scene, const Ground& ground, const glm::dvec2& cell,
                            LowestCells& cells) {
  uint32_t widest = 1;
  terrain::FlatSquares(scene.grid(), scene.pages()).forEach([&](uint32_t x, uint32_t y, uint32_t side) {
    widest = std::max(widest, side);
    includeSquare(ground.at(x, y), ground.at(x + side, y), ground.at(x, y + side), ground.at(x + side, y + side),
                  isByPlanes(cells.spacing(), cell * double(side)), cells);
  });
  return widest;
}

}  // namespace

std::optional<TangentHeights> tangentHeights(const Hierarchy& hierarchy, size_t max_vertices) {
  const proto::FrameTransform& transform = hierarchy.frame().transform();
  const proto::Frame& frame = transform.frame();
  if (frame.kind != proto::FrameKind::kGeographic) return std::nullopt;
  const Ground ground(hierarchy);
  const double north_rad = frame.latitude0_rad + (ground.rows - 1) * frame.latitude_step_rad;
  if (std::max(std::fabs(frame.latitude0_rad), std::fabs(north_rad)) > kMaxLatitude_rad) return std::nullopt;
  const Inside inside = insideOf(ground);
  if (inside.farthest_m > kMaxExtent_m) return std::nullopt;
  const uint32_t x = ground.columns / 2, y = ground.rows / 2;
  const glm::dvec3 middle = ground.at(x, y);
  const glm::dvec2 cell(glm::length(glm::dvec2(ground.at(x - 1, y) - middle)),
                        glm::length(glm::dvec2(ground.at(x, y - 1) - middle)));
  const glm::dvec2 size = inside.high - inside.low;
  if (size.x <= 2 * cell.x || size.y <= 2 * cell.y) return std::nullopt;
  TangentHeights heights;
  heights.low_m = inside.low;
  heights.spacing_m = std::max(kFinest * std::min(cell.x, cell.y), std::sqrt(size.x * size.y / double(max_vertices)));
  heights.columns = static_cast<uint32_t>(size.x / heights.spacing_m);
  heights.rows = static_cast<uint32_t>(size.y / heights.spacing_m);
  if (heights.columns < 2 || heights.rows < 2) return std::nullopt;
  LowestCells cells(heights.low_m, heights.spacing_m, heights.columns - 1, heights.rows - 1);
  const uint32_t widest = hierarchy.scene().isSparse() ? includeFlatSquares(hierarchy.scene(), ground, cell, cells)
                                                       : includeSamples(ground, cell, cells);
  // The ground between samples bends below their triangles where the scene is not level.
  const double bend_m = glm::dot(cell, cell) * widest * widest / frame.minRadius();
  heights.heights_m.reserve(size_t{heights.columns} * heights.rows);
  for (uint32_t j = 0; j < heights.rows; ++j)
    for (uint32_t i = 0; i < heights.columns; ++i)
      heights.heights_m.push_back(cells.lowestAbout(i, j) - static_cast<float>(bend_m + kFloatRounding_m));
  return heights;
}

}  // namespace foreland::server
