// What is seen from a point, laid over reference pictures: a line of sight for every pixel, so no cells show. Any
// thread may tint; it uses all processors while it does.
#pragma once

#include <memory>

#include "apps/viewshed/viewshed_options.h"
#include "base/result.h"
#include "server/sight/sight_scene.h"
#include "terrain/render/picture.h"

namespace foreland::apps {

class ViewshedTint {
 public:
  static Result<ViewshedTint> of(const ViewshedOptions& options, const std::shared_ptr<const terrain::Scene>& scene);

  // Green where what a pixel shows, --target above it, is seen from the point at a scene time; darker where it is not;
  // as it was beyond the radius.
  void apply(const terrain::Camera& camera, Time scene_time, terrain::Picture& picture) const;

 private:
  ViewshedTint(std::unique_ptr<const server::Hierarchy> hierarchy, const server::ViewshedQuestion& question,
               std::shared_ptr<const server::SightScene> sight)
      : hierarchy_(std::move(hierarchy)), question_(question), sight_(std::move(sight)) {}

  std::unique_ptr<const server::Hierarchy> hierarchy_;
  server::ViewshedQuestion question_;
  std::shared_ptr<const server::SightScene> sight_;
};

}  // namespace foreland::apps
