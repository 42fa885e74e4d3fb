#include "apps/serve/scene_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace foreland::apps {
namespace {

constexpr uint32_t kMostPixels = 640;

// From the lowest ground to the highest, in equal steps: greens, ochres, rock, snow; bytes of sRGB.
constexpr std::array<glm::dvec3, 7> kTints{{{62, 104, 72},
                                            {110, 143, 89},
                                            {176, 178, 112},
                                            {201, 172, 112},
                                            {171, 128, 90},
                                            {160, 148, 140},
                                            {248, 248, 250}}};

glm::dvec3 tintAt(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kTints.size() - 1);
  const auto below = std::min(static_cast<size_t>(at), kTints.size() - 2);
  return glm::mix(kTints[below], kTints[below + 1], at - static_cast<double>(below));
}

// The part of the lattice that is shown, and metres between its samples in the middle of it.
struct Part {
  uint32_t columns, rows;
  glm::dvec2 spacing_m;
};

Part partOf(const terrain::Scene& scene) {
  const proto::GridShape& s = scene.grid().shape();
  const proto::Frame& f = scene.frame();
  if (s.is_cube) {
    const uint32_t side = uint32_t{1} << s.root_log2;
    return {side + 1, side + 1, glm::dvec2(f.semi_major_m * 1.5708 / side)};
  }
  if (f.kind == proto::FrameKind::kPlanar)
    return {s.samples_x, s.samples_y, {glm::length(f.axis_x_m), glm::length(f.axis_y_m)}};
  const double latitude = f.latitude0_rad + 0.5 * s.samples_y * f.latitude_step_rad;
  return {s.samples_x,
          s.samples_y,
          {f.semi_major_m * f.longitude_step_rad * std::max(std::cos(latitude), 0.1),
           f.semi_major_m * f.latitude_step_rad}};
}

struct Heights {
  uint32_t width, height;
  std::vector<double> quanta;  // row by row from the south

  double at(int64_t x, int64_t y) const {
    x = std::clamp<int64_t>(x, 0, width - 1), y = std::clamp<int64_t>(y, 0, height - 1);
    return quanta[static_cast<size_t>(y) * width + static_cast<size_t>(x)];
  }
};

// One of `stride` samples, a power of two.
Heights heightsOf(const terrain::Scene& scene, const Part& part, uint32_t stride) {
  Heights heights{(part.columns - 1) / stride + 1, (part.rows - 1) / stride + 1, {}};
  heights.quanta.reserve(size_t{heights.width} * heights.height);
  for (uint32_t y = 0; y < heights.height; ++y)
    for (uint32_t x = 0; x < heights.width; ++x)
      heights.quanta.push_back(scene.height(proto::NodeId::at(x * stride, y * stride)));
  return heights;
}

std::array<uint8_t, 3> bytesOf(const glm::dvec3& colour) {
  const auto byte = [](double v) { return static_cast<uint8_t>(std::lround(std::clamp(v, 0.0, 255.0))); };
  return {byte(colour.x), byte(colour.y), byte(colour.z)};
}

}  // namespace

server::Picture scenePicture(const terrain::Scene& scene) {
  const Part part = partOf(scene);
  uint32_t stride = 1;
  while (std::max(part.columns, part.rows) / stride > kMostPixels) stride *= 2;
  const Heights heights = heightsOf(scene, part, stride);
  const auto [lowest, highest] = std::ranges::minmax(heights.quanta);
  const glm::dvec2 run = 2.0 * stride * part.spacing_m / scene.frame().height_quantum_m;  // over two pixels, in quanta
  // Slopes of gentle ground are drawn steeper, so that there is something to see of it.
  const double relief = std::max((highest - lowest) / (0.06 * 0.5 * run.x * heights.width), 1e-9);
  const double steeper = std::clamp(1 / relief, 1.0, 30.0);
  const glm::dvec3 light = glm::normalize(glm::dvec3(-1, 1, 1.4));
  server::Picture picture{heights.width, heights.height, {}};
  for (int64_t y = heights.height - 1; y >= 0; --y)
    for (int64_t x = 0; x < heights.width; ++x) {
      const double east = heights.at(x + 1, y) - heights.at(x - 1, y),
                   north = heights.at(x, y + 1) - heights.at(x, y - 1);
      const glm::dvec3 normal = glm::normalize(glm::dvec3(-steeper * east / run.x, -steeper * north / run.y, 1));
      const double lit = std::clamp(0.25 + 0.95 * glm::dot(normal, light) / light.z, 0.15, 1.25);
      picture.pixels.push_back(bytesOf(lit * tintAt((heights.at(x, y) - lowest) / std::max(highest - lowest, 1.0))));
    }
  return picture;
}

}  // namespace foreland::apps
