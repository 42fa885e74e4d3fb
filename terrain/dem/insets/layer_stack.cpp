#include "terrain/dem/insets/layer_stack.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "terrain/dem/insets/feather.h"
#include "terrain/dem/voids/voids.h"

namespace foreland::terrain {

namespace {

// Lays heights over those of a window.
class Merger {
 public:
  Merger(int depth, const RefinedWindow& window) : step_(std::ldexp(1.0, -depth)), window_(window) {
    const size_t count = size_t{window.size.x} * window.size.y;
    out_.metres.assign(count, std::numeric_limits<float>::quiet_NaN());
    out_.owners.assign(count, kNobody);
  }

  void add(const Samples& base, const std::vector<float>& weights) {
    const glm::uvec2 last(base.width - 1, base.height - 1);
    forEach([&](size_t i, glm::dvec2 p) {
      const double h = drawnHeight(last, p, [&](uint32_t x, uint32_t y) { return double{base.at(x, y)}; });
      if (!std::isnan(h)) lay(i, h, weights.empty() ? 1 : weightAt(base, weights, p), kBase, nullptr);
    });
  }

  void add(const Layer& layer, int16_t index, Overlap& overlap) {
    positions_.clear();
    forEach([&](size_t, glm::dvec2 p) { positions_.push_back(p); });
    layer.to_samples(positions_);
    for (size_t i = 0; i < positions_.size(); ++i) {
      const double h = cubicHeight(layer.samples, positions_[i]);
      if (!std::isnan(h)) lay(i, h, weightAt(layer.samples, layer.weights, positions_[i]), index, &overlap);
    }
  }

  // Where there is nothing yet.
  void addBottom(const Samples& bottom) {
    const glm::uvec2 last(bottom.width - 1, bottom.height - 1);
    forEach([&](size_t i, glm::dvec2 p) {
      if (!std::isnan(out_.metres[i])) return;
      out_.metres[i] =
          static_cast<float>(drawnHeight(last, p, [&](uint32_t x, uint32_t y) { return double{bottom.at(x, y)}; }));
    });
  }

  bool meets(const Layer& layer) const {
    const glm::dvec2 low = glm::dvec2(window_.first) * step_, high = low + glm::dvec2(window_.size - 1u) * step_;
    return layer.low.x <= high.x && layer.low.y <= high.y && layer.high.x >= low.x && layer.high.y >= low.y;
  }

  MergedWindow take() { return std::move(out_); }

 private:
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (uint32_t y = 0; y < window_.size.y; ++y)
      for (uint32_t x = 0; x < window_.size.x; ++x)
        visit(size_t{y} * window_.size.x + x, (glm::dvec2(window_.first) + glm::dvec2(x, y)) * step_);
  }

  void lay(size_t i, double height_m, double weight, int16_t owner, Overlap* overlap) {
    float& out = out_.metres[i];
    if (std::isnan(out)) {
      out = static_cast<float>(height_m);
      out_.owners[i] = owner;
      return;
    }
    if (overlap != nullptr) overlap->add(out, static_cast<float>(height_m));
    out = static_cast<float>(weight == 1 ? height_m : out + weight * (height_m - out));
    if (weight > 0) out_.owners[i] = weight == 1 ? owner : kMixed;
  }

  double step_;  // of the refined lattice, in the base's
  RefinedWindow window_;
  MergedWindow out_;
  std::vector<glm::dvec2> positions_;
};

}  // namespace

MergedWindow merge(const LayerStack& stack, int depth, const RefinedWindow& window, std::span<Overlap> overlaps) {
  Merger merger(depth, window);
  for (size_t i = 0; i <= stack.layers.size(); ++i) {
    if (i == stack.below) merger.add(stack.base, stack.base_weights);
    if (i < stack.layers.size() && merger.meets(stack.layers[i]))
      merger.add(stack.layers[i], static_cast<int16_t>(i), overlaps[i]);
  }
  if (!stack.bottom.metres.empty()) merger.addBottom(stack.bottom);
  return merger.take();
}

FilledBase fillBase(const LayerStack& stack) {
  FilledBase out{stack.base, 0, {}};
  std::vector<Overlap> unused(stack.layers.size());
  const auto isVoid = [](float h) { return std::isnan(h); };
  for (uint32_t y = 0; y < stack.base.height; ++y) {
    const std::span row(out.samples.metres.data() + size_t{y} * stack.base.width, stack.base.width);
    if (std::ranges::none_of(row, isVoid)) continue;
    const MergedWindow merged = merge(stack, 0, {{0, y}, {stack.base.width, 1}}, unused);
    for (size_t x = 0; x < row.size(); ++x)
      if (isVoid(row[x])) row[x] = merged.metres[x];
  }
  // Smooth surfaces swing far out beyond the last data.
  const std::vector<float> known = out.samples.metres;
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  for (const float h : known)
    if (!std::isnan(h)) lowest = std::min(lowest, h), highest = std::max(highest, h);
  const VoidReport voids = fillVoids(out.samples.metres, out.samples.width, out.samples.height);
  for (size_t i = 0; i < known.size(); ++i)
    if (std::isnan(known[i])) out.samples.metres[i] = std::clamp(out.samples.metres[i], lowest, highest);
  out.filled = voids.samples;
  out.note = voids.note;
  return out;
}

}  // namespace foreland::terrain
