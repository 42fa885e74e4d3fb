#include "server/view/ground.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "proto/space/undulation_place.h"
#include "terrain/store/bilinear.h"

namespace foreland::server {

namespace {

int32_t highestAt(const terrain::Scene& scene, proto::NodeId v) {
  const terrain::EpochTable& table = scene.epochs();
  const proto::Epochs& epochs = table.epochs();
  if (epochs.empty()) return scene.height(v);
  std::vector<int32_t> quanta;
  for (uint32_t epoch = 0; epoch < epochs.size(); ++epoch)
    quanta.push_back(epochs.mayMove(epoch, v) ? table.offset(epoch, scene.grid(), v) : 0);
  return scene.height(v) + static_cast<int32_t>(std::ceil(epochs.range(quanta)[1]));
}

}  // namespace

std::optional<double> groundHeight(const terrain::Scene& scene, double x, double y) {
  const proto::GridShape& shape = scene.grid().shape();
  if (!(x >= 0 && y >= 0 && x <= shape.samples_x - 1 && y <= shape.samples_y - 1)) return std::nullopt;
  const uint32_t root_x = std::min(static_cast<uint32_t>(x) >> shape.root_log2, shape.roots_x - 1);
  const auto at = [&](uint32_t at_x, uint32_t at_y) {
    return highestAt(scene, scene.grid().nameIn(root_x, proto::NodeId::at(at_x, at_y)));
  };
  return terrain::bilinear(shape.samples_x, shape.samples_y, x, y, at) * scene.frame().height_quantum_m;
}

std::vector<float> seaAboveZero(const terrain::Scene& scene, std::span<const glm::dvec2> positions) {
  const proto::VerticalDatum& datum = scene.vertical();
  if (datum.zero_surface != proto::ZeroSurface::kEllipsoid || datum.undulations.isEmpty()) return {};
  const proto::FrameTransform transform(scene.frame());
  std::vector<float> above_m;
  for (const glm::dvec2& p : positions)
    above_m.push_back(static_cast<float>(datum.undulations.at(proto::undulationPlace(transform, p))));
  return above_m;
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
