// Saturated spheres, row by row: about the middle of each node's edge (proto/section/bounds.h), large enough for its
// children's spheres (bounds.h). A SphereRows keeps the rows of children that neighbouring rows of parents share. One
// owner; reads nodes of the next finer level only.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/section/bounds.h"
#include "proto/space/frame.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"
#include "terrain/bounds/node_row.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

// Scene positions of lattice points, several at a time. Immutable; any thread.
class RowPositions {
 public:
  RowPositions(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights);

  // Coordinates in some frame that differs from the scene's by a rotation and a shift only: distances are the same.
  struct Out {
    double *x, *y, *z;
  };
  // At the heights of the samples, or of the middles of the edges of the nodes of a level.
  void fill(const NodeRow& row, const Out& out) const;
  void fillMiddles(const NodeRow& row, const Out& out) const;
  int32_t steps(uint32_t x, uint32_t y) const { return heights_.clamped(x, y); }
  int32_t middleSteps(proto::NodeId n) const;

 private:
  // Coordinates of points whose z holds their height in metres.
  void place(const NodeRow& row, const Out& out) const;

  const proto::GridTopology* grid_;
  Heights heights_;
  proto::Frame frame_;
  double polar_;                                  // 1 - e^2
  std::vector<proto::FrameTransform::Row> rows_;  // geographic only
  std::vector<double> sin_lon_, cos_lon_;
};

class SphereRows {
 public:
  SphereRows(const proto::GridTopology& grid, const proto::SphereLevels& levels, const RowPositions& positions,
             std::span<const NodeRecord> nodes, int level);

  // Least radii of the row's nodes, unpadded; and the largest error of each node's children.
  void compute(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors);

 private:
  // Children on one lattice row, with one more at either end that reaches nowhere.
  struct Row {
    bool used = false;
    uint32_t y = 0;
    std::vector<double> x, y_m, z, radius;
    std::vector<uint8_t> error;
  };
  const Row& childRow(uint32_t y);
  // Samples; middles of nodes' edges; or these with the spheres of the nodes of `level`.
  enum class What : uint8_t { kSamples, kMiddles, kSpheres };
  void load(Row& row, const NodeRow& where, What what);
  void include(const Row& children, int offset, std::span<double> radii_m, std::span<uint8_t> child_errors) const;
  void includePairs(const Row& children, int offset, std::span<double> radii_m, std::span<uint8_t> child_errors) const;
  void corners(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors);

  const proto::GridTopology& grid_;
  const proto::SphereLevels& levels_;
  const RowPositions& positions_;
  std::span<const NodeRecord> nodes_;
  NodeLevel level_;
  Row own_;
  std::array<Row, 3> kept_;
  size_t oldest_ = 0;
};

}  // namespace foreland::terrain
