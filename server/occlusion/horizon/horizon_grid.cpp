#include "server/occlusion/horizon/horizon_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "server/section/height_bounds.h"
#include "terrain/store/flat_squares.h"

namespace foreland::server {

namespace {

constexpr size_t kMostOfSparse = 2u << 20;  // vertices, where ground is fine in places only: each is looked up
constexpr uint32_t kFewestVertices = 17;    // along the shorter side, of a level
constexpr double kMaxBend = 0.6;            // of a square of the size over the radius: an eighth of it upward, and that
                                            // times the tangent of the latitude sideways, 3.7 at most

class Samples {
 public:
  explicit Samples(const Hierarchy& hierarchy)
      : columns(hierarchy.grid().shape().samples_x), rows(hierarchy.grid().shape().samples_y) {
    const HeightBounds bounds(hierarchy);
    const double quantum_m = hierarchy.frame().transform().frame().height_quantum_m;
    heights_.reserve(size_t{columns} * rows);
    for (uint32_t y = 0; y < rows; ++y)
      for (uint32_t x = 0; x < columns; ++x)
        heights_.push_back(static_cast<float>(bounds.lowest(proto::NodeId::at(x, y)) * quantum_m));
  }
  explicit Samples(const TangentHeights& heights)
      : columns(heights.columns), rows(heights.rows), heights_(heights.heights_m) {}
  float operator()(uint32_t x, uint32_t y) const { return heights_[size_t{y} * columns + x]; }

  const uint32_t columns, rows;

 private:
  std::vector<float> heights_;
};

// How far the line between two samples rises above those between them, at most.
template <class Height>
float excess(uint32_t stride, const Height& height) {
  const float first = height(0), last = height(stride);
  float most = 0;
  for (uint32_t k = 1; k < stride; ++k)
    most = std::max(most, first + (last - first) * static_cast<float>(k) / static_cast<float>(stride) - height(k));
  return most;
}

// Vertices `stride` samples apart, row by row, each lowered by the largest excess of its edges.
std::vector<float> lowered(const Samples& samples, uint32_t stride, uint32_t columns, uint32_t rows) {
  std::vector<float> most(size_t{columns} * rows, 0);
  const auto raise = [&](uint32_t i, uint32_t j, float to) {
    float& m = most[size_t{j} * columns + i];
    m = std::max(m, to);
  };
  for (uint32_t j = 0; j < rows; ++j)
    for (uint32_t i = 0; i < columns; ++i) {
      const uint32_t x = i * stride, y = j * stride;
      if (i + 1 < columns) {
        const float e = excess(stride, [&](uint32_t k) { return samples(x + k, y); });
        raise(i, j, e);
        raise(i + 1, j, e);
      }
      if (j + 1 < rows) {
        const float e = excess(stride, [&](uint32_t k) { return samples(x, y + k); });
        raise(i, j, e);
        raise(i, j + 1, e);
      }
    }
  for (uint32_t j = 0; j < rows; ++j)
    for (uint32_t i = 0; i < columns; ++i) {
      float& m = most[size_t{j} * columns + i];
      m = samples(i * stride, j * stride) - m;
    }
  return most;
}

std::vector<LevelHeights> heightsOf(const Samples& samples, uint32_t stride) {
  std::vector<LevelHeights> levels;
  for (; (std::min(samples.columns, samples.rows) - 1) / stride + 1 >= kFewestVertices || levels.empty(); stride *= 2) {
    const uint32_t columns = (samples.columns - 1) / stride + 1, rows = (samples.rows - 1) / stride + 1;
    levels.push_back({columns, rows, lowered(samples, stride, columns, rows)});
  }
  return levels;
}

// The same of ground that is fine in places. Between the corners of its flat squares it is straight along the lattice's
// lines, so only these can lie below the line between two vertices. Heights between nodes are rounded: all are lowered
// by a quantum.
std::vector<LevelHeights> heightsOf(const terrain::Scene& scene, uint32_t stride) {
  const proto::GridShape& shape = scene.grid().shape();
  const double quantum_m = scene.frame().height_quantum_m;
  const auto metres = [&](uint32_t x, uint32_t y) {
    return static_cast<float>(scene.height(proto::NodeId::at(x, y)) * quantum_m);
  };
  struct Level {
    uint32_t stride, columns, rows;
    std::vector<float> heights, excess;
  };
  std::vector<Level> levels;
  for (; (std::min(shape.samples_x, shape.samples_y) - 1) / stride + 1 >= kFewestVertices || levels.empty();
       stride *= 2) {
    Level level{stride, (shape.samples_x - 1) / stride + 1, (shape.samples_y - 1) / stride + 1, {}, {}};
    for (uint32_t j = 0; j < level.rows; ++j)
      for (uint32_t i = 0; i < level.columns; ++i) level.heights.push_back(metres(i * stride, j * stride));
    level.excess.resize(level.heights.size());
    levels.push_back(std::move(level));
  }
  const auto lower = [](Level& level, size_t first, size_t second, uint32_t along, float height) {
    const float a = level.heights[first], b = level.heights[second],
                line = a + (b - a) * static_cast<float>(along) / static_cast<float>(level.stride);
    for (const size_t v : {first, second}) level.excess[v] = std::max(level.excess[v], line - height);
  };
  terrain::FlatSquares(scene.grid(), scene.pages()).forEach([&](uint32_t x, uint32_t y, uint32_t side) {
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t at_x = x + side * (k % 2), at_y = y + side * (k / 2);
      const float height = metres(at_x, at_y);
      for (Level& level : levels) {
        const uint32_t i = at_x / level.stride, j = at_y / level.stride, u = at_x % level.stride,
                       v = at_y % level.stride;
        const size_t at = size_t{j} * level.columns + i;
        if (v == 0 && u > 0 && i + 1 < level.columns && j < level.rows) lower(level, at, at + 1, u, height);
        if (u == 0 && v > 0 && j + 1 < level.rows && i < level.columns) lower(level, at, at + level.columns, v, height);
      }
    }
  });
  std::vector<LevelHeights> out;
  for (Level& level : levels) {
    for (size_t v = 0; v < level.heights.size(); ++v)
      level.heights[v] -= level.excess[v] + static_cast<float>(quantum_m);
    out.push_back({level.columns, level.rows, std::move(level.heights)});
  }
  return out;
}

HorizonGrid::Steps stepsOf(const std::vector<LevelHeights>& levels) {
  constexpr double kMax = std::numeric_limits<uint16_t>::max();
  float least = std::numeric_limits<float>::infinity(), most = -least;
  for (const LevelHeights& level : levels) {
    const auto [low, high] = std::ranges::minmax(level.heights_m);
    least = std::min(least, low), most = std::max(most, high);
  }
  return {least, std::max(1e-6, (double{most} - least) / kMax)};
}

// The largest step that is no higher.
uint16_t roundDown(double height_m, const HorizonGrid::Steps& steps) {
  auto step = static_cast<int64_t>(std::min<double>(steps.of(height_m), std::numeric_limits<uint16_t>::max()));
  if (step > 0 && steps.metres(static_cast<double>(step)) > height_m) --step;
  return static_cast<uint16_t>(step);
}

HorizonGrid::Level levelOf(const LevelHeights& of, const HorizonGrid::Steps& steps) {
  HorizonGrid::Level level{{of.rows, of.columns}, {of.columns, of.rows}, {}};
  for (std::vector<uint16_t>& heights : level.heights) heights.resize(of.heights_m.size() + HorizonGrid::kPadding);
  for (size_t j = 0, k = 0; j < of.rows; ++j)
    for (size_t i = 0; i < of.columns; ++i, ++k)
      level.heights[0][k] = level.heights[1][i * of.rows + j] = roundDown(of.heights_m[k], steps);
  return level;
}

std::pair<HorizonGrid::Steps, std::vector<HorizonGrid::Level>> levelsOf(const std::vector<LevelHeights>& heights) {
  const HorizonGrid::Steps steps = stepsOf(heights);
  std::vector<HorizonGrid::Level> levels;
  for (const LevelHeights& level : heights) levels.push_back(levelOf(level, steps));
  return {steps, std::move(levels)};
}

// The larger singular value.
double largestStretch(const glm::dmat2& m) {
  const double sum = glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]), determinant = glm::determinant(m);
  return std::sqrt(0.5 * (sum + std::sqrt(std::max(0.0, sum * sum - 4 * determinant * determinant))));
}

}  // namespace

HorizonGrid::HorizonGrid(const Hierarchy& hierarchy, size_t max_vertices) {
  CHECK_TRUE(supports(hierarchy));
  const proto::Frame& frame = hierarchy.frame().transform().frame();
  const proto::GridShape& shape = hierarchy.grid().shape();
  const terrain::Scene& scene = hierarchy.scene();
  if (scene.isSparse()) max_vertices = std::min(max_vertices, kMostOfSparse);
  while (size_t{shape.samples_x / stride_} * (shape.samples_y / stride_) > max_vertices) stride_ *= 2;
  std::tie(steps_, levels_) =
      levelsOf(scene.isSparse() ? heightsOf(scene, stride_) : heightsOf(Samples(hierarchy), stride_));
  const glm::dmat2 to_scene(frame.axis_x_m, frame.axis_y_m);
  setAxes(to_scene * static_cast<double>(stride_), -(to_scene * frame.anchor));
  quantum_m_ = frame.height_quantum_m;
  highest_m_ = hierarchy.scene().heightRange().highest * frame.height_quantum_m;
}

HorizonGrid::HorizonGrid(const Hierarchy& hierarchy, const TangentHeights& heights)
    : geographic_(hierarchy.frame().transform()) {
  std::tie(steps_, levels_) = levelsOf(heightsOf(Samples(heights), 1));
  setAxes(glm::dmat2(heights.spacing_m), heights.low_m);
  quantum_m_ = geographic_->frame().height_quantum_m;
  highest_m_ = *std::max_element(heights.heights_m.begin(), heights.heights_m.end());
}

HorizonGrid::HorizonGrid(const GlobeHeights& heights) : plane_(heights.plane) {
  std::tie(steps_, levels_) = levelsOf(heights.levels);
  setAxes(glm::dmat2(heights.spacing_m), heights.low_m);
  highest_m_ = std::ranges::max(heights.levels.front().heights_m);
}

std::shared_ptr<const HorizonGrid> HorizonGrid::of(const Hierarchy& hierarchy, size_t max_vertices) {
  if (supports(hierarchy)) return std::make_shared<const HorizonGrid>(hierarchy, max_vertices);
  if (hierarchy.scene().isSparse()) max_vertices = std::min(max_vertices, 2 * kMostOfSparse);
  const auto heights = tangentHeights(hierarchy, max_vertices / 2);  // finer than the samples: half as many do
  return heights ? std::shared_ptr<const HorizonGrid>(new HorizonGrid(hierarchy, *heights)) : nullptr;
}

void HorizonGrid::setAxes(const glm::dmat2& step, const glm::dvec2& origin_m) {
  to_scene_ = step;
  to_grid_ = glm::inverse(step);
  origin_m_ = origin_m;
  steps_of_metre_ = largestStretch(to_grid_);
  metres_of_step_ = largestStretch(step);
}

HorizonGrid::Bounds HorizonGrid::boundsOf(const proto::LatticeBox& box, double lowest_m, double highest_m) const {
  if (!geographic_) return {box.low * stepsOfSample(), box.high * stepsOfSample(), highest_m};
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  const proto::Frame& frame = geographic_->frame();
  for (const double y : {box.low.y, box.high.y}) {
    const auto row = geographic_->row(frame.latitude0_rad + y * frame.latitude_step_rad);
    for (const double x : {box.low.x, box.high.x}) {
      const auto column = geographic_->column(frame.longitude0_rad + x * frame.longitude_step_rad);
      for (const double height_m : {lowest_m, highest_m}) {
        const glm::dvec3 p = geographic_->fromTables(row, column, height_m);
        low = glm::min(low, p), high = glm::max(high, p);
      }
    }
  }
  return boundsAbout(low, high);
}

HorizonGrid::Bounds HorizonGrid::boundsOf(const proto::FrameGrid& frame, const glm::uvec2& low, const glm::uvec2& high,
                                          int32_t lowest, int32_t highest) const {
  glm::dvec3 least(std::numeric_limits<double>::infinity()), most = -least;
  for (const uint32_t y : {low.y, high.y})
    for (const uint32_t x : {low.x, high.x})
      for (const int32_t height : {lowest, highest}) {
        const glm::dvec3 p = frame.position(proto::NodeId::at(x, y), height);
        least = glm::min(least, p), most = glm::max(most, p);
      }
  return boundsAbout(least, most);
}

// Between the corners of a box, whose bounds these are, the ground bends: upward by what its diagonal does on a sphere,
// and sideways as parallels do, more towards the poles; lower ground lies farther inward along its vertical.
HorizonGrid::Bounds HorizonGrid::boundsAbout(const glm::dvec3& low, const glm::dvec3& high) const {
  const glm::dvec2 size(high - low);
  const double bend_m = kMaxBend * glm::dot(size, size) / geographic_->frame().minRadius();
  return {toGrid(glm::dvec2(low) - bend_m), toGrid(glm::dvec2(high) + bend_m), high.z + bend_m};
}

size_t HorizonGrid::bytes() const {
  size_t bytes = 0;
  for (const Level& level : levels_)
    bytes += (level.heights[0].capacity() + level.heights[1].capacity()) * sizeof(uint16_t);
  return bytes;
}

}  // namespace foreland::server
