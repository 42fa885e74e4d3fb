#include "terrain/bounds/spheres.h"

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

namespace {

constexpr double kNowhere = -1e300;  // the radius of what is not there

}  // namespace

RowPositions::RowPositions(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights)
    : grid_(&grid), heights_(heights), frame_(frame), polar_((1 - frame.flattening) * (1 - frame.flattening)) {
  if (frame.kind != proto::FrameKind::kGeographic) return;
  const proto::FrameTransform transform(frame);
  for (uint32_t y = 0; y <= grid.maxY(); ++y)
    rows_.push_back(transform.row(frame.latitude0_rad + y * frame.latitude_step_rad));
  for (uint32_t x = 0; x <= grid.maxX(); ++x) {
    const auto column = transform.column(frame.longitude0_rad + x * frame.longitude_step_rad);
    sin_lon_.push_back(column.sin);
    cos_lon_.push_back(column.cos);
  }
}

int32_t RowPositions::middleSteps(proto::NodeId n) const {
  const auto [a, b] = grid_->endpoints(n);
  return proto::middleOf(steps(a.x(), a.y()), steps(b.x(), b.y()));
}

void RowPositions::fill(const NodeRow& row, const Out& out) const {
  const int32_t* steps = heights_.row(std::min(row.y, heights_.height - 1));
  const uint32_t with_data =
      row.first_x >= heights_.width ? 0 : std::min(row.count, (heights_.width - 1 - row.first_x) / row.step_x + 1);
  for (uint32_t i = 0; i < with_data; ++i)
    out.z[i] = steps[row.first_x + static_cast<size_t>(i) * row.step_x] * frame_.height_quantum_m;
  std::fill(out.z + with_data, out.z + row.count, steps[heights_.width - 1] * frame_.height_quantum_m);
  place(row, out);
}

void RowPositions::fillMiddles(const NodeRow& row, const Out& out) const {
  for (uint32_t i = 0; i < row.count; ++i) out.z[i] = middleSteps(row.node(i)) * frame_.height_quantum_m;
  place(row, out);
}

void RowPositions::place(const NodeRow& row, const Out& out) const {
  if (frame_.kind == proto::FrameKind::kPlanar) {
    const double dy = row.y - frame_.anchor.y, x0 = row.first_x - frame_.anchor.x, step = row.step_x;
    for (uint32_t i = 0; i < row.count; ++i) {
      const double dx = x0 + step * i;
      out.x[i] = dx * frame_.axis_x_m.x + dy * frame_.axis_y_m.x;
      out.y[i] = dx * frame_.axis_x_m.y + dy * frame_.axis_y_m.y;
    }
    return;
  }
  const auto& lat = rows_[row.y];
  for (uint32_t i = 0; i < row.count; ++i) {
    const size_t column = row.first_x + static_cast<size_t>(i) * row.step_x;
    const double height_m = out.z[i], ring = (lat.normal + height_m) * lat.cos;
    out.x[i] = ring * cos_lon_[column];
    out.y[i] = ring * sin_lon_[column];
    out.z[i] = (lat.normal * polar_ + height_m) * lat.sin;
  }
}

SphereRows::SphereRows(const proto::GridTopology& grid, const proto::SphereLevels& levels,
                       const RowPositions& positions, std::span<const NodeRecord> nodes, int level)
    : grid_(grid), levels_(levels), positions_(positions), nodes_(nodes), level_(grid, level) {}

void SphereRows::load(Row& row, const NodeRow& where, What what) {
  const size_t size = where.count + 2;
  for (auto* column : {&row.x, &row.y_m, &row.z, &row.radius}) column->resize(size);
  row.error.assign(size, 0);
  row.y = where.y;
  row.used = true;
  const RowPositions::Out out{row.x.data() + 1, row.y_m.data() + 1, row.z.data() + 1};
  if (what == What::kSamples)
    positions_.fill(where, out);
  else
    positions_.fillMiddles(where, out);
  for (auto* column : {&row.x, &row.y_m, &row.z}) column->front() = column->back() = 0;
  std::fill(row.radius.begin(), row.radius.end(), 0.0);
  row.radius.front() = row.radius.back() = kNowhere;
  if (what != What::kSpheres) return;
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
  load(row, NodeLevel(grid_, level_.level + 1).row(y), What::kSpheres);
  return row;
}

void SphereRows::include(const Row& children, int offset, std::span<double> radii_m,
                         std::span<uint8_t> child_errors) const {
  const double *x = own_.x.data() + 1, *y = own_.y_m.data() + 1, *z = own_.z.data() + 1;
  const double *cx = children.x.data() + 1 + offset, *cy = children.y_m.data() + 1 + offset,
               *cz = children.z.data() + 1 + offset;
  const double* radius = children.radius.data() + 1 + offset;
  const uint8_t* error = children.error.data() + 1 + offset;
  double* out = radii_m.data();
  uint8_t* out_error = child_errors.data();
  const size_t count = radii_m.size();
  for (size_t i = 0; i < count; ++i) {
    const double dx = cx[i] - x[i], dy = cy[i] - y[i], dz = cz[i] - z[i],
                 needed = std::sqrt(dx * dx + dy * dy + dz * dz) + radius[i];
    out[i] = needed > out[i] ? needed : out[i];
  }
  for (size_t i = 0; i < count; ++i) out_error[i] = error[i] > out_error[i] ? error[i] : out_error[i];
}

// As include, for children twice as dense: parent i takes children 2i + offset and 2i + offset + 1.
void SphereRows::includePairs(const Row& children, int offset, std::span<double> radii_m,
                              std::span<uint8_t> child_errors) const {
  const double *x = own_.x.data() + 1, *y = own_.y_m.data() + 1, *z = own_.z.data() + 1;
  const double *cx = children.x.data() + 1 + offset, *cy = children.y_m.data() + 1 + offset,
               *cz = children.z.data() + 1 + offset;
  const double* radius = children.radius.data() + 1 + offset;
  const uint8_t* error = children.error.data() + 1 + offset;
  double* out = radii_m.data();
  uint8_t* out_error = child_errors.data();
  const size_t count = radii_m.size();
  for (size_t i = 0; i < count; ++i) {
    const size_t k = 2 * i, l = k + 1;
    const double dx = cx[k] - x[i], dy = cy[k] - y[i], dz = cz[k] - z[i],
                 west = std::sqrt(dx * dx + dy * dy + dz * dz) + radius[k];
    const double ex = cx[l] - x[i], ey = cy[l] - y[i], ez = cz[l] - z[i],
                 east = std::sqrt(ex * ex + ey * ey + ez * ez) + radius[l];
    const double needed = west > east ? west : east;
    out[i] = needed > out[i] ? needed : out[i];
  }
  for (size_t i = 0; i < count; ++i) {
    const uint8_t larger = error[2 * i] > error[2 * i + 1] ? error[2 * i] : error[2 * i + 1];
    out_error[i] = larger > out_error[i] ? larger : out_error[i];
  }
}

// Finest sides have no children: their spheres hold the four lattice points around them and their own, which are all
// their support's samples.
void SphereRows::corners(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors) {
  const bool along_x = row.first_x == 1;
  Row& beside = kept_[0];
  load(beside, along_x ? NodeRow{row.y, 0, 2, row.count + 1, 1} : NodeRow{row.y, 1, 2, row.count - 1, 1},
       What::kSamples);
  include(beside, along_x ? 0 : -1, radii_m, child_errors);
  include(beside, along_x ? 1 : 0, radii_m, child_errors);
  for (int64_t y : {int64_t{row.y} - 1, int64_t{row.y}, int64_t{row.y} + 1}) {
    if (y < 0 || y > grid_.maxY()) continue;
    NodeRow across = row;
    across.y = static_cast<uint32_t>(y);
    load(beside, across, What::kSamples);
    include(beside, 0, radii_m, child_errors);
  }
}

void SphereRows::compute(const NodeRow& row, std::span<double> radii_m, std::span<uint8_t> child_errors) {
  std::fill(radii_m.begin(), radii_m.end(), 0.0);
  std::fill(child_errors.begin(), child_errors.end(), uint8_t{0});
  load(own_, row, What::kMiddles);
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
