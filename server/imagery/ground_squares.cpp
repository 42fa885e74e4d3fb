#include "server/imagery/ground_squares.h"

#include <algorithm>
#include <limits>

#include "terrain/store/flat_squares.h"

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
  levels_.push_back(hierarchy.scene().isSparse() ? finestOfSparse(hierarchy.scene()) : finest(hierarchy));
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

// Of the squares of the lattice that are flat, which may be larger than these; heights between nodes are rounded.
GroundSquares::Level GroundSquares::finestOfSparse(const terrain::Scene& scene) const {
  const proto::GridShape& shape = scene.grid().shape();
  const uint32_t last = side(0) - 1;
  Level level{(shape.samples_x - 1 + last) >> finest_log2_, (shape.samples_y - 1 + last) >> finest_log2_, {}};
  level.squares.assign(size_t{level.columns} * level.rows, kNothing);
  const auto quantum_m = static_cast<float>(scene.frame().height_quantum_m);
  terrain::FlatSquares(scene.grid(), scene.pages()).forEach([&](uint32_t x, uint32_t y, uint32_t size) {
    const auto height = [&](uint32_t dx, uint32_t dy) {
      return static_cast<float>(scene.height(proto::NodeId::at(x + dx, y + dy))) * quantum_m;
    };
    const float a = height(0, 0), b = height(size, 0), c = height(0, size), d = height(size, size);
    const auto samples = static_cast<float>(size);
    Square part = kNothing;
    for (const float h : {a, b, c, d}) include(h - quantum_m, part), include(h + quantum_m, part);
    for (const float along_x : {b - a, d - c})
      for (const float along_y : {c - a, d - b})
        for (const float off : {-2 * quantum_m, 2 * quantum_m})
          includeRise((along_x + off) / samples, (along_y + off) / samples, part);
    for (uint32_t j = y >> finest_log2_; j <= (y + size - 1) >> finest_log2_; ++j)
      for (uint32_t i = x >> finest_log2_; i <= (x + size - 1) >> finest_log2_; ++i)
        include(part, level.squares[size_t{j} * level.columns + i]);
  });
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
