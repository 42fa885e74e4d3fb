#include "server/imagery/ground_squares.h"

#include <algorithm>
#include <limits>

namespace foreland::server {

namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr GroundSquares::Square kNothing{kFar, -kFar, {kFar, kFar, kFar, kFar}, {-kFar, -kFar, -kFar, -kFar}};

void include(float height_m, GroundSquares::Square& square) {
  square.lowest_m = std::min(square.lowest_m, height_m);
  square.highest_m = std::max(square.highest_m, height_m);
}

void includeRise(float x, float y, GroundSquares::Square& square) {
  const std::array<float, 4> rise{x, y, x + y, x - y};
  for (size_t k = 0; k < rise.size(); ++k) {
    square.min_rise_m[k] = std::min(square.min_rise_m[k], rise[k]);
    square.largest_rise_m[k] = std::max(square.largest_rise_m[k], rise[k]);
  }
}

void include(const GroundSquares::Square& part, GroundSquares::Square& square) {
  include(part.lowest_m, square);
  include(part.highest_m, square);
  for (size_t k = 0; k < part.min_rise_m.size(); ++k) {
    square.min_rise_m[k] = std::min(square.min_rise_m[k], part.min_rise_m[k]);
    square.largest_rise_m[k] = std::max(square.largest_rise_m[k], part.largest_rise_m[k]);
  }
}

}  // namespace

GroundSquares::GroundSquares(const Hierarchy& hierarchy, size_t max_squares) {
  const proto::GridShape& shape = hierarchy.grid().shape();
  while ((size_t{shape.samples_x} >> finest_log2_) * (size_t{shape.samples_y} >> finest_log2_) > max_squares)
    ++finest_log2_;
  levels_.push_back(finest(hierarchy));
  while (levels_.back().columns > 1 || levels_.back().rows > 1) levels_.push_back(coarser(levels_.back()));
}

// Whichever of its diagonals a cell is cut by, each of its triangles rises as one of its edges along x and one along y.
GroundSquares::Level GroundSquares::finest(const Hierarchy& hierarchy) const {
  const proto::GridShape& shape = hierarchy.grid().shape();
  const uint32_t cells_x = shape.samples_x - 1, cells_y = shape.samples_y - 1, last = side(0) - 1;
  Level level{(cells_x + last) >> finest_log2_, (cells_y + last) >> finest_log2_, {}};
  level.squares.assign(size_t{level.columns} * level.rows, kNothing);
  const proto::DenseNodes table = hierarchy.table();
  const double quantum_m = hierarchy.frame().transform().frame().height_quantum_m;
  const auto readRow = [&](uint32_t y, std::vector<float>& row) {
    row.resize(shape.samples_x);
    for (uint32_t x = 0; x < shape.samples_x; ++x)
      row[x] = static_cast<float>(table.height(proto::NodeId::at(x, y)) * quantum_m);
  };
  std::vector<float> south, north;
  readRow(0, south);
  for (uint32_t y = 0; y < cells_y; ++y) {
    readRow(y + 1, north);
    for (uint32_t x = 0; x < cells_x; ++x) {
      Square& square = level.squares[size_t{y >> finest_log2_} * level.columns + (x >> finest_log2_)];
      for (const float height : {south[x], south[x + 1], north[x], north[x + 1]}) include(height, square);
      for (const float along_x : {south[x + 1] - south[x], north[x + 1] - north[x]})
        for (const float along_y : {north[x] - south[x], north[x + 1] - south[x + 1]})
          includeRise(along_x, along_y, square);
    }
    south.swap(north);
  }
  return level;
}

GroundSquares::Level GroundSquares::coarser(const Level& fine) {
  Level coarse{(fine.columns + 1) / 2, (fine.rows + 1) / 2, {}};
  coarse.squares.assign(size_t{coarse.columns} * coarse.rows, kNothing);
  for (uint32_t j = 0; j < fine.rows; ++j)
    for (uint32_t i = 0; i < fine.columns; ++i)
      include(fine.squares[size_t{j} * fine.columns + i], coarse.squares[size_t{j / 2} * coarse.columns + i / 2]);
  return coarse;
}

size_t GroundSquares::bytes() const {
  size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.squares.capacity() * sizeof(Square);
  return bytes;
}

}  // namespace foreland::server
