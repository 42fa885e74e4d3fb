#include "terrain/bounds/error.h"

#include <cmath>
#include <cstring>
#include <glm/vec3.hpp>

#include "terrain/bounds/fine_errors.h"
#include "terrain/bounds/four.h"
#include "terrain/bounds/support.h"

namespace foreland::terrain {

namespace {

// The largest value so far: of those seen four at a time, and of those at the ends of rows.
struct Largest {
  Four four{};
  double one = 0;
  double value() const { return std::max(largest(four), one); }
};

// Largest vertical distance between `count` samples and a line that starts at `value` and rises by `slope`.
void scanRow(const int32_t* samples, int32_t count, double value, double slope, Largest& result) {
  int32_t i = 0;
  if (count >= 4) {
    Four line = value + slope * kZeroToThree, worst = result.four;
    const double step = 4 * slope;  // sums of exact dyadics stay exact
    for (; i + 4 <= count; i += 4, line += step) worst = larger(worst, magnitude(loadFour(samples + i) - line));
    result.four = worst;
  }
  for (; i < count; ++i) result.one = std::max(result.one, std::fabs(samples[i] - (value + slope * i)));
}

struct FourColumns {
  Four sin, cos;
};

FourColumns loadFour(const proto::FrameTransform::Column* columns) {
  static_assert(sizeof(*columns) == 2 * sizeof(double));
  Four first, last;
  std::memcpy(&first, columns, sizeof(first));
  std::memcpy(&last, columns + 2, sizeof(last));
  return {__builtin_shufflevector(first, last, 0, 2, 4, 6), __builtin_shufflevector(first, last, 1, 3, 5, 7)};
}

// Whether more of a triangle than its border lies in a window.
bool reachesInto(const SupportTriangle& t, const ErrorWindow& w) {
  const auto [left, right] = std::minmax({t.a.x(), t.b.x(), t.apex.x()});
  const auto [bottom, top] = std::minmax({t.a.y(), t.b.y(), t.apex.y()});
  return left < w.high_x && right > w.low_x && bottom < w.high_y && top > w.low_y;
}

// Calls visit(dy, first, skip, y, x, count) for each lattice row of a triangle: `count` samples from (x, y) on lie in
// the window and in the data, the first of which is `skip` beyond the triangle's own at dx = `first`.
template <class Visit>
void forEachRowIn(const SupportTriangle& triangle, const ErrorWindow& window, const Heights& heights,
                  const Visit& visit) {
  const uint32_t high_x = std::min(window.high_x, heights.width - 1),
                 high_y = std::min(window.high_y, heights.height - 1);
  triangle.forEachRow([&](int32_t dy, int32_t first, int32_t last) {
    const uint32_t y = triangle.node.y() + static_cast<uint32_t>(dy),
                   begin = triangle.node.x() + static_cast<uint32_t>(first),
                   end = triangle.node.x() + static_cast<uint32_t>(last), x = std::max(begin, window.low_x);
    if (y < window.low_y || y > high_y || x > std::min(end, high_x)) return;
    visit(dy, first, static_cast<int32_t>(x - begin), y, x, static_cast<int32_t>(std::min(end, high_x) - x + 1));
  });
}

}  // namespace

PlanarError::PlanarError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
                         const CornerHeights& corners)
    : grid_(grid), heights_(heights), corners_(corners), height_quantum_m_(frame.height_quantum_m) {}

double PlanarError::metres(proto::NodeId n, const ErrorWindow& window) const {
  const auto ends = grid_.endpoints(n);
  const auto heightOf = [&](proto::NodeId v) { return static_cast<double>(corners_.at(v)); };
  Largest worst;
  for (proto::NodeId apex : grid_.apexes(n)) {
    const SupportTriangle triangle(n, ends, apex);
    if (!reachesInto(triangle, window)) continue;
    const Plane<double> plane = triangle.plane(heightOf(triangle.a), heightOf(triangle.b), heightOf(apex));
    forEachRowIn(triangle, window, heights_,
                 [&](int32_t dy, int32_t first, int32_t skip, uint32_t y, uint32_t x, int32_t count) {
                   scanRow(heights_.row(y) + x, count, plane.at(first + skip, dy), plane.per_x, worst);
                 });
  }
  return inMetres(worst.value());
}

// Rounded up, since the product itself may round down.
double PlanarError::inMetres(double quanta) const { return quanta * height_quantum_m_ * (1 + 0x1p-51); }

GeographicError::GeographicError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights,
                                 const CornerHeights& corners, const proto::GeographicTables& tables)
    : grid_(grid),
      heights_(heights),
      corners_(corners),
      height_quantum_m_(frame.height_quantum_m),
      polar_((1 - frame.flattening) * (1 - frame.flattening)),
      tables_(tables) {}

// Earth-centred, axes turned to the origin's meridian: distances are those of the scene frame.
glm::dvec3 GeographicError::corner(proto::NodeId v) const {
  const proto::FrameTransform::Row& row = tables_.rows[v.y()];
  const proto::FrameTransform::Column& column = tables_.columns[v.x()];
  const double height_m = corners_.at(v) * height_quantum_m_, ring = (row.normal + height_m) * row.cos;
  return {ring * column.cos, ring * column.sin, (row.normal * polar_ + height_m) * row.sin};
}

double GeographicError::metres(proto::NodeId n, const ErrorWindow& window) const {
  const auto ends = grid_.endpoints(n);
  const glm::dvec3 at_a = corner(ends[0]), at_b = corner(ends[1]);
  Four worst{};
  for (proto::NodeId apex : grid_.apexes(n)) {
    const SupportTriangle triangle(n, ends, apex);
    if (!reachesInto(triangle, window)) continue;
    const Plane<glm::dvec3> plane = triangle.plane(at_a, at_b, corner(apex));
    forEachRowIn(triangle, window, heights_,
                 [&](int32_t dy, int32_t first, int32_t skip, uint32_t y, uint32_t x, int32_t count) {
                   const proto::FrameTransform::Row& row = tables_.rows[y];
                   const proto::FrameTransform::Column* columns = &tables_.columns[x];
                   const glm::dvec3 start = plane.at(first, dy), slope = plane.per_x;
                   const int32_t* samples = heights_.row(y) + x;
                   const auto square = [&](Four quanta, const FourColumns& lon, Four along) {
                     const Four height_m = quanta * height_quantum_m_, ring = (row.normal + height_m) * row.cos;
                     const Four ox = ring * lon.cos - (start.x + slope.x * along),
                                oy = ring * lon.sin - (start.y + slope.y * along);
                     const Four oz = (row.normal * polar_ + height_m) * row.sin - (start.z + slope.z * along);
                     return ox * ox + oy * oy + oz * oz;
                   };
                   int32_t i = 0;
                   for (; i + 4 <= count; i += 4)
                     worst =
                         larger(worst, square(loadFour(samples + i), loadFour(columns + i), (i + skip) + kZeroToThree));
                   for (; i < count; ++i) {
                     const Four one = {static_cast<double>(samples[i])};
                     const FourColumns lon{Four{columns[i].sin}, Four{columns[i].cos}};
                     worst = larger(worst, Four{square(one, lon, Four{static_cast<double>(i + skip)})[0]});
                   }
                 });
  }
  // Coordinates of 7e6 m are exact to 1e-9 m, and only a handful of operations follow.
  constexpr double kNothing_m = 2e-8, kRounding_m = 5e-8;
  const double error_m = std::sqrt(largest(worst));
  return error_m > kNothing_m ? error_m + kRounding_m : 0;
}

}  // namespace foreland::terrain
