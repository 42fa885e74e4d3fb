// The colours of reference pictures: tinted by height, lit from the north-west as maps are, with haze; objects by their
// models' images, and globes by their imagery, in whose pictures the sun is north-west everywhere. Linear light.
// Immutable; any thread.
#pragma once

#include <glm/vec3.hpp>
#include <memory>

#include "terrain/imagery/tile_picture.h"
#include "terrain/objects/placed_objects.h"
#include "terrain/render/ray_caster.h"
#include "terrain/store/scene.h"

namespace foreland::terrain {

class Shading {
 public:
  // An Error if the scene's objects are damaged.
  static Result<Shading> of(const std::shared_ptr<const Scene>& scene);

  glm::vec3 surface(const Ray& ray, const RayHit& hit) const;
  glm::vec3 sky(const Ray& ray) const;
  // Ground as on a map: from straight above, without haze. The normal is unit, in axes east, north, up of the place.
  glm::vec3 fromAbove(const glm::vec3& normal, double height_m) const;

 private:
  Shading(std::shared_ptr<const Scene> scene, PlacedObjects objects);
  glm::vec3 ground(const RayHit& hit, const glm::vec3& up) const;
  glm::vec3 object(const RayHit& hit) const;
  bool isGlobe() const { return scene_->frame().kind == proto::FrameKind::kGlobe; }
  glm::vec3 ofPicture(const RayHit& hit, const glm::vec3& bare) const;
  float clearness(const Ray& ray, const RayHit& hit) const;

  std::shared_ptr<const Scene> scene_;
  PlacedObjects objects_;
  std::shared_ptr<TilePicture> picture_;  // of globes that have one
  proto::FrameTransform transform_;
  float lowest_m_, span_m_, haze_m_;
};

// As a screen shows it: the filmic curve of Narkowicz's fit of ACES, then sRGB; each channel in 0..1.
glm::vec3 toScreen(const glm::vec3& linear);

}  // namespace foreland::terrain
