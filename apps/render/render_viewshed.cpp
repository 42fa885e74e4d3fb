#include "apps/render/render_viewshed.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "terrain/parallel.h"
#include "terrain/render/projector.h"

namespace foreland::apps {

namespace {

constexpr glm::vec3 kSeen(0.08f, 0.75f, 0.12f);
constexpr float kTint = 0.55f, kDark = 0.45f;
// Pictures know a point's depth in floats, and an end that lies a hair below the ground is hidden by it.
constexpr double kLift_m = 0.1;

}  // namespace

Result<ViewshedTint> ViewshedTint::of(const ViewshedOptions& options,
                                      const std::shared_ptr<const terrain::Scene>& scene) {
  auto question = questionOf(options, "--viewshed", *scene);
  if (!question.ok()) return question.error();
  auto objects = server::objectsOf(scene);
  if (!objects.ok()) return objects.error();
  auto hierarchy = std::make_unique<const server::Hierarchy>(scene, proto::ErrorBound::kSpheroid, std::move(*objects));
  auto sight = server::SightScene::create(*hierarchy);
  if (!sight.ok()) return sight.error();
  return ViewshedTint(std::move(hierarchy), *question, std::move(*sight));
}

void ViewshedTint::apply(const terrain::Camera& camera, Time scene_time, terrain::Picture& picture) const {
  const terrain::Projector projector(camera);
  const proto::FrameTransform& transform = sight_->transform();
  const server::SightTime time = sight_->at(scene_time);
  const glm::dvec3 eye = sight_->aboveGround(question_.observer, question_.observer_m, time).value();
  const auto foot = [&](const glm::dvec3& p) {
    const proto::LatticePosition at = transform.toLattice(p);
    return transform.toScene(proto::LatticePosition{at.x, at.y, 0});
  };
  const glm::dvec3 below = foot(eye);
  const auto tint = [&](uint32_t column, uint32_t row) {
    const size_t pixel = size_t{row} * picture.width + column;
    if (!std::isfinite(picture.depth_m[pixel])) return;
    const terrain::Ray ray = projector.through(column, row);
    const double ahead = glm::dot(ray.direction, camera.pose.forward());
    const glm::dvec3 shown = ray.origin + picture.depth_m[pixel] / ahead * ray.direction;
    if (glm::distance(foot(shown), below) > question_.radius_m) return;
    const glm::dvec3 target =
        shown + kLift_m * glm::dvec3(picture.normal[pixel]) + question_.target_m * transform.upAt(shown);
    glm::vec3& colour = picture.colour[pixel];
    const bool is_seen = sight_->sees(eye, target, question_.refraction, time);
    colour = is_seen ? glm::mix(colour, kSeen, kTint) : kDark * colour;
  };
  terrain::parallelFor(
      picture.height, camera.threads,
      [&](uint64_t row, unsigned) {
        for (uint32_t column = 0; column < picture.width; ++column) tint(column, static_cast<uint32_t>(row));
      },
      [](uint64_t) { return true; });
}

}  // namespace foreland::apps
