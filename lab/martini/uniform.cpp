#include "lab/martini/uniform.h"

#include <cmath>
#include <vector>

#include "proto/refine/refine.h"

namespace foreland::lab {

namespace {

using proto::NodeId;

constexpr double kFarAway_m = 5e7;  // half of what poses may have

glm::dvec3 positionOf(const server::Hierarchy& hierarchy, NodeId v) {
  const terrain::Scene& scene = hierarchy.scene();
  return hierarchy.frame().position(v, scene.height(v));
}

}  // namespace

proto::View uniformView(const server::Hierarchy& hierarchy, double max_error_m) {
  const proto::GridTopology& grid = hierarchy.grid();
  const glm::dvec3 corner = positionOf(hierarchy, NodeId::at(0, 0));
  const glm::dvec3 opposite = positionOf(hierarchy, NodeId::at(grid.maxX(), grid.maxY()));
  proto::View view;
  const glm::dvec3 centre = 0.5 * (corner + opposite);
  view.pose.eye = centre + glm::dvec3(0, 0, kFarAway_m);  // the camera looks along -z as it is
  // Wide enough for the terrain, and at least 1 degree, which a lens must have.
  const double half_width_m = glm::distance(corner, opposite);
  view.lens = {.vertical_fov_rad = std::max(2 * std::atan(half_width_m / kFarAway_m), 0.0175),
               .width_px = 1000,
               .height_px = 1000};
  view.tau_px = view.lens.focalPx() * max_error_m / kFarAway_m;
  return view;
}

double nearestError_m(const server::Hierarchy& hierarchy, const proto::View& view) {
  proto::RefineScratch scratch;
  proto::Section section;
  CHECK_TRUE(server::refine(hierarchy, view, size_t{1} << 30, scratch, section));
  const double focal = view.lens.focalPx();
  double nearest = proto::Metric::kEndless_m;
  for (const proto::Slot slot : section.slots) {
    const glm::dvec3 p = positionOf(hierarchy, hierarchy.grid().node(slot)) - view.pose.eye;
    const double x = glm::dot(p, view.pose.right()), y = glm::dot(p, view.pose.up()),
                 z = glm::dot(p, view.pose.forward());
    const bool seen = z > 0 && std::fabs(x) * focal <= 0.5 * view.lens.width_px * z &&
                      std::fabs(y) * focal <= 0.5 * view.lens.height_px * z;
    if (seen) nearest = std::min(nearest, z);
  }
  return view.tau_px * nearest / focal;
}

std::optional<double> trueError_m(const terrain::Scene& scene, const proto::Section& section) {
  const proto::GridTopology& grid = scene.grid();
  const size_t width = grid.maxX() + size_t{1}, height = grid.maxY() + size_t{1};
  if (width * height > size_t{1} << 25) return std::nullopt;
  std::vector<double> drawn(width * height);
  const auto at = [&](NodeId v) -> double& { return drawn[v.y() * width + v.x()]; };
  const uint32_t half = grid.rootSize() / 2;
  for (uint32_t y = 0; y <= grid.maxY(); y += half)
    for (uint32_t x = y / half % 2 * half; x <= grid.maxX(); x += 2 * half)
      at(NodeId::at(x, y)) = scene.height(NodeId::at(x, y));
  double largest = 0;
  auto next = section.slots.begin();
  for (proto::Slot slot = 0; slot < grid.slotCount(); ++slot) {  // coarse levels first
    const bool present = next != section.slots.end() && *next == slot;
    if (present) ++next;
    const NodeId n = grid.node(slot);
    if (grid.isBase(n)) continue;  // padding
    const double truth = scene.height(n);
    const auto [a, b] = grid.endpoints(n);
    at(n) = present ? truth : 0.5 * (at(a) + at(b));
    if (n.x() < grid.shape().samples_x && n.y() < grid.shape().samples_y)
      largest = std::max(largest, std::fabs(at(n) - truth));
  }
  return largest * scene.frame().height_quantum_m;
}

}  // namespace foreland::lab
