#include "server/view/ground.h"

#include <algorithm>
#include <cmath>

namespace foreland::server {

namespace {

int32_t highestAt(const terrain::Scene& scene, proto::NodeId v) {
  const terrain::EpochTable& table = scene.epochs();
  int32_t most = 0;
  for (uint32_t epoch = 0; epoch < table.epochs().size(); ++epoch)
    if (table.epochs().mayMove(epoch, v)) most = std::max(most, table.offset(epoch, scene.grid(), v));
  return scene.height(v) + most;
}

}  // namespace

std::optional<double> groundHeight(const terrain::Scene& scene, double x, double y) {
  const proto::GridShape& shape = scene.grid().shape();
  if (!(x >= 0 && y >= 0 && x <= shape.samples_x - 1 && y <= shape.samples_y - 1)) return std::nullopt;
  const uint32_t x0 = std::min(static_cast<uint32_t>(x), shape.samples_x - 2);
  const uint32_t y0 = std::min(static_cast<uint32_t>(y), shape.samples_y - 2);
  const double u = x - x0, v = y - y0;
  const auto at = [&](uint32_t dx, uint32_t dy) {
    return double(highestAt(scene, proto::NodeId::at(x0 + dx, y0 + dy)));
  };
  const double south = at(0, 0) + u * (at(1, 0) - at(0, 0)), north = at(0, 1) + u * (at(1, 1) - at(0, 1));
  return (south + v * (north - south)) * scene.frame().height_quantum_m;
}

double heightAboveGround(const terrain::Scene& scene, const glm::dvec3& point) {
  const proto::GridShape& shape = scene.grid().shape();
  const proto::LatticePosition p = proto::FrameTransform(scene.frame()).toLattice(point);
  if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.height_m)) return 0;
  const auto ground_m =
      groundHeight(scene, std::clamp(p.x, 0.0, shape.samples_x - 1.0), std::clamp(p.y, 0.0, shape.samples_y - 1.0));
  return std::max(0.0, p.height_m - ground_m.value_or(0));
}

}  // namespace foreland::server
