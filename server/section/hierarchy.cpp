#include "server/section/hierarchy.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "terrain/objects/placed_objects.h"

namespace foreland::server {

namespace {

ModelHull hullOf(const terrain::MappedSurface& model) {
  ModelHull hull{
      {glm::dvec3(std::numeric_limits<double>::infinity()), glm::dvec3(-std::numeric_limits<double>::infinity())},
      model.innerSolids().solids};
  for (const terrain::DrawnBox& face : terrain::boxesOfFaces(terrain::positionsOf(model))) {
    hull.box.low = glm::min(hull.box.low, face.low);
    hull.box.high = glm::max(hull.box.high, face.high);
  }
  return hull;
}

// The ground carries it along one line.
ObjectBall ballOf(const proto::ObjectPlacement& placement, const terrain::DrawnBox& box) {
  ObjectBall ball{placement.toScene(0.5 * (box.low + box.high)),
                  0.5 * placement.scale * glm::distance(box.low, box.high)};
  if (placement.rise.isStill()) return ball;
  const auto [lowest, highest] = placement.rise.range;
  ball.middle += 0.5 * (lowest + highest) * placement.rise.quantum;
  ball.radius_m += 0.5 * (highest - lowest) * glm::length(placement.rise.quantum);
  return ball;
}

}  // namespace

bool ObjectBall::mayBeSeen(const proto::View& view, const proto::Frustum& frustum) const {
  const glm::dvec3 p = middle - view.pose.eye;
  const double reach = radius_m + view.region_radius_m;
  const proto::ViewPosition at = frustum.toView(p.x, p.y, p.z);
  return frustum.sideDistance(at) + reach > 0;
}

Result<SceneObjects> objectsOf(const std::shared_ptr<const terrain::Scene>& scene) {
  auto placed = terrain::readObjects(scene);
  if (!placed.ok()) return placed.error();
  SceneObjects objects;
  for (const auto& model : placed->models) {
    objects.nodes.push_back({model->nodes(), model->nodeMoves(), model->movesEach()});
    objects.texels.push_back(model->texels());
    objects.hulls.push_back(hullOf(*model));
  }
  objects.owner =
      std::make_shared<const std::vector<std::shared_ptr<const terrain::MappedSurface>>>(std::move(placed->models));
  objects.set = std::move(placed->set);
  for (const proto::ObjectPlacement& placement : objects.set.placements())
    objects.balls.push_back(ballOf(placement, objects.hulls[placement.model].box));
  return objects;
}

}  // namespace foreland::server
