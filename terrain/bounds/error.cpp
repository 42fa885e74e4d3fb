#include "terrain/bounds/error.h"

#include <cmath>
#include <glm/vec3.hpp>

#include "terrain/bounds/fine_errors.h"
#include "terrain/bounds/four.h"
#include "terrain/bounds/support.h"

namespace foreland::terrain {

namespace {

// Largest of four at a time and of the few that remain at the end of a row.
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

}  // namespace

PlanarError::PlanarError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights)
    : grid_(grid), heights_(heights), step_m_(frame.height_quantum_m) {}

double PlanarError::metres(proto::NodeId n) const {
  const auto ends = grid_.endpoints(n);
  const auto heightOf = [&](proto::NodeId v) { return static_cast<double>(heights_.clamped(v.x(), v.y())); };
  Largest worst;
  for (proto::NodeId apex : grid_.apexes(n)) {
    const SupportTriangle triangle(n, ends, apex);
    const Plane<double> plane = triangle.plane(heightOf(triangle.a), heightOf(triangle.b), heightOf(apex));
    triangle.forEachRow([&](int32_t dy, int32_t first, int32_t last) {
      const uint32_t y = n.y() + static_cast<uint32_t>(dy), x = n.x() + static_cast<uint32_t>(first);
      if (y >= heights_.height || x >= heights_.width) return;
      const int32_t count = std::min(last - first + 1, static_cast<int32_t>(heights_.width - x));
      scanRow(heights_.row(y) + x, count, plane.at(first, dy), plane.per_x, worst);
    });
  }
  return inMetres(worst.value());
}

// Rounded up: the product itself may round down.
double PlanarError::inMetres(double steps) const { return steps * step_m_ * (1 + 0x1p-51); }

GeographicError::GeographicError(const proto::GridTopology& grid, const proto::Frame& frame, const Heights& heights)
    : grid_(grid),
      heights_(heights),
      step_m_(frame.height_quantum_m),
      polar_((1 - frame.flattening) * (1 - frame.flattening)) {
  const proto::FrameTransform transform(frame);
  for (uint32_t y = 0; y <= grid.maxY(); ++y)
    rows_.push_back(transform.row(frame.latitude0_rad + y * frame.latitude_step_rad));
  for (uint32_t x = 0; x <= grid.maxX(); ++x) {
    const auto column = transform.column(frame.longitude0_rad + x * frame.longitude_step_rad);
    sin_lon_.push_back(column.sin);
    cos_lon_.push_back(column.cos);
  }
}

// Earth-centred, axes turned to the origin's meridian: distances are those of the scene frame.
glm::dvec3 GeographicError::corner(proto::NodeId v) const {
  const auto& row = rows_[v.y()];
  const double height_m = heights_.clamped(v.x(), v.y()) * step_m_, ring = (row.normal + height_m) * row.cos;
  return {ring * cos_lon_[v.x()], ring * sin_lon_[v.x()], (row.normal * polar_ + height_m) * row.sin};
}

double GeographicError::metres(proto::NodeId n) const {
  const auto ends = grid_.endpoints(n);
  const glm::dvec3 at_a = corner(ends[0]), at_b = corner(ends[1]);
  Four worst{};
  for (proto::NodeId apex : grid_.apexes(n)) {
    const SupportTriangle triangle(n, ends, apex);
    const Plane<glm::dvec3> plane = triangle.plane(at_a, at_b, corner(apex));
    triangle.forEachRow([&](int32_t dy, int32_t first, int32_t last) {
      const uint32_t y = n.y() + static_cast<uint32_t>(dy), x = n.x() + static_cast<uint32_t>(first);
      if (y >= heights_.height || x >= heights_.width) return;
      const int32_t count = std::min(last - first + 1, static_cast<int32_t>(heights_.width - x));
      const auto& row = rows_[y];
      const glm::dvec3 start = plane.at(first, dy), slope = plane.per_x;
      const int32_t* samples = heights_.row(y) + x;
      const auto square = [&](Four steps, Four sin_lon, Four cos_lon, Four along) {
        const Four height_m = steps * step_m_, ring = (row.normal + height_m) * row.cos;
        const Four ox = ring * cos_lon - (start.x + slope.x * along), oy = ring * sin_lon - (start.y + slope.y * along);
        const Four oz = (row.normal * polar_ + height_m) * row.sin - (start.z + slope.z * along);
        return ox * ox + oy * oy + oz * oz;
      };
      int32_t i = 0;
      for (; i + 4 <= count; i += 4)
        worst = larger(worst, square(loadFour(samples + i), loadFour(&sin_lon_[x + i]), loadFour(&cos_lon_[x + i]),
                                     i + kZeroToThree));
      for (; i < count; ++i) {
        const Four one = {static_cast<double>(samples[i])};
        worst = larger(
            worst, Four{square(one, Four{sin_lon_[x + i]}, Four{cos_lon_[x + i]}, Four{static_cast<double>(i)})[0]});
      }
    });
  }
  // Coordinates of 7e6 m carry 1e-9 m, and there are a handful of operations on them.
  constexpr double kNothing_m = 2e-8, kRounding_m = 5e-8;
  const double error_m = std::sqrt(largest(worst));
  return error_m > kNothing_m ? error_m + kRounding_m : 0;
}

}  // namespace foreland::terrain
