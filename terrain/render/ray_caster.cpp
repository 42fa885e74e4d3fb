#include "terrain/render/ray_caster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "terrain/parallel.h"
#include "terrain/render/triangle_source.h"

namespace foreland::terrain {

namespace {

constexpr size_t kRaysPerPiece = 4096;

// Weights of the triangle's corners where the ray meets its plane; those of `hit` if the ray lies in the plane.
std::array<double, 3> weightsAt(const Ray& ray, const std::array<TriangleCorner, 3>& corners, const EmbreeHit& hit) {
  const glm::dvec3 a = corners[0].position, u = corners[1].position - a, v = corners[2].position - a;
  const glm::dvec3 n = glm::cross(u, v), to_plane = a - ray.origin;
  const glm::dvec3 p = glm::dot(n, to_plane) / glm::dot(n, ray.direction) * ray.direction - to_plane;
  const double area2 = glm::dot(n, n);
  const double at_u = glm::dot(glm::cross(p, v), n) / area2, at_v = glm::dot(glm::cross(u, p), n) / area2;
  if (!std::isfinite(at_u + at_v)) return {1.0 - hit.u - hit.v, hit.u, hit.v};
  return {1 - at_u - at_v, at_u, at_v};
}

// Into the triangle, for floats chose it.
void clampWeights(std::array<double, 3>& weights) {
  double sum = 0;
  for (double& w : weights) sum += w = std::max(w, 0.0);
  for (double& w : weights) w /= sum;
}

const TriangleCorner& nearestCorner(const std::array<TriangleCorner, 3>& corners, const glm::dvec3& point) {
  return *std::min_element(corners.begin(), corners.end(), [&](const TriangleCorner& a, const TriangleCorner& b) {
    return glm::distance(a.position, point) < glm::distance(b.position, point);
  });
}

RayHit pointOn(const Ray& ray, const std::array<TriangleCorner, 3>& corners, const EmbreeHit& found) {
  std::array<double, 3> weights = weightsAt(ray, corners, found);
  clampWeights(weights);
  RayHit hit;
  glm::dvec3 from_eye(0);
  for (size_t i = 0; i < 3; ++i) {
    from_eye += weights[i] * (corners[i].position - ray.origin);
    hit.parameter += weights[i] * corners[i].parameter;
    hit.height_m += weights[i] * corners[i].height_m;
  }
  hit.position = ray.origin + from_eye;
  hit.distance_m = glm::dot(from_eye, ray.direction);
  hit.corner = nearestCorner(corners, hit.position).parameter;
  const glm::dvec3 n = glm::cross(corners[1].position - corners[0].position, corners[2].position - corners[0].position);
  hit.normal = n / std::max(glm::length(n), std::numeric_limits<double>::min());
  return hit;
}

}  // namespace

RayCaster::RayCaster(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}
RayCaster::~RayCaster() = default;
RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster& RayCaster::operator=(RayCaster&&) noexcept = default;

std::optional<RayHit> RayCaster::hit(const Ray& ray) const {
  const std::optional<EmbreeHit> found = impl_->embree.cast(
      glm::vec3(ray.origin - impl_->origin), glm::vec3(ray.direction), 0.0f, static_cast<float>(ray.farthest_m));
  if (!found) return std::nullopt;
  RayHit hit = pointOn(ray, impl_->triangles->corners(*found), *found);
  hit.object = impl_->triangles->object(*found);
  return hit;
}

void RayCaster::hit(std::span<const Ray> rays, std::span<std::optional<RayHit>> hits, unsigned threads) const {
  CHECK_EQ(rays.size(), hits.size());
  parallelFor((rays.size() + kRaysPerPiece - 1) / kRaysPerPiece, threads,
              [&](uint64_t piece, unsigned) {
                const size_t end = std::min(rays.size(), (piece + 1) * kRaysPerPiece);
                for (size_t i = piece * kRaysPerPiece; i < end; ++i) hits[i] = hit(rays[i]);
              },
              [](uint64_t) { return true; });
}

uint64_t RayCaster::bytes() const { return impl_->embree.bytes(); }

}  // namespace foreland::terrain
