#include "lab/martini/plain_martini.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"

namespace foreland::lab {

MartiniTables::MartiniTables(uint32_t size) : grid_size(size) {
  const uint32_t tile_size = size - 1;
  CHECK_EQ(tile_size & (tile_size - 1), 0u);
  triangles = tile_size * tile_size * 2 - 2;
  parent_triangles = triangles - tile_size * tile_size;
  coords.resize(size_t{4} * triangles);
  for (uint32_t i = 0; i < triangles; ++i) {
    uint32_t id = i + 2, ax = 0, ay = 0, bx = 0, by = 0, cx = 0, cy = 0;
    if (id & 1)
      bx = by = cx = tile_size;  // bottom left
    else
      ax = ay = cy = tile_size;  // top right
    while ((id >>= 1) > 1) {
      const uint32_t mx = (ax + bx) >> 1, my = (ay + by) >> 1;
      if (id & 1) {
        bx = ax, by = ay;
        ax = cx, ay = cy;
      } else {
        ax = bx, ay = by;
        bx = cx, by = cy;
      }
      cx = mx, cy = my;
    }
    const uint32_t all[4] = {ax, ay, bx, by};
    for (size_t k = 0; k < 4; ++k) coords[4 * size_t{i} + k] = static_cast<uint16_t>(all[k]);
  }
}

PlainMartini::PlainMartini(const MartiniTables& tables, std::vector<float> heights)
    : size_(tables.grid_size), heights_(std::move(heights)), errors_(heights_.size()), indices_(heights_.size()) {
  CHECK_EQ(heights_.size(), size_t{size_} * size_);
  const auto at = [this](int64_t x, int64_t y) { return static_cast<size_t>(y * size_ + x); };
  for (uint32_t i = tables.triangles; i-- > 0;) {
    const uint16_t* c = tables.coords.data() + 4 * size_t{i};
    const int64_t ax = c[0], ay = c[1], bx = c[2], by = c[3], mx = (ax + bx) >> 1, my = (ay + by) >> 1;
    const int64_t cx = mx + my - ay, cy = my + ax - mx;
    const double middle = (static_cast<double>(heights_[at(ax, ay)]) + static_cast<double>(heights_[at(bx, by)])) / 2;
    float& error = errors_[at(mx, my)];
    error = std::max(error, static_cast<float>(std::fabs(middle - static_cast<double>(heights_[at(mx, my)]))));
    if (i >= tables.parent_triangles) continue;
    error = std::max({error, errors_[at((ax + cx) >> 1, (ay + cy) >> 1)], errors_[at((bx + cx) >> 1, (by + cy) >> 1)]});
  }
}

double PlainMartini::largestError_m() const { return static_cast<double>(*std::ranges::max_element(errors_)); }

bool PlainMartini::isSplit(const Corners& t) const {
  const uint32_t mx = (t.ax + t.bx) >> 1, my = (t.ay + t.by) >> 1;
  const auto distance = [](uint32_t a, uint32_t b) { return a > b ? a - b : b - a; };
  return distance(t.ax, t.cx) + distance(t.ay, t.cy) > 1 &&
         static_cast<double>(errors_[size_t{my} * size_ + mx]) > max_error_m_;
}

void PlainMartini::count(const Corners& t) {
  if (isSplit(t)) {
    const uint32_t mx = (t.ax + t.bx) >> 1, my = (t.ay + t.by) >> 1;
    count({t.cx, t.cy, t.ax, t.ay, mx, my});
    count({t.bx, t.by, t.cx, t.cy, mx, my});
    return;
  }
  for (const size_t sample : {size_t{t.ay} * size_ + t.ax, size_t{t.by} * size_ + t.bx, size_t{t.cy} * size_ + t.cx})
    if (indices_[sample] == 0) indices_[sample] = ++vertex_count_;
  ++triangle_count_;
}

void PlainMartini::write(const Corners& t) {
  if (isSplit(t)) {
    const uint32_t mx = (t.ax + t.bx) >> 1, my = (t.ay + t.by) >> 1;
    write({t.cx, t.cy, t.ax, t.ay, mx, my});
    write({t.bx, t.by, t.cx, t.cy, mx, my});
    return;
  }
  const auto put = [this](uint32_t x, uint32_t y) {
    const uint32_t vertex = indices_[size_t{y} * size_ + x] - 1;
    mesh_.vertices[2 * size_t{vertex}] = static_cast<uint16_t>(x);
    mesh_.vertices[2 * size_t{vertex} + 1] = static_cast<uint16_t>(y);
    mesh_.triangles[written_++] = vertex;
  };
  put(t.ax, t.ay);
  put(t.bx, t.by);
  put(t.cx, t.cy);
}

void PlainMartini::clearIndices() { std::ranges::fill(indices_, 0u); }

const PlainMartini::Mesh& PlainMartini::mesh(double max_error_m) {
  const uint32_t max = size_ - 1;
  const Corners halves[] = {{0, 0, max, max, max, 0}, {max, max, 0, 0, 0, max}};
  max_error_m_ = max_error_m;
  vertex_count_ = 0;
  triangle_count_ = written_ = 0;
  clearIndices();
  for (const Corners& half : halves) count(half);
  mesh_.vertices.resize(size_t{2} * vertex_count_);
  mesh_.triangles.resize(3 * triangle_count_);
  for (const Corners& half : halves) write(half);
  return mesh_;
}

double PlainMartini::trueError_m() const {
  double largest = 0;
  for (size_t i = 0; i < mesh_.triangles.size(); i += 3) {
    int64_t x[3], y[3];
    double h[3];
    for (size_t k = 0; k < 3; ++k) {
      x[k] = mesh_.vertices[2 * size_t{mesh_.triangles[i + k]}];
      y[k] = mesh_.vertices[2 * size_t{mesh_.triangles[i + k]} + 1];
      h[k] = static_cast<double>(heights_[static_cast<size_t>(y[k] * size_ + x[k])]);
    }
    const double area = static_cast<double>((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]));
    for (int64_t py = std::min({y[0], y[1], y[2]}); py <= std::max({y[0], y[1], y[2]}); ++py)
      for (int64_t px = std::min({x[0], x[1], x[2]}); px <= std::max({x[0], x[1], x[2]}); ++px) {
        const double b = static_cast<double>((px - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (py - y[0])) / area;
        const double c = static_cast<double>((x[1] - x[0]) * (py - y[0]) - (px - x[0]) * (y[1] - y[0])) / area;
        if (b < 0 || c < 0 || b + c > 1) continue;
        const double height = static_cast<double>(heights_[static_cast<size_t>(py * size_ + px)]);
        largest = std::max(largest, std::fabs(h[0] + b * (h[1] - h[0]) + c * (h[2] - h[0]) - height));
      }
  }
  return largest;
}

}  // namespace foreland::lab
