#include "server/occlusion/horizon_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/check.h"

namespace foreland::server {

namespace {

constexpr uint32_t kFewestVertices = 17;  // along the shorter side, of a level

class Samples {
 public:
  explicit Samples(const Hierarchy& hierarchy)
      : columns(hierarchy.grid().shape().samples_x), rows(hierarchy.grid().shape().samples_y) {
    const proto::DenseNodes table = hierarchy.table();
    const double quantum_m = hierarchy.frame().transform().frame().height_quantum_m;
    heights_.reserve(size_t{columns} * rows);
    for (uint32_t y = 0; y < rows; ++y)
      for (uint32_t x = 0; x < columns; ++x)
        heights_.push_back(static_cast<float>(table.height(proto::NodeId::at(x, y)) * quantum_m));
  }
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

HorizonGrid::Level levelOf(const Samples& samples, uint32_t stride) {
  const uint32_t columns = (samples.columns - 1) / stride + 1, rows = (samples.rows - 1) / stride + 1;
  HorizonGrid::Level level{{rows, columns}, {columns, rows}, {lowered(samples, stride, columns, rows), {}}};
  std::vector<float>& turned = level.heights[1];
  turned.resize(level.heights[0].size());
  for (uint32_t j = 0; j < rows; ++j)
    for (uint32_t i = 0; i < columns; ++i) turned[size_t{i} * rows + j] = level.heights[0][size_t{j} * columns + i];
  for (std::vector<float>& heights : level.heights) heights.resize(heights.size() + HorizonGrid::kPadding);
  return level;
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
  while (size_t{shape.samples_x / stride_} * (shape.samples_y / stride_) > max_vertices) stride_ *= 2;
  const Samples samples(hierarchy);
  for (uint32_t stride = stride_;
       (std::min(samples.columns, samples.rows) - 1) / stride + 1 >= kFewestVertices || levels_.empty(); stride *= 2)
    levels_.push_back(levelOf(samples, stride));
  const glm::dmat2 to_scene(frame.axis_x_m, frame.axis_y_m);
  to_scene_ = to_scene * static_cast<double>(stride_);
  to_lattice_ = glm::inverse(to_scene);
  origin_m_ = -(to_scene * frame.anchor);
  steps_of_metre_ = largestStretch(to_lattice_) / stride_;
  metres_of_step_ = largestStretch(to_scene) * stride_;
  quantum_m_ = frame.height_quantum_m;
  highest_m_ = hierarchy.scene().heightRange().highest * frame.height_quantum_m;
}

size_t HorizonGrid::bytes() const {
  size_t bytes = 0;
  for (const Level& level : levels_)
    bytes += (level.heights[0].capacity() + level.heights[1].capacity()) * sizeof(float);
  return bytes;
}

}  // namespace foreland::server
