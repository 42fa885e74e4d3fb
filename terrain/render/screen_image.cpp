#include "terrain/render/screen_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

#include "base/check.h"

namespace foreland::terrain {

namespace {

struct Stop {
  float tau;  // multiples of it
  glm::vec3 colour;
};
constexpr std::array<Stop, 6> kStops{{{0.0f, {0.02f, 0.02f, 0.16f}},
                                      {0.35f, {0.05f, 0.36f, 0.47f}},
                                      {0.7f, {0.28f, 0.68f, 0.30f}},
                                      {1.0f, {0.98f, 0.90f, 0.15f}},
                                      {1.0f, {0.90f, 0.10f, 0.08f}},
                                      {4.0f, {1.0f, 1.0f, 1.0f}}}};
constexpr glm::vec3 kNothing{0.35f, 0.35f, 0.35f};

Colour toBytes(const glm::vec3& colour) {
  const auto byte = [](float v) { return static_cast<uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); };
  return {byte(colour.x), byte(colour.y), byte(colour.z), 255};
}

glm::vec3 falseColour(float in_tau) {
  if (std::isnan(in_tau)) return kNothing;
  for (size_t i = 1; i < kStops.size(); ++i)
    if (in_tau <= kStops[i].tau)
      return glm::mix(kStops[i - 1].colour, kStops[i].colour,
                      (in_tau - kStops[i - 1].tau) / std::max(kStops[i].tau - kStops[i - 1].tau, 1e-6f));
  return kStops.back().colour;
}

}  // namespace

Image colourImage(const Picture& picture) {
  Image image{picture.width, picture.height, {}};
  image.pixels.reserve(picture.colour.size());
  for (const glm::vec3& colour : picture.colour) image.pixels.push_back(toBytes(toScreen(colour)));
  return image;
}

Image errorImage(const Picture& picture, double tau_px) {
  CHECK_EQ(picture.error_px.size(), picture.colour.size());
  Image image{picture.width, picture.height, {}};
  image.pixels.reserve(picture.error_px.size());
  for (const float px : picture.error_px) image.pixels.push_back(toBytes(falseColour(px / static_cast<float>(tau_px))));
  return image;
}

}  // namespace foreland::terrain
