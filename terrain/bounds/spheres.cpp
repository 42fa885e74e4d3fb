#include "terrain/bounds/spheres.h"

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

namespace {

constexpr double kEmpty = -1e300;  // the radius of an empty sphere: nothing has to include it

}  // namespace

void widenSpheres(const proto::GridTopology& grid, proto::Slot first, std::span<NodeRecord> page) {
  proto::QuantisedRadius most;
  for (const NodeRecord& r : page) most = std::max(most, r.radius());
  for (size_t i = 0; i < page.size(); ++i) {
    NodeRecord& r = page[i];
    if (r != NodeRecord{} || grid.node(first + i) != proto::NodeId{})
      r = NodeRecord::of(r.height(), r.displacement(), r.error(), most);
  }
}

RowPositions::RowPositions(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
                           const proto::GeographicTables& tables)
    : grid_(&grid),
      heights_(heights),
      frame_(frame),
      polar_((1 - frame.flattening) * (1 - frame.flattening)),
      tables_(tables) {}

int32_t RowPositions::middleQuanta(proto::NodeId n) const {
  const auto [a, b] = grid_->endpoints(n);
  return proto::middleOf(quanta(a.x(), a.y()), quanta(b.x(), b.y()));
}

void RowPositions::fill(const NodeRow& row, const Out& out) const {
  const int32_t* quanta = heights_.row(std::min(row.y, heights_.height - 1));
  const uint32_t with_data =
      row.first_x >= heights_.width ? 0 : std::min(row.count, (heights_.width - 1 - row.first_x) / row.step_x + 1);
  for (uint32_t i = 0; i < with_data; ++i)
    out.z[i] = quanta[row.first_x + static_cast<size_t>(i) * row.step_x] * frame_.height_quantum_m;
  if (with_data < row.count)
    std::fill(out.z + with_data, out.z + row.count, quanta[heights_.width - 1] * frame_.height_quantum_m);
  toPositions(row, out);
}

void RowPositions::fillMiddles(const NodeRow& row, const Out& out) const {
  for (uint32_t i = 0; i < row.count; ++i) out.z[i] = middleQuanta(row.node(i)) * frame_.height_quantum_m;
  toPositions(row, out);
}

void RowPositions::toPositions(const NodeRow& row, const Out& out) const {
  if (frame_.kind == proto::FrameKind::kPlanar) {
    // Exact but for the anchor: a position does not depend on where its row begins.
    const double dy = row.y - frame_.anchor.y, x0 = row.first_x, step = row.step_x;
    for (uint32_t i = 0; i < row.count; ++i) {
      const double dx = (x0 + step * i) - frame_.anchor.x;
      out.x[i] = dx * frame_.axis_x_m.x + dy * frame_.axis_y_m.x;
      out.y[i] = dx * frame_.axis_x_m.y + dy * frame_.axis_y_m.y;
    }
    return;
  }
  const proto::FrameTransform::Row& lat = tables_.rows[row.y];
  for (uint32_t i = 0; i < row.count; ++i) {
    const proto::FrameTransform::Column& lon = tables_.columns[row.first_x + static_cast<size_t>(i) * row.step_x];
    const double height_m = out.z[i], ring = (lat.normal + height_m) * lat.cos;
    out.x[i] = ring * lon.cos;
    out.y[i] = ring * lon.sin;
    out.z[i] = (lat.normal * polar_ + height_m) * lat.sin;
  }
}

SphereRows::SphereRows(const proto::GridTopology& grid, const proto::SphereLevels& levels,
                       const RowPositions& positions, std::span<const RowPositions> extremes,
                       std::span<const NodeRecord> nodes, int level)
    : grid_(grid), levels_(levels), positions_(positions), extremes_(extremes), nodes_(nodes), level_(grid, level) {}

void SphereRows::load(const RowPositions& positions, Row& row, const NodeRow& where, Content content) {
  const size_t size = where.count + 2;
  for (auto* column : {&row.x, &row.y_m, &row.z, &row.radius}) column->resize(size);
  row.error.assign(size, 0);
  row.y = where.y;
  row.used = true;
  const RowPositions::Out out{row.x.data() + 1, row.y_m.data() + 1, row.z.data() + 1};
  if (content == Content::kSamples)
    positions.fill(where, out);
  else
    positions.fillMiddles(where, out);
  for (auto* column : {&row.x, &row.y_m, &row.z}) column->front() = column->back() = 0;
  std::fill(row.radius.begin(), row.radius.end(), 0.0);
  row.radius.front() = row.radius.back() = kEmpty;
  if (content != Content::kSpheres) return;
  const int level = level_.level + 1;
  where.forEachRun(grid_, [&](uint32_t i, proto::Slot slot, uint32_t count) {
    const NodeRecord* record = &nodes_[slot];
    for (uint32_t k = 0; k < count; ++k, record += where.slot_step) {
      row.radius[1 + i + k] = levels_.radius(level, record->radius());
      row.error[1 + i + k] = record->error().value;
    }
  });
}

const SphereRows::Row& SphereRows::childRow(uint32_t y) {
  for (const Row& row : kept_)
    if (row.used && row.y == y) return row;
  Row& row = kept_[oldest_];
  oldest_ = (oldest_ + 1) % kept_.size();
  load(positions_, row, NodeLevel(grid_, level_.level + 1).row(y), Content::kSpheres);
  return row;
}

SphereRows::Spheres::Spheres(const Row& row, int offset)
    : x(row.x.data() + 1 + offset),
      y(row.y_m.data() + 1 + offset),
      z(row.z.data() + 1 + offset),
      radius(row.radius.data() + 1 + offset),
      error(row.error.data() + 1 + offset) {}

void SphereRows::include(const Row& children, int offset, std::span<double> radii_m,
                         std::span<uint8_t> child_errors) const {
  const Spheres own(own_, 0), child(children, offset);
  double* out = radii_m.data();
  uint8_t* out_error = child_errors.data();
  const size_t count = radii_m.size();
  for (size_t i = 0; i < count; ++i) {
    const double dx = child.x[i] - own.x[i], dy = child.y[i] - own.y[i], dz = child.z[i] - own.z[i],
                 needed = std::sqrt(dx * dx + dy * dy + dz * dz) + child.radius[i];
    out[i] = needed > out[i] ? needed : out[i];
  }
  for (size_t i = 0; i < count; ++i) out_error[i] = child.error[i] > out_error[i] ? child.error[i] : out_error[i];
}

// As include, for rows with twice as many children: parent i includes children 2i + offset and 2i + offset + 1.
void SphereRows::includePairs(const Row& children, int offset, std::span<double> radii_m,
                              std::span<uint8_t> child_errors) const {
  const Spheres own(own_, 0), child(children, offset);
  double* out = radii_m.data();
  uint8_t* out_error = child_errors.data();
  const size_t count = radii_m.size();
  for (size_t i = 0; i < count; ++i) {
    const size_t k = 2 * i, l = k + 1;
    const double dx = child.x[k] - own.x[i], dy = child.y[k] - own.y[i], dz = child.z[k] - own.z[i],
                 west = std::sqrt(dx * dx + dy * dy + dz * dz) + child.radius[k];
    const double ex = child.x[l] - own.x[i], ey = child.y[l] - own.y[i], ez = child.z[l] - own.z[i],
                 east = std::sqrt(ex * ex + ey * ey + ez * ez) + child.radius[l];
    const double needed = west > east ? west : east;
    out[i] = needed > out[i] ? needed : out[i];
  }
  for (size_t i = 0; i < count; ++i) {
    const uint8_t west = child.error[2 * i], east = child.error[2 * i + 1], larger = west > east ? west : east;
    out_error[i] = larger > out_error[i] ? larger : out_error[i];
  }
}

// Finest sides have no children: their spheres hold the four lattice points around them and their own, which are all
// their support's samples.
void SphereRows::corners(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors) {
  corners(positions_, row, radii_m, child_errors);
  for (const RowPositions& samples : extremes_) corners(samples, row, radii_m, child_errors);
}

void SphereRows::corners(const RowPositions& samples, const NodeRow& row, std::span<double> radii_m,
                         std::span<uint8_t> child_errors) {
  const bool along_x = row.first_x == 1;
  Row& beside = kept_[0];
  load(samples, beside, along_x ? NodeRow{row.y, 0, 2, row.count + 1, 1} : NodeRow{row.y, 1, 2, row.count - 1, 1},
       Content::kSamples);
  include(beside, along_x ? 0 : -1, radii_m, child_errors);
  include(beside, along_x ? 1 : 0, radii_m, child_errors);
  for (int64_t y : {int64_t{row.y} - 1, int64_t{row.y}, int64_t{row.y} + 1}) {
    if (y < 0 || y > grid_.maxY()) continue;
    NodeRow across = row;
    across.y = static_cast<uint32_t>(y);
    load(samples, beside, across, Content::kSamples);
    include(beside, 0, radii_m, child_errors);
  }
}

void SphereRows::compute(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors) {
  std::fill(radii_m.begin(), radii_m.end(), 0.0);
  std::fill(child_errors.begin(), child_errors.end(), uint8_t{0});
  load(positions_, own_, row, Content::kMiddles);
  if (level_.level == grid_.maxLevel()) return corners(row, radii_m, child_errors);
  if (!level_.sides) {  // the sides of the square around a centre
    const Row& beside = childRow(row.y);
    include(beside, 0, radii_m, child_errors);
    include(beside, 1, radii_m, child_errors);
    include(childRow(row.y - level_.s), 0, radii_m, child_errors);
    include(childRow(row.y + level_.s), 0, radii_m, child_errors);
    return;
  }
  const uint32_t half = level_.s / 2;
  const int first = row.first_x == 0 ? -1 : 0;  // the centre before a side along y
  if (row.y >= half) includePairs(childRow(row.y - half), first, radii_m, child_errors);
  if (row.y + half <= grid_.maxY()) includePairs(childRow(row.y + half), first, radii_m, child_errors);
}

}  // namespace foreland::terrain
