// The ground of a scene at full resolution: every sample, joined by the triangles of the finest section
// (proto/topology/grid.h), at any scene time. For rays it is cut into blocks of kBlock x kBlock cells. Immutable; any
// thread. Memory: four bytes a sample, and what HeightBounds takes of ground that moves.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "server/section/height_bounds.h"
#include "server/section/hierarchy.h"
#include "server/sight/box_tree.h"
#include "server/sight/sight_line.h"

namespace foreland::server {

// How far a vertex has moved at a scene time since the first epoch; quanta, upwards.
double offsetAt(const terrain::EpochTable& epochs, const proto::GridTopology& grid, proto::NodeId v,
                const proto::EpochWeights& time);

class GroundSurface {
 public:
  static constexpr uint32_t kBlock = 4;

  // `hierarchy` must outlive it. O(samples).
  explicit GroundSurface(const Hierarchy& hierarchy);
  static uint64_t bytesFor(const proto::GridShape& shape) {
    return uint64_t{shape.samples_x} * shape.samples_y * sizeof(int32_t);
  }

  uint32_t columns() const { return columns_; }
  uint32_t rows() const { return rows_; }
  uint32_t blocks() const { return blocks_x_ * blocks_y_; }
  // Scene frame; of a block it holds all that may be of the ground there at any time.
  Box boundsOf(uint32_t block) const;

  glm::dvec3 sample(uint32_t x, uint32_t y, const proto::EpochWeights& time) const {
    return frame_.position(proto::NodeId::at(x, y), height(x, y, time));
  }
  // Scene frame: on the triangle of the cell, which is flat also where the zero surface is not. Nothing beyond the
  // data.
  std::optional<glm::dvec3> pointAt(double lattice_x, double lattice_y, const proto::EpochWeights& time) const;

  // The first place of the line, within its ends, where a block's ground hides it: less than `before`, or nothing.
  std::optional<double> meet(const SightLine& line, uint32_t block, double before,
                             const proto::EpochWeights& time) const;

 private:
  // Of the cell (x, y) the diagonal goes from the south-west to the north-east; from the south-east otherwise.
  static bool isRising(uint32_t x, uint32_t y) { return (x + y) % 2 == 0; }
  // Quanta.
  double height(uint32_t x, uint32_t y, const proto::EpochWeights& time) const;

  const proto::FrameGrid& frame_;
  const proto::GridTopology& grid_;
  const terrain::EpochTable& epochs_;
  uint32_t columns_, rows_, blocks_x_, blocks_y_;
  std::vector<int32_t> heights_;  // at the first epoch, row by row
  std::optional<HeightBounds> moving_;
};

}  // namespace foreland::server
