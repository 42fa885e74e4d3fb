#include "terrain/surface/error_shape.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace foreland::terrain {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double ratio(double a, double b) { return a == 0 ? 0 : b == 0 ? kInfinity : a / b; }

// The hull's outline is a circle of radius r, but for two tangents to it from the point at `along`.
double hoppeGauge(const Extent& shape, const Extent& e) {
  const double r = shape.across, distance = std::hypot(e.along, e.across);
  if (shape.along <= r) return ratio(distance, r);
  const double q = r / shape.along, p = std::sqrt(1 - q * q);
  if (e.along * p < e.across * q) return ratio(distance, r);  // beside the cone
  return r == 0 ? (e.across == 0 ? e.along / shape.along : kInfinity) : (e.along * q + e.across * p) / r;
}

// Largest (along / a)^2 + (across / b)^2 over the other spheroid's vectors: the largest eigenvalue of its matrix in
// this one's axes, where it is a 2 x 2 block in the plane of both normals and a number besides.
double spheroidGrowth(const Extent& shape, const Extent& other, double cosine, double sine) {
  const double a = shape.along, b = shape.across, oa = other.along * other.along, ob = other.across * other.across;
  const double aa = ratio(oa * cosine * cosine + ob * sine * sine, a * a);
  const double bb = ratio(oa * sine * sine + ob * cosine * cosine, b * b);
  const double ab = ratio(std::fabs(oa - ob) * sine * cosine, a * b), half = 0.5 * (aa - bb);
  if (!std::isfinite(aa + bb + ab)) return kInfinity;
  return std::sqrt(std::max(0.5 * (aa + bb) + std::sqrt(half * half + ab * ab), ratio(ob, b * b)));
}

// Shapes are searched for with axes of up to e^kWidest to 1.
constexpr double kWidest = 9;

Extent grownTo(ErrorShape kind, const Extent& shape, std::span<const Extent> errors) {
  double growth = 0;
  for (const Extent& e : errors) growth = std::max(growth, gauge(kind, shape, e));
  return growth == 0 ? Extent{} : Extent{shape.along * growth, shape.across * growth};
}

// Keeps only the errors that no other exceeds in both components, from the longest to the widest.
void thin(std::vector<Extent>& errors) {
  std::sort(errors.begin(), errors.end(), [](const Extent& a, const Extent& b) {
    return a.along != b.along ? a.along > b.along : a.across > b.across;
  });
  size_t kept = 0;
  for (const Extent& e : errors)
    if (kept == 0 || e.across > errors[kept - 1].across) errors[kept++] = e;
  errors.resize(kept);
}

}  // namespace

double gauge(ErrorShape kind, const Extent& shape, const Extent& e) {
  if (kind == ErrorShape::kSpheroid) return std::hypot(ratio(e.along, shape.along), ratio(e.across, shape.across));
  return hoppeGauge(shape, e);
}

double meanRadius(ErrorShape kind, const Extent& shape) {
  const double a = shape.along, b = shape.across;
  if (a <= b) return b;
  if (kind == ErrorShape::kSpheroid) return std::sqrt((2 * a * a + b * b) / 3);
  const double u =
      std::sqrt(1 - b * b / (a * a));  // cosine of the direction from which on the sphere is the larger part
  return std::sqrt(a * a * (u - u * u * u / 3) + b * b * (1 - u));
}

Extent boundingShapeByLargest(ErrorShape kind, std::span<const Extent> errors) {
  Extent shape;
  for (const Extent& e : errors) {
    shape.along = std::max(shape.along, e.along);
    shape.across = std::max(shape.across, e.across);
  }
  if (kind == ErrorShape::kHoppe) shape.along = std::max(shape.along, shape.across);
  return grownTo(kind, shape, errors);
}

// Ternary search over the logarithm of the ratio of the axes. The mean square radius that an error demands is convex in
// it, so the maximum over all errors is convex too.
Extent boundingShape(ErrorShape kind, std::vector<Extent>& errors) {
  thin(errors);
  const auto shapeAt = [&](double log_ratio) { return grownTo(kind, {1, std::exp(-log_ratio)}, errors); };
  double low = kind == ErrorShape::kHoppe ? 0 : -kWidest, high = kWidest;
  while (high - low > 0.01) {
    const double third = (high - low) / 3;
    if (meanRadius(kind, shapeAt(low + third)) < meanRadius(kind, shapeAt(high - third)))
      high -= third;
    else
      low += third;
  }
  return shapeAt(0.5 * (low + high));
}

void addOutline(ErrorShape kind, const Extent& other, double cosine, double sine, std::vector<Extent>& points) {
  constexpr int kPoints = 16;
  const double along = kind == ErrorShape::kHoppe ? other.across : other.along;
  const auto add = [&](double p, double q) {
    points.push_back({std::fabs(p * cosine - q * sine), std::fabs(p * sine + q * cosine)});
  };
  for (int i = 0; i < kPoints; ++i) {
    const double angle = std::numbers::pi * i / kPoints;
    add(along * std::cos(angle), other.across * std::sin(angle));
  }
  if (kind == ErrorShape::kHoppe) add(other.along, 0);
}

double growthToHold(ErrorShape kind, const Extent& shape, const glm::dvec3& normal, const Extent& other,
                    const glm::dvec3& other_normal) {
  if (other.along == 0 && other.across == 0) return 0;
  const double cosine = std::min(1.0, std::fabs(glm::dot(normal, other_normal)));
  const double sine = std::min(1.0, glm::length(glm::cross(normal, other_normal)));
  if (kind == ErrorShape::kSpheroid) return spheroidGrowth(shape, other, cosine, sine) * (1 + 1e-12);
  const double tip = hoppeGauge(shape, {other.along * cosine, other.along * sine});
  return std::max(tip, ratio(other.across, shape.across)) * (1 + 1e-12);
}

}  // namespace foreland::terrain
