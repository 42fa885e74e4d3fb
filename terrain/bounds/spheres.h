// Saturated spheres, row by row: about the middle of each node's edge (proto/section/bounds.h), large enough for its
// children's spheres (bounds.h). A SphereRows caches the rows of children that neighbouring rows of parents share. One
// owner; reads nodes of the next finer level only.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/section/bounds.h"
#include "proto/space/geographic_tables.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/heights.h"
#include "terrain/bounds/node_row.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

// By how much a sphere holds its children's with room to spare.
inline constexpr double kSpherePad_m = 1e-5;

// Gives all nodes of a page (from slot `first` on) the largest of their radii; padding stays zero.
void widenSpheres(const proto::GridTopology& grid, proto::Slot first, std::span<NodeRecord> page);

// Scene positions of lattice points, several at a time. Immutable; any thread.
class RowPositions {
 public:
  // `tables` are those of the frame for all of the grid; the caller keeps them.
  RowPositions(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
               const proto::GeographicTables& tables);

  // Coordinates in a frame that differs from the scene's by a rotation and a translation only: distances are the same.
  struct Out {
    double *x, *y, *z;
  };
  // Positions of the samples of a row, or of the middles of the edges of its nodes.
  void fill(const NodeRow& row, const Out& out) const;
  void fillMiddles(const NodeRow& row, const Out& out) const;
  int32_t quanta(uint32_t x, uint32_t y) const { return heights_.clamped(x, y); }
  int32_t middleQuanta(proto::NodeId n) const;

 private:
  // Replaces the heights in metres that out.z holds by coordinates.
  void toPositions(const NodeRow& row, const Out& out) const;

  const proto::GridTopology* grid_;
  Heights heights_;
  proto::Frame frame_;
  double polar_;  // 1 - e^2
  const proto::GeographicTables& tables_;
};

class SphereRows {
 public:
  // The spheres hold the samples of `extremes`, too.
  SphereRows(const proto::GridTopology& grid, const proto::SphereLevels& levels, const RowPositions& positions,
             std::span<const RowPositions> extremes, std::span<const NodeRecord> nodes, int level);

  // Smallest radii that saturate the row's nodes, without padding; and the largest error of each node's children.
  void compute(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors);

 private:
  // Spheres on one lattice row, with an empty one more at either end, so loops need no bounds.
  struct Row {
    bool used = false;
    uint32_t y = 0;
    std::vector<double> x, y_m, z, radius;
    std::vector<uint8_t> error;
  };
  const Row& childRow(uint32_t y);
  // What a Row holds: samples, middles of nodes' edges, or the latter with the nodes' spheres.
  enum class Content : uint8_t { kSamples, kMiddles, kSpheres };
  void load(const RowPositions& positions, Row& row, const NodeRow& where, Content content);
  // The columns of a Row from sphere `offset` on.
  struct Spheres {
    Spheres(const Row& row, int offset);
    const double *x, *y, *z, *radius;
    const uint8_t* error;
  };
  void include(const Row& children, int offset, std::span<double> radii_m, std::span<uint8_t> child_errors) const;
  void includePairs(const Row& children, int offset, std::span<double> radii_m, std::span<uint8_t> child_errors) const;
  void corners(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors);
  void corners(const RowPositions& samples, const NodeRow& row, std::span<double> radii_m,
               std::span<uint8_t> child_errors);

  const proto::GridTopology& grid_;
  const proto::SphereLevels& levels_;
  const RowPositions& positions_;
  std::span<const RowPositions> extremes_;
  std::span<const NodeRecord> nodes_;
  NodeLevel level_;
  Row own_;
  std::array<Row, 3> kept_;
  size_t oldest_ = 0;
};

}  // namespace foreland::terrain
