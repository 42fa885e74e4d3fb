#include "terrain/render/shading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

// Linear; from the lowest ground to the highest, then rock and snow.
constexpr std::array<glm::vec3, 6> kPalette{{{0.044f, 0.084f, 0.039f},
                                             {0.089f, 0.141f, 0.060f},
                                             {0.205f, 0.202f, 0.091f},
                                             {0.223f, 0.147f, 0.084f},
                                             {0.159f, 0.125f, 0.102f},
                                             {0.314f, 0.292f, 0.271f}}};
constexpr glm::vec3 kRock{0.15f, 0.13f, 0.115f}, kSnow{0.80f, 0.84f, 0.90f}, kPlain{0.45f, 0.45f, 0.45f};
constexpr glm::vec3 kHaze{0.36f, 0.50f, 0.68f}, kZenith{0.030f, 0.105f, 0.310f};
constexpr glm::vec3 kSunlight{2.15f, 1.92f, 1.56f}, kSkylight{0.17f, 0.24f, 0.36f}, kGroundlight{0.09f, 0.08f, 0.07f};
// North-west, 36 degrees high.
const glm::vec3 kSun = glm::normalize(glm::vec3(-0.5714f, 0.5714f, 0.589f));

glm::vec3 hypsometric(float t) {
  const float at = std::clamp(t, 0.0f, 1.0f) * (kPalette.size() - 1);
  const size_t i = std::min(static_cast<size_t>(at), kPalette.size() - 2);
  return glm::mix(kPalette[i], kPalette[i + 1], glm::smoothstep(0.0f, 1.0f, at - static_cast<float>(i)));
}

glm::vec3 fromSrgb(Texel texel) {
  const auto part = [&](int shift) { return std::pow(static_cast<float>(texel >> shift & 0xff) / 255, 2.2f); };
  return {part(0), part(8), part(16)};
}

// North-west of a globe's place, in the body's axes.
glm::vec3 sunOver(const glm::vec3& up) {
  const glm::vec3 across(-up.y, up.x, 0),
      east = glm::length(across) > 1e-6f ? glm::normalize(across) : glm::vec3(0, 1, 0);
  return kSun.x * east + kSun.y * glm::cross(up, east) + kSun.z * up;
}

glm::vec3 lit(const glm::vec3& albedo, const glm::vec3& normal, const glm::vec3& up, const glm::vec3& sun = kSun) {
  const float openness = 0.5f + 0.5f * glm::dot(normal, up);
  return albedo * (kSunlight * std::max(glm::dot(normal, sun), 0.0f) + glm::mix(kGroundlight, kSkylight, openness));
}

}  // namespace

Result<Shading> Shading::of(const std::shared_ptr<const Scene>& scene) {
  Result<PlacedObjects> objects = readObjects(scene);
  if (!objects.ok()) return objects.error();
  return Shading(scene, std::move(*objects));
}

// Haze veils two thirds at the distance of the scene's diagonal.
Shading::Shading(std::shared_ptr<const Scene> scene, PlacedObjects objects)
    : scene_(std::move(scene)), objects_(std::move(objects)), transform_(scene_->frame()) {
  if (isGlobe()) picture_ = TilePicture::of(scene_);
  const double quantum_m = scene_->frame().height_quantum_m;
  lowest_m_ = static_cast<float>(scene_->heightRange().lowest * quantum_m);
  span_m_ = std::max(static_cast<float>(scene_->heightRange().highest * quantum_m) - lowest_m_, 1e-3f);
  const proto::GridShape& shape = scene_->grid().shape();
  haze_m_ = static_cast<float>(
      glm::distance(transform_.toScene(proto::LatticePosition{0, 0, 0}),
                    transform_.toScene(proto::LatticePosition{shape.samples_x - 1.0, shape.samples_y - 1.0, 0})));
}

glm::vec3 Shading::ground(const RayHit& hit, const glm::vec3& up) const {
  const float t = (static_cast<float>(hit.height_m) - lowest_m_) / span_m_;
  const float steepness = 1 - glm::dot(glm::vec3(hit.normal), up);
  const glm::vec3 bare = glm::mix(hypsometric(t), kRock, glm::smoothstep(0.20f, 0.42f, steepness));
  return glm::mix(bare, kSnow, glm::smoothstep(0.70f, 0.80f, t) * (1 - glm::smoothstep(0.26f, 0.44f, steepness)));
}

glm::vec3 Shading::object(const RayHit& hit) const {
  const MappedSurface& model = *objects_.models[objects_.set.placement(static_cast<size_t>(hit.object)).model];
  const proto::AtlasLayout atlas = model.atlas();
  if (atlas.side == 0) return kPlain;
  const auto pixel = [](double coordinate, uint32_t size) {
    return static_cast<size_t>(std::clamp(coordinate * size, 0.0, size - 1.0));
  };
  return fromSrgb(
      model.texels()[pixel(hit.parameter.y, atlas.height()) * atlas.width() + pixel(hit.parameter.x, atlas.width())]);
}

// Texels are no finer than the ground that is as wide as a thousandth of its distance.
glm::vec3 Shading::ofPicture(const RayHit& hit, const glm::vec3& bare) const {
  if (!picture_) return bare;
  const proto::LatticePosition at = transform_.toLattice(hit.position);
  const double interval_m = transform_.spheroid().equatorial() * 1.5708 / scene_->frame().face_steps;
  const auto colour = picture_->at({at.x, at.y}, 0.001 * hit.distance_m / interval_m);
  if (!colour) return bare;
  const auto part = [](double srgb) { return std::pow(static_cast<float>(srgb) / 255, 2.2f); };
  return {part(colour->x), part(colour->y), part(colour->z)};
}

// Of a body's air there is none beyond some kilometres.
float Shading::clearness(const Ray& ray, const RayHit& hit) const {
  if (!isGlobe()) return std::exp(-static_cast<float>(hit.distance_m) / haze_m_);
  constexpr float kAir_m = 12e3f, kFar_m = 4e5f;
  const auto away = static_cast<float>(-glm::dot(ray.direction, transform_.upAt(hit.position)));
  return std::exp(-std::min(static_cast<float>(hit.distance_m), kAir_m / std::max(away, 0.03f)) / kFar_m);
}

glm::vec3 Shading::surface(const Ray& ray, const RayHit& hit) const {
  const glm::vec3 up(transform_.upAt(hit.position));
  const glm::vec3 albedo = hit.object == RayHit::kTerrain ? ofPicture(hit, ground(hit, up)) : object(hit);
  const float clear = clearness(ray, hit);
  return glm::mix(
      sky({ray.origin, glm::normalize(ray.direction - glm::dot(ray.direction, glm::dvec3(up)) * glm::dvec3(up))}),
      lit(albedo, glm::vec3(hit.normal), up, isGlobe() ? sunOver(up) : kSun), clear);
}

glm::vec3 Shading::sky(const Ray& ray) const {
  const auto height = static_cast<float>(glm::dot(ray.direction, transform_.upAt(ray.origin)));
  const glm::vec3 seen = glm::mix(kHaze, kZenith, 1 - std::exp(-5.5f * std::max(height, 0.0f)));
  if (!isGlobe()) return seen;
  constexpr double kAir_m = 30e3;  // and black space above
  const double above_m = transform_.spheroid().place(ray.origin).height_m;
  return seen * static_cast<float>(std::exp(-std::max(above_m, 0.0) / kAir_m));
}

glm::vec3 Shading::fromAbove(const glm::vec3& normal, double height_m) const {
  constexpr glm::vec3 kUp{0, 0, 1};
  RayHit hit;
  hit.normal = normal;
  hit.height_m = height_m;
  return lit(ground(hit, kUp), normal, kUp);
}

glm::vec3 toScreen(const glm::vec3& linear) {
  const glm::vec3 x = linear * 0.80f;
  const glm::vec3 filmic = glm::clamp(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 0.0f, 1.0f);
  glm::vec3 screen;
  for (int i = 0; i < 3; ++i)
    screen[i] = filmic[i] < 0.0031308f ? 12.92f * filmic[i] : 1.055f * std::pow(filmic[i], 1 / 2.4f) - 0.055f;
  return screen;
}

}  // namespace foreland::terrain
