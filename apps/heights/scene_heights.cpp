#include "apps/heights/scene_heights.h"

#include <algorithm>
#include <cmath>

#include "proto/space/undulation_place.h"
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
  const uint32_t root_x = std::min(static_cast<uint32_t>(inside.x) >> shape.root_log2, shape.roots_x - 1);
  const auto at = [&](uint32_t x, uint32_t y) {
    return heightOf(scene, weights, scene.grid().nameIn(root_x, proto::NodeId::at(x, y)));
  };
  SceneHeight out{};
  out.height_m =
      terrain::bilinear(shape.samples_x, shape.samples_y, inside.x, inside.y, at) * scene.frame().height_quantum_m;
  const glm::dvec2 place = proto::undulationPlace(proto::FrameTransform(scene.frame()), inside);
  out.both = proto::bothHeights(scene.vertical(), place, out.height_m);
  nameSource(scene, inside, out);
  return out;
}

}  // namespace foreland::apps
