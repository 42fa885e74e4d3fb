#include "oracle/block_raster.h"

#include <algorithm>
#include <cmath>

namespace foreland::oracle {

namespace {

// Places are whole numbers, exact in floats; this only absorbs the rounding of edge intersections.
constexpr double kSlack = 1e-6;

struct BlockRange {
  uint32_t x0, x1, y0, y1;  // inclusive
};

BlockRange blocksOf(const client::KeyframeMesh& mesh, size_t triangle, uint32_t blocks_x, uint32_t blocks_y) {
  const glm::vec2 a = mesh.parameters[mesh.indices[3 * triangle]], b = mesh.parameters[mesh.indices[3 * triangle + 1]],
                  c = mesh.parameters[mesh.indices[3 * triangle + 2]];
  const auto block = [](float v, uint32_t count) {
    return std::min(static_cast<uint32_t>(std::max(v, 0.0f)) >> kBlockLog2, count - 1);
  };
  return {block(std::min({a.x, b.x, c.x}), blocks_x), block(std::max({a.x, b.x, c.x}), blocks_x),
          block(std::min({a.y, b.y, c.y}), blocks_y), block(std::max({a.y, b.y, c.y}), blocks_y)};
}

struct Corner {
  double x, y;
  glm::dvec3 position;
};

Corner corner(const client::KeyframeMesh& mesh, uint32_t vertex, double weight, double share) {
  return {mesh.parameters[vertex].x, mesh.parameters[vertex].y,
          share * (mesh.origin + glm::dvec3(mesh.at(vertex, weight)))};
}

// Where the horizontal line at y enters and leaves the triangle.
std::pair<double, double> spanAt(const std::array<Corner, 3>& c, double y) {
  double low = 1e300, high = -1e300;
  for (int i = 0; i < 3; ++i) {
    const Corner &p = c[i], &q = c[(i + 1) % 3];
    if ((p.y < y - kSlack && q.y < y - kSlack) || (p.y > y + kSlack && q.y > y + kSlack)) continue;
    const double dy = q.y - p.y;
    if (std::fabs(dy) < kSlack) {
      low = std::min({low, p.x, q.x});
      high = std::max({high, p.x, q.x});
      continue;
    }
    const double x = p.x + (q.x - p.x) * std::clamp((y - p.y) / dy, 0.0, 1.0);
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return {low, high};
}

void rasteriseTriangle(const std::array<Corner, 3>& c, uint32_t block_x, uint32_t block_y, Tile& tile,
                       std::array<uint32_t, kBlock>& covered) {
  const double ux = c[1].x - c[0].x, uy = c[1].y - c[0].y, vx = c[2].x - c[0].x, vy = c[2].y - c[0].y;
  const double twice_area = ux * vy - uy * vx;
  if (std::fabs(twice_area) < kSlack) return;  // covers nothing; the crack checker reports it
  const glm::dvec3 du = c[1].position - c[0].position, dv = c[2].position - c[0].position;
  const glm::dvec3 step_x = (vy * du - uy * dv) / twice_area, step_y = (ux * dv - vx * du) / twice_area;
  const double left = block_x * kBlock, bottom = block_y * kBlock;
  const double y_low = std::max(bottom, std::ceil(std::min({c[0].y, c[1].y, c[2].y}) - kSlack));
  const double y_high = std::min(bottom + kBlock - 1, std::floor(std::max({c[0].y, c[1].y, c[2].y}) + kSlack));
  for (double y = y_low; y <= y_high; y += 1) {
    const auto [low, high] = spanAt(c, y);
    const double x_low = std::max(left, std::ceil(low - kSlack)),
                 x_high = std::min(left + kBlock - 1, std::floor(high + kSlack));
    if (x_low > x_high) continue;
    const uint32_t row = static_cast<uint32_t>(y - bottom);
    const uint32_t first = static_cast<uint32_t>(x_low - left), last = static_cast<uint32_t>(x_high - left);
    const glm::dvec3 base = c[0].position + (left - c[0].x) * step_x + (y - c[0].y) * step_y;
    for (uint32_t x = first; x <= last; ++x) {
      if (covered[row] >> x & 1) continue;
      const size_t at = row * kBlock + x;
      for (int k = 0; k < 3; ++k) tile.position[k][at] += base[k] + x * step_x[k];
    }
    covered[row] |= (last == 31 ? ~0u : (1u << (last + 1)) - 1) & (~0u << first);
  }
}

}  // namespace

void TriangleBins::build(const client::KeyframeMesh& mesh, std::span<const int32_t> rank, uint32_t blocks_x,
                         uint32_t blocks_y, size_t chosen) {
  const auto visit = [&](auto&& use) {
    for (size_t t = 0; t < mesh.triangleCount(); ++t) {
      const BlockRange r = blocksOf(mesh, t, blocks_x, blocks_y);
      for (uint32_t y = r.y0; y <= r.y1; ++y)
        for (uint32_t x = r.x0; x <= r.x1; ++x)
          if (const int32_t k = rank[static_cast<size_t>(y) * blocks_x + x]; k >= 0)
            use(static_cast<uint32_t>(t), static_cast<size_t>(k));
    }
  };
  first_.assign(chosen + 2, 0);
  visit([&](uint32_t, size_t k) { ++first_[k + 2]; });
  for (size_t k = 2; k < first_.size(); ++k) first_[k] += first_[k - 1];
  triangles_.resize(first_.back());
  visit([&](uint32_t t, size_t k) { triangles_[first_[k + 1]++] = t; });
}

void rasterise(const client::KeyframeMesh& mesh, double weight, double share, std::span<const uint32_t> triangles,
               uint32_t block_x, uint32_t block_y, Tile& tile, std::array<uint32_t, kBlock>& covered) {
  covered.fill(0);
  for (const uint32_t t : triangles)
    rasteriseTriangle(
        {corner(mesh, mesh.indices[3 * t], weight, share), corner(mesh, mesh.indices[3 * t + 1], weight, share),
         corner(mesh, mesh.indices[3 * t + 2], weight, share)},
        block_x, block_y, tile, covered);
}

}  // namespace foreland::oracle
