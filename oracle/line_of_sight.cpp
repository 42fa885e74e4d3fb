#include "oracle/line_of_sight.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>

namespace foreland::oracle {

namespace {

constexpr double kPiece_m = 500;

double mix(double a, double b, double share) { return a + share * (b - a); }

// Shares of a segment's way that are left of it.
struct Interval {
  double begin = 0, end = 1;

  // To where the coordinate that runs from `a` to `b` is in [low, high].
  void clip(double a, double b, double low, double high) {
    if (a == b) {
      if (a < low || a > high) end = -1;
      return;
    }
    const double first = (low - a) / (b - a), second = (high - a) / (b - a);
    begin = std::max(begin, std::min(first, second));
    end = std::min(end, std::max(first, second));
  }
};

}  // namespace

// The edges of the finest triangles lie on four families of parallel lines: columns, rows, and the diagonals on which
// x - y or x + y is even. `of` times a position is the number of the line through it; the k-th sample of a line is
// number * first + k * step.
struct LineOfSight::Family {
  glm::dvec2 of;
  glm::i64vec2 first, step;
};

LineOfSight::LineOfSight(const Truth& truth)
    : shape_(truth.shape),
      transform_(truth.frame),
      quantum_m_(truth.frame.height_quantum_m),
      heights_(size_t{truth.shape.samples_x} * truth.shape.samples_y) {
  for (uint32_t y = 0; y < shape_.samples_y; ++y)
    truth.heights(0, y, std::span(heights_).subspan(size_t{y} * shape_.samples_x, shape_.samples_x));
  highest_m_ = quantum_m_ * *std::max_element(heights_.begin(), heights_.end());
}

bool LineOfSight::isClear(const glm::dvec3& target, const glm::dvec3& eye) const {
  const bool is_planar = transform_.frame().kind == proto::FrameKind::kPlanar;
  const int pieces = is_planar ? 1 : 1 + static_cast<int>(glm::distance(target, eye) / kPiece_m);
  proto::LatticePosition from = transform_.toLattice(target);
  for (int i = 1; i <= pieces; ++i) {
    const proto::LatticePosition to = transform_.toLattice(glm::mix(target, eye, static_cast<double>(i) / pieces));
    if (!isClear(from, to)) return false;
    from = to;
  }
  return true;
}

bool LineOfSight::isClear(const proto::LatticePosition& from, const proto::LatticePosition& to) const {
  static constexpr Family kFamilies[4] = {{{1, 0}, {1, 0}, {0, 1}},
                                          {{0, 1}, {0, 1}, {1, 0}},
                                          {{0.5, -0.5}, {0, -2}, {1, 1}},
                                          {{0.5, 0.5}, {0, 2}, {1, -1}}};
  Interval inside;
  inside.clip(from.x, to.x, 0, shape_.samples_x - 1.0);
  inside.clip(from.y, to.y, 0, shape_.samples_y - 1.0);
  inside.clip(from.height_m, to.height_m, std::numeric_limits<double>::lowest(), highest_m_);
  if (inside.begin > inside.end) return true;
  const Segment whole{from, to}, segment{whole.at(inside.begin), whole.at(inside.end)};
  return std::all_of(std::begin(kFamilies), std::end(kFamilies),
                     [&](const Family& family) { return isAbove(segment, family); });
}

bool LineOfSight::isAbove(const Segment& segment, const Family& family) const {
  const double a = glm::dot(family.of, glm::dvec2(segment.from.x, segment.from.y)),
               b = glm::dot(family.of, glm::dvec2(segment.to.x, segment.to.y));
  if (a == b) return true;  // it runs beside the lines; if on one, it meets lines of other families at each sample
  const int64_t sign = b > a ? 1 : -1, last = static_cast<int64_t>(sign > 0 ? std::floor(b) : std::ceil(b));
  for (auto line = static_cast<int64_t>(sign > 0 ? std::ceil(a) : std::floor(a)); sign * line <= sign * last;
       line += sign) {
    const proto::LatticePosition p = segment.at((static_cast<double>(line) - a) / (b - a));
    if (groundOn(family, line, p) > p.height_m + kTolerance_m) return false;
  }
  return true;
}

// Below everything where rounding takes a diagonal's sample beyond the data: there the line meets a row or column, too.
double LineOfSight::groundOn(const Family& family, int64_t line, const proto::LatticePosition& at) const {
  const double along = family.step.x == 1 ? at.x : at.y,
               most = (family.step.x == 1 ? shape_.samples_x : shape_.samples_y) - 2.0,
               before = std::clamp(std::floor(along), 0.0, most);
  const glm::i64vec2 p = line * family.first + static_cast<int64_t>(before) * family.step, q = p + family.step;
  if (!isInside(p) || !isInside(q)) return std::numeric_limits<double>::lowest();
  return mix(heightOf(p), heightOf(q), along - before);
}

glm::dvec3 LineOfSight::pointAt(const glm::dvec2& lattice) const {
  const double cell_x = std::clamp(std::floor(lattice.x), 0.0, shape_.samples_x - 2.0),
               cell_y = std::clamp(std::floor(lattice.y), 0.0, shape_.samples_y - 2.0);
  const auto i = static_cast<int64_t>(cell_x), j = static_cast<int64_t>(cell_y);
  const double u = lattice.x - cell_x, v = lattice.y - cell_y;
  const double a = heightOf({i, j}), b = heightOf({i + 1, j}), c = heightOf({i, j + 1}), d = heightOf({i + 1, j + 1});
  double height_m = 0;
  if ((i + j) % 2 == 0)  // the diagonal from a to d
    height_m = u > v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
  else
    height_m = u + v < 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
  return transform_.toScene(proto::LatticePosition{lattice.x, lattice.y, height_m});
}

}  // namespace foreland::oracle
