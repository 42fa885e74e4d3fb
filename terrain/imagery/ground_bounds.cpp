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

HeightsByWindow HeightsByWindow::of(const Heights& heights) {
  return {heights.width, heights.height, [heights](const SampleWindow& w, std::span<int32_t> out) {
            for (uint32_t y = 0; y < w.height; ++y)
              std::copy_n(heights.row(w.y + y) + w.x, w.width,
                          out.begin() + static_cast<ptrdiff_t>(size_t{y} * w.width));
            return Status();
          }};
}

SampleWindow GroundBounds::windowOver(const proto::LatticeBox& box) const {
  const auto first = [](double low, uint32_t count) {
    return static_cast<uint32_t>(std::clamp(std::floor(low) - kRing + 1, 0.0, count - 2.0));
  };
  const auto last = [](double high, uint32_t count) {
    return static_cast<uint32_t>(std::clamp(std::ceil(high) + kRing - 1, 1.0, count - 1.0));
  };
  const uint32_t x = first(box.low.x, heights_.width), y = first(box.low.y, heights_.height);
  return {x, y, last(box.high.x, heights_.width) - x + 1, last(box.high.y, heights_.height) - y + 1};
}

// Calls visit(rows) with the heights and the positions of as many rows as are held at a time, of which each begins with
// the last one before: so every cell is seen once, in the order in which it would be if all were held. What one strip
// holds is not read again if it is there.
template <class Visit>
Status GroundBounds::forEachStrip(const SampleWindow& window, std::vector<int32_t>& quanta,
                                  std::vector<glm::dvec3>& positions, const Visit& visit) const {
  const uint32_t rows = std::clamp(samples_at_once_ / window.width, 2u, window.height);
  for (uint32_t first = 0; first + 1 < window.height; first += rows - 1) {
    const SampleWindow strip{window.x, window.y + first, window.width, std::min(rows, window.height - first)};
    if (strip.height < window.height || quanta.empty()) {
      quanta.resize(size_t{strip.width} * strip.height);
      positions.resize(quanta.size());
      if (Status s = heights_.read(strip, quanta); !s.ok()) return s;
      size_t i = 0;
      for (uint32_t y = strip.y; y < strip.y + strip.height; ++y)
        for (uint32_t x = strip.x; x < strip.x + strip.width; ++x, ++i)
          positions[i] = grid_.position(proto::NodeId::at(x, y), quanta[i]);
    }
    visit(strip.height);
  }
  return {};
}

Result<proto::TileBounds> GroundBounds::over(const proto::LatticeBox& box, std::vector<glm::dvec3>& scratch) const {
  const SampleWindow window = windowOver(box);
  std::vector<int32_t> quanta;
  int32_t lowest = proto::kMaxHeight, highest = -proto::kMaxHeight;
  glm::dvec3 low(1), high(-1);
  const auto see = [&](uint32_t rows) {
    for (const int32_t h : quanta) lowest = std::min(lowest, h), highest = std::max(highest, h);
    forEachNormal(scratch, window.width, rows,
                  [&](const glm::dvec3& n) { low = glm::min(low, n), high = glm::max(high, n); });
  };
  if (Status s = forEachStrip(window, quanta, scratch, see); !s.ok()) return s.error();
  proto::TileBounds bounds;
  bounds.lowest_m = below(lowest * height_quantum_m_);
  bounds.highest_m = above(highest * height_quantum_m_);
  const glm::dvec3 middle = 0.5 * (low + high);
  if (!(glm::dot(middle, middle) > 1e-6)) {
    setCone(NormalCone::everything(), bounds);
    return bounds;
  }
  const auto axis = quantisedAxis(middle);
  const glm::dvec3 unit = NormalCone{axis, 0}.unitAxis();
  double least = 1;
  const auto hold = [&](uint32_t rows) {
    forEachNormal(scratch, window.width, rows,
                  [&](const glm::dvec3& n) { least = std::min(least, glm::dot(n, unit)); });
  };
  if (Status s = forEachStrip(window, quanta, scratch, hold); !s.ok()) return s.error();
  setCone(coneOf(axis, least), bounds);
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
