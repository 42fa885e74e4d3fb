#include "server/sight/ground_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace foreland::server {

using proto::NodeId;

namespace {

// Whether the line passes a cell with these corners on one side.
bool passesBy(const SightLine& line, const SightLine::Aside& a, const SightLine::Aside& b, const SightLine::Aside& c,
              const SightLine::Aside& d) {
  const auto [left, right] = std::minmax({a.left_m, b.left_m, c.left_m, d.left_m});
  if (left > SightLine::kTouch_m || right < -SightLine::kTouch_m) return true;
  const auto [below, above] = std::minmax({a.above_m, b.above_m, c.above_m, d.above_m});
  const auto [first, last] = std::minmax({a.share, b.share, c.share, d.share});
  const double touch_m = line.touchMetres(first, last);
  return below > touch_m || above < -touch_m;
}

}  // namespace

double offsetAt(const terrain::EpochTable& epochs, const proto::GridTopology& grid, NodeId v,
                const proto::EpochWeights& time) {
  if (epochs.epochs().empty()) return 0;
  double offset = 0;
  for (uint32_t k = 0; k < time.count; ++k)
    if (const uint32_t epoch = time.epoch[k]; epochs.epochs().mayMove(epoch, v))
      offset += time.weight[k] * epochs.offset(epoch, grid, v);
  return offset;
}

GroundSurface::GroundSurface(const Hierarchy& hierarchy)
    : frame_(hierarchy.frame()),
      grid_(hierarchy.grid()),
      epochs_(hierarchy.epochs()),
      columns_(grid_.shape().samples_x),
      rows_(grid_.shape().samples_y),
      blocks_x_((columns_ - 1 + kBlock - 1) / kBlock),
      blocks_y_((rows_ - 1 + kBlock - 1) / kBlock) {
  heights_.reserve(size_t{columns_} * rows_);
  for (uint32_t y = 0; y < rows_; ++y)
    for (uint32_t x = 0; x < columns_; ++x) heights_.push_back(hierarchy.scene().height(NodeId::at(x, y)));
  if (!epochs_.epochs().empty()) moving_.emplace(hierarchy);
}

double GroundSurface::height(uint32_t x, uint32_t y, const proto::EpochWeights& time) const {
  return heights_[size_t{y} * columns_ + x] + offsetAt(epochs_, grid_, NodeId::at(x, y), time);
}

Box GroundSurface::boundsOf(uint32_t block) const {
  Box box;
  const uint32_t x0 = block % blocks_x_ * kBlock, y0 = block / blocks_x_ * kBlock;
  for (uint32_t y = y0; y <= std::min(y0 + kBlock, rows_ - 1); ++y)
    for (uint32_t x = x0; x <= std::min(x0 + kBlock, columns_ - 1); ++x) {
      const NodeId v = NodeId::at(x, y);
      if (!moving_) {
        box.add(frame_.position(v, heights_[size_t{y} * columns_ + x]));
        continue;
      }
      box.add(frame_.position(v, moving_->lowest(v)));
      box.add(frame_.position(v, moving_->highest(v)));
    }
  return box;
}

std::optional<glm::dvec3> GroundSurface::pointAt(double x, double y, const proto::EpochWeights& time) const {
  if (!(x >= 0 && y >= 0 && x <= columns_ - 1 && y <= rows_ - 1)) return std::nullopt;
  const auto cx = std::min(static_cast<uint32_t>(x), columns_ - 2), cy = std::min(static_cast<uint32_t>(y), rows_ - 2);
  const double u = x - cx, v = y - cy;
  const glm::dvec3 sw = sample(cx, cy, time), se = sample(cx + 1, cy, time), nw = sample(cx, cy + 1, time),
                   ne = sample(cx + 1, cy + 1, time);
  if (isRising(cx, cy)) return u > v ? sw + u * (se - sw) + v * (ne - se) : sw + v * (nw - sw) + u * (ne - nw);
  return u + v < 1 ? sw + u * (se - sw) + v * (nw - sw) : ne + (1 - u) * (nw - ne) + (1 - v) * (se - ne);
}

std::optional<double> GroundSurface::meet(const SightLine& line, uint32_t block, double before,
                                          const proto::EpochWeights& time) const {
  const uint32_t x0 = block % blocks_x_ * kBlock, y0 = block / blocks_x_ * kBlock;
  const uint32_t nx = std::min(kBlock, columns_ - 1 - x0), ny = std::min(kBlock, rows_ - 1 - y0);
  std::array<glm::dvec3, size_t{kBlock + 1} * (kBlock + 1)> points;
  std::array<SightLine::Aside, points.size()> asides;
  const auto number = [](uint32_t i, uint32_t j) { return size_t{j} * (kBlock + 1) + i; };
  for (uint32_t j = 0; j <= ny; ++j)
    for (uint32_t i = 0; i <= nx; ++i) {
      points[number(i, j)] = sample(x0 + i, y0 + j, time);
      asides[number(i, j)] = line.aside(points[number(i, j)]);
    }

  std::optional<double> first;
  const auto take = [&](size_t a, size_t b, size_t c) {
    const auto share = line.meet({points[a], points[b], points[c]}, {asides[a], asides[b], asides[c]});
    if (share && *share < before) first = before = *share;
  };
  for (uint32_t j = 0; j < ny; ++j)
    for (uint32_t i = 0; i < nx; ++i) {
      const size_t sw = number(i, j), se = number(i + 1, j), nw = number(i, j + 1), ne = number(i + 1, j + 1);
      if (passesBy(line, asides[sw], asides[se], asides[nw], asides[ne])) continue;
      if (isRising(x0 + i, y0 + j)) {
        take(sw, se, ne);
        take(sw, ne, nw);
      } else {
        take(sw, se, nw);
        take(se, ne, nw);
      }
    }
  return first;
}

}  // namespace foreland::server
