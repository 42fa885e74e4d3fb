#include "apps/heights/scene_heights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "terrain/store/bilinear.h"

namespace foreland::apps {

namespace {

double heightOf(const terrain::Scene& scene, const proto::EpochWeights& weights, proto::NodeId v) {
  double quanta = scene.height(v);
  const terrain::EpochTable& table = scene.epochs();
  for (uint32_t i = 0; i < weights.count; ++i)
    if (const uint32_t epoch = weights.epoch[i]; table.epochs().mayMove(epoch, v))
      quanta += weights.weight[i] * table.offset(epoch, scene.grid(), v);
  return quanta;
}

bool isNear(const proto::LatticeWindow& w, glm::dvec2 at) {
  return at.x >= w.x && at.y >= w.y && at.x <= w.x + w.width - 1.0 && at.y <= w.y + w.height - 1.0;
}

// The inputs that a height may come from: as far as the first without voids that has the place in its window.
void nameSource(const terrain::Scene& scene, glm::dvec2 lattice, SceneHeight& out) {
  bool is_first = true;
  for (const terrain::SceneInput& input : scene.inputs()) {
    if (!isNear(input.window, lattice)) continue;
    out.source += (is_first ? "" : "; ") + input.name;
    if (std::isnan(input.residual_m))
      out.residual_m.reset();
    else if (is_first || out.residual_m)
      out.residual_m = std::max(out.residual_m.value_or(0), input.residual_m);
    is_first = false;
    if (!input.may_have_voids) return;
  }
  if (is_first && scene.inputs().empty()) out.source = scene.origin().title;
}

}  // namespace

glm::dvec2 latticeAt(const terrain::Scene& scene, double x, double y) {
  const proto::Frame& f = scene.frame();
  if (f.kind == proto::FrameKind::kPlanar) {
    const glm::dvec2 from = glm::dvec2(x, y) - f.map_origin_m;
    const double area = f.axis_x_m.x * f.axis_y_m.y - f.axis_x_m.y * f.axis_y_m.x;
    return f.anchor +
           glm::dvec2(from.x * f.axis_y_m.y - from.y * f.axis_y_m.x, from.y * f.axis_x_m.x - from.x * f.axis_x_m.y) /
               area;
  }
  constexpr double kDegree = std::numbers::pi / 180, kTurn = 2 * std::numbers::pi;
  const double last = scene.grid().shape().samples_x - 1.0, turn = kTurn / f.longitude_step_rad;
  double column = (x * kDegree - f.longitude0_rad) / f.longitude_step_rad;
  if (column < 0 || column > last) {
    const double turned = column - turn * std::floor(column / turn);
    if (turned <= last) column = turned;
  }
  return {column, (y * kDegree - f.latitude0_rad) / f.latitude_step_rad};
}

std::optional<SceneHeight> heightAt(const terrain::Scene& scene, glm::dvec2 lattice, Time scene_time) {
  constexpr double kOnBorder = 1e-6;  // samples: what rounding of degrees loses
  const proto::GridShape& shape = scene.grid().shape();
  const glm::dvec2 last(shape.samples_x - 1.0, shape.samples_y - 1.0);
  if (!(lattice.x >= -kOnBorder && lattice.y >= -kOnBorder && lattice.x <= last.x + kOnBorder &&
        lattice.y <= last.y + kOnBorder))
    return std::nullopt;
  const glm::dvec2 inside(std::clamp(lattice.x, 0.0, last.x), std::clamp(lattice.y, 0.0, last.y));
  const proto::Epochs& epochs = scene.epochs().epochs();
  proto::EpochWeights weights;
  weights.count = 0;
  if (!epochs.empty()) weights = epochs.weightsAt(epochs.clamp(static_cast<double>(scene_time.us)));
  const auto at = [&](uint32_t x, uint32_t y) { return heightOf(scene, weights, proto::NodeId::at(x, y)); };
  SceneHeight out{};
  out.height_m =
      terrain::bilinear(shape.samples_x, shape.samples_y, inside.x, inside.y, at) * scene.frame().height_quantum_m;
  out.both = proto::bothHeights(scene.vertical(), inside, out.height_m);
  nameSource(scene, inside, out);
  return out;
}

}  // namespace foreland::apps
