#include "terrain/imagery/ground_bounds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "terrain/imagery/normal_cone.h"

namespace foreland::terrain {

namespace {

// The differences at a sample reach one further, and those that are interpolated at the box's edge another.
constexpr double kRing = 2;

float below(double value) {
  const auto f = static_cast<float>(value);
  return f <= value ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}
float above(double value) {
  const auto f = static_cast<float>(value);
  return f >= value ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

void setCone(const NormalCone& cone, proto::TileBounds& bounds) {
  std::copy(cone.axis.begin(), cone.axis.end(), bounds.axis);
  bounds.half_angle = cone.half_angle;
}

// Calls visit(unit normal) for the normals at the corners of every cell between the positions. Within a cell a bilinear
// surface has, seen from above, gradients between those.
template <class Visit>
void forEachNormal(const std::vector<glm::dvec3>& positions, size_t width, size_t height, const Visit& visit) {
  const auto visitOf = [&](const glm::dvec3& east, const glm::dvec3& north) {
    const glm::dvec3 n = glm::cross(east, north);
    visit(n / std::sqrt(glm::dot(n, n)));
  };
  for (size_t y = 0; y + 1 < height; ++y)
    for (const glm::dvec3* p = &positions[y * width]; p + 1 < &positions[y * width] + width; ++p) {
      const glm::dvec3 south = p[1] - p[0], north = p[width + 1] - p[width], west = p[width] - p[0],
                       east = p[width + 1] - p[1];
      visitOf(south, west), visitOf(south, east), visitOf(north, west), visitOf(north, east);
    }
}

}  // namespace

GroundBounds::Window GroundBounds::windowOver(const proto::LatticeBox& box) const {
  const auto first = [](double low, uint32_t count) {
    return static_cast<uint32_t>(std::clamp(std::floor(low) - kRing + 1, 0.0, count - 2.0));
  };
  const auto last = [](double high, uint32_t count) {
    return static_cast<uint32_t>(std::clamp(std::ceil(high) + kRing - 1, 1.0, count - 1.0));
  };
  const uint32_t x = first(box.low.x, heights_.width), y = first(box.low.y, heights_.height);
  return {x, y, last(box.high.x, heights_.width) - x + 1, last(box.high.y, heights_.height) - y + 1};
}

void GroundBounds::setHeights(const Window& w, proto::TileBounds& bounds) const {
  int32_t lowest = proto::kMaxHeight, highest = -proto::kMaxHeight;
  for (uint32_t y = w.y; y < w.y + w.height; ++y) {
    const int32_t* row = heights_.row(y) + w.x;
    for (uint32_t i = 0; i < w.width; ++i) lowest = std::min(lowest, row[i]), highest = std::max(highest, row[i]);
  }
  bounds.lowest_m = below(lowest * height_quantum_m_);
  bounds.highest_m = above(highest * height_quantum_m_);
}

void GroundBounds::setCone(const Window& w, std::vector<glm::dvec3>& positions, proto::TileBounds& bounds) const {
  positions.resize(size_t{w.width} * w.height);
  size_t i = 0;
  for (uint32_t y = w.y; y < w.y + w.height; ++y)
    for (uint32_t x = w.x; x < w.x + w.width; ++x)
      positions[i++] = grid_.position(proto::NodeId::at(x, y), heights_.row(y)[x]);
  glm::dvec3 low(1), high(-1);
  forEachNormal(positions, w.width, w.height,
                [&](const glm::dvec3& n) { low = glm::min(low, n), high = glm::max(high, n); });
  const glm::dvec3 middle = 0.5 * (low + high);
  if (!(glm::dot(middle, middle) > 1e-6)) return terrain::setCone(NormalCone::everything(), bounds);
  const auto axis = quantisedAxis(middle);
  const glm::dvec3 unit = NormalCone{axis, 0}.unitAxis();
  double least = 1;
  forEachNormal(positions, w.width, w.height, [&](const glm::dvec3& n) { least = std::min(least, glm::dot(n, unit)); });
  terrain::setCone(coneOf(axis, least), bounds);
}

proto::TileBounds GroundBounds::over(const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch) const {
  proto::TileBounds bounds;
  const Window window = windowOver(box);
  setHeights(window, bounds);
  setCone(window, scratch, bounds);
  return bounds;
}

proto::TileBounds unionOf(std::span<const proto::TileBounds> parts) {
  proto::TileBounds all = parts.front();
  std::vector<NormalCone> cones;
  for (const proto::TileBounds& part : parts) {
    all.lowest_m = std::min(all.lowest_m, part.lowest_m);
    all.highest_m = std::max(all.highest_m, part.highest_m);
    cones.push_back(NormalCone::of(part));
  }
  setCone(unionOf(std::span<const NormalCone>(cones)), all);
  return all;
}

}  // namespace foreland::terrain
