#include "oracle/block_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/vec4.hpp>
#include <utility>

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

using Corner = BlockRaster::Corner;

// An edge as horizontal lines meet it; one that is horizontal itself at its first corner.
class Side {
 public:
  Side(const Corner& p, const Corner& q)
      : x_(p.x),
        y_(p.y),
        slope_(std::fabs(q.y - p.y) < kSlack ? 0 : (q.x - p.x) / (q.y - p.y)),
        low_x_(std::min(p.x, q.x)),
        high_x_(std::max(p.x, q.x)) {}

  // Where the line at height y, one of the edge's, meets it.
  double at(double y) const { return std::min(std::max(x_ + (y - y_) * slope_, low_x_), high_x_); }

 private:
  double x_, y_, slope_, low_x_, high_x_;
};

// Where horizontal lines enter and leave a triangle: by the edge from its lowest to its highest corner, and by one of
// the other two, below or above the corner between.
class Outline {
 public:
  explicit Outline(const std::array<Corner, 3>& c) : Outline(sorted(c)) {}

  double lowest() const { return low_y_; }
  double highest() const { return high_y_; }
  std::pair<double, double> spanAt(double y) const {
    const double a = whole_.at(y), b = (y < middle_y_ ? lower_ : upper_).at(y);
    return {std::min(a, b), std::max(a, b)};
  }

 private:
  using Corners = std::array<const Corner*, 3>;  // ascending

  static Corners sorted(const std::array<Corner, 3>& c) {
    Corners all{&c[0], &c[1], &c[2]};
    if (all[1]->y < all[0]->y) std::swap(all[0], all[1]);
    if (all[2]->y < all[1]->y) std::swap(all[1], all[2]);
    if (all[1]->y < all[0]->y) std::swap(all[0], all[1]);
    return all;
  }
  explicit Outline(const Corners& c)
      : low_y_(c[0]->y),
        middle_y_(c[1]->y),
        high_y_(c[2]->y),
        whole_(*c[0], *c[2]),
        lower_(*c[1], *c[0]),
        upper_(*c[1], *c[2]) {}

  double low_y_, middle_y_, high_y_;
  Side whole_, lower_, upper_;
};

void rasteriseTriangle(const std::array<Corner, 3>& c, uint32_t block_x, uint32_t block_y, Tile& tile,
                       std::array<uint32_t, kBlock>& covered) {
  const double ux = c[1].x - c[0].x, uy = c[1].y - c[0].y, vx = c[2].x - c[0].x, vy = c[2].y - c[0].y;
  const double twice_area = ux * vy - uy * vx;
  if (std::fabs(twice_area) < kSlack * kSlack) return;  // covers nothing; the crack checker reports it
  const double scale = 1 / twice_area;
  const glm::dvec4 du(c[1].position - c[0].position, 0), dv(c[2].position - c[0].position, 0);
  const glm::dvec4 step_x = (vy * du - uy * dv) * scale, step_y = (ux * dv - vx * du) * scale;
  const Outline outline(c);
  const double left = block_x * kBlock, bottom = block_y * kBlock;
  const double y_low = std::max(bottom, std::ceil(outline.lowest() - kSlack));
  const double y_high = std::min(bottom + kBlock - 1, std::floor(outline.highest() + kSlack));
  for (double y = y_low; y <= y_high; y += 1) {
    const auto [low, high] = outline.spanAt(y);
    const double x_low = std::max(left, std::ceil(low - kSlack)),
                 x_high = std::min(left + kBlock - 1, std::floor(high + kSlack));
    if (x_low > x_high) continue;
    const uint32_t row = static_cast<uint32_t>(y - bottom);
    const uint32_t first = static_cast<uint32_t>(x_low - left), last = static_cast<uint32_t>(x_high - left);
    const uint32_t span = (last == 31 ? ~0u : (1u << (last + 1)) - 1) & (~0u << first);
    const glm::dvec4 base = glm::dvec4(c[0].position, 0) + (left - c[0].x) * step_x + (y - c[0].y) * step_y;
    for (uint32_t open = span & ~covered[row]; open != 0; open &= open - 1) {
      const auto x = static_cast<uint32_t>(std::countr_zero(open));
      std::array<double, 4>& position = tile.position[row * kBlock + x].at;
      for (int k = 0; k < 4; ++k) position[k] += base[k] + x * step_x[k];
    }
    covered[row] |= span;
  }
}

}  // namespace

void BlockRaster::build(const client::KeyframeMesh& mesh, double weight, double share, const ChosenBlocks& blocks) {
  corners_.resize(mesh.parameters.size());
  for (size_t v = 0; v < corners_.size(); ++v)
    corners_[v] = {mesh.parameters[v].x, mesh.parameters[v].y, share * (mesh.origin + glm::dvec3(mesh.at(v, weight)))};

  meetings_.clear();
  first_.assign(blocks.chosen + 2, 0);
  for (size_t t = 0; t < mesh.triangleCount(); ++t) {
    const BlockRange r = blocksOf(mesh, t, blocks.x, blocks.y);
    for (uint32_t y = r.y0; y <= r.y1; ++y)
      for (uint32_t x = r.x0; x <= r.x1; ++x)
        if (const int32_t k = blocks.rank[static_cast<size_t>(y) * blocks.x + x]; k >= 0) {
          meetings_.push_back({static_cast<uint32_t>(t), static_cast<uint32_t>(k)});
          ++first_[static_cast<size_t>(k) + 2];
        }
  }
  for (size_t k = 2; k < first_.size(); ++k) first_[k] += first_[k - 1];
  triangles_.resize(meetings_.size());
  for (const Meeting& m : meetings_) {
    const uint32_t* corner = &mesh.indices[size_t{3} * m.triangle];
    triangles_[first_[m.block + 1]++] = {corner[0], corner[1], corner[2]};
  }
}

void BlockRaster::add(size_t chosen_block, uint32_t block_x, uint32_t block_y, Tile& tile,
                      std::array<uint32_t, kBlock>& covered) const {
  covered.fill(0);
  for (uint32_t i = first_[chosen_block]; i < first_[chosen_block + 1]; ++i) {
    const auto& [a, b, c] = triangles_[i];
    rasteriseTriangle({corners_[a], corners_[b], corners_[c]}, block_x, block_y, tile, covered);
  }
}

}  // namespace foreland::oracle
