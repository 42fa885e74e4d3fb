#include "terrain/dem/insets/refined_tiles.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

namespace foreland::terrain {

namespace {

constexpr uint32_t kTileCells = 256;
constexpr double kRounding_m = 1e-3;  // of floats, in heights that are the same

// Heights of a window, of which those at multiples of a step count.
struct Grid {
  const std::vector<float>& metres;
  RefinedWindow window;
  uint32_t step;

  double at(uint32_t x, uint32_t y) const {
    const glm::uvec2 p = glm::uvec2(x, y) * step - window.first;
    return metres[size_t{p.y} * window.size.x + p.x];
  }
  // At a position of the refined lattice.
  double drawn(glm::dvec2 p) const {
    const glm::uvec2 last = (window.first + window.size - 1u) / step;
    return drawnHeight(last, p / double(step), [&](uint32_t x, uint32_t y) { return at(x, y); });
  }
  double bilinear(glm::dvec2 p) const {
    const glm::uvec2 last = (window.first + window.size - 1u) / step;
    p /= double(step);
    const glm::uvec2 cell = glm::min(glm::uvec2(p), last - 1u);
    const glm::dvec2 t = p - glm::dvec2(cell);
    const auto along = [&](uint32_t y) { return (1 - t.x) * at(cell.x, y) + t.x * at(cell.x + 1, y); };
    return (1 - t.y) * along(cell.y) + t.y * along(cell.y + 1);
  }
};

// A sample of a layer over a window.
struct LayerSample {
  glm::dvec2 at;  // of the refined lattice
  float metres;
};

// The samples of a layer around which its heights alone count.
std::vector<LayerSample> samplesOf(const LayerStack& stack, int16_t index, int depth, const RefinedWindow& window,
                                   const std::vector<int16_t>& owners) {
  const Layer& layer = stack.layers[static_cast<size_t>(index)];
  const double scale = std::ldexp(1.0, depth);
  const glm::dvec2 first(window.first), last = first + glm::dvec2(window.size - 1u);
  // The columns and rows that the window's border reaches.
  std::vector<glm::dvec2> border;
  for (uint32_t i = 0; i < window.size.x; ++i)
    border.emplace_back((first.x + i) / scale, first.y / scale),
        border.emplace_back((first.x + i) / scale, last.y / scale);
  for (uint32_t i = 0; i < window.size.y; ++i)
    border.emplace_back(first.x / scale, (first.y + i) / scale),
        border.emplace_back(last.x / scale, (first.y + i) / scale);
  layer.to_samples(border);
  glm::dvec2 low(layer.samples.width, layer.samples.height), high(0);
  for (const glm::dvec2& p : border)
    if (!std::isnan(p.x)) low = glm::min(low, p), high = glm::max(high, p);
  low = glm::max(glm::floor(low) - 1.0, glm::dvec2(0));
  high = glm::min(glm::ceil(high) + 1.0, glm::dvec2(layer.samples.width - 1.0, layer.samples.height - 1.0));
  std::vector<LayerSample> out;
  std::vector<glm::dvec2> row;
  for (double y = low.y; y <= high.y; ++y) {
    row.clear();
    for (double x = low.x; x <= high.x; ++x) row.emplace_back(x, y);
    layer.to_lattice(row);
    for (size_t i = 0; i < row.size(); ++i) {
      const glm::dvec2 p = row[i] * scale;
      const float h = layer.samples.at(static_cast<uint32_t>(low.x + double(i)), static_cast<uint32_t>(y));
      if (std::isnan(h) || !(p.x >= first.x && p.y >= first.y && p.x <= last.x && p.y <= last.y)) continue;
      const glm::uvec2 cell = glm::min(glm::uvec2(p - first), window.size - 2u);
      const auto isOwned = [&](uint32_t x, uint32_t y_) { return owners[size_t{y_} * window.size.x + x] == index; };
      if (isOwned(cell.x, cell.y) && isOwned(cell.x + 1, cell.y) && isOwned(cell.x, cell.y + 1) &&
          isOwned(cell.x + 1, cell.y + 1))
        out.push_back({p, h});
    }
  }
  return out;
}

double residualOf(const Grid& grid, const std::vector<LayerSample>& samples) {
  double largest_m = 0;
  for (const LayerSample& s : samples)
    largest_m =
        std::max({largest_m, std::fabs(grid.drawn(s.at) - s.metres), std::fabs(grid.bilinear(s.at) - s.metres)});
  return largest_m;
}

// Whether a grid is within a bound of the heights that it takes some of.
bool isWithin(const Grid& grid, double bound_m) {
  for (uint32_t y = 0; y < grid.window.size.y; ++y)
    for (uint32_t x = 0; x < grid.window.size.x; ++x) {
      const double h = grid.metres[size_t{y} * grid.window.size.x + x];
      if (!(std::fabs(grid.drawn(glm::dvec2(grid.window.first + glm::uvec2(x, y))) - h) <= bound_m)) return false;
    }
  return true;
}

}  // namespace

RefinedTiles::RefinedTiles(const LayerStack& stack, int depth, double residual_m, std::span<Overlap> overlaps)
    : stack_(stack),
      depth_(depth),
      residual_m_(std::max(residual_m, kRounding_m)),
      side_(std::max(kTileCells, 1u << depth)),
      last_(glm::uvec2(stack.base.width - 1, stack.base.height - 1) << static_cast<uint32_t>(depth)),
      tiles_((last_ + side_ - 1u) / side_),
      tile_(size_t{tiles_.x} * tiles_.y),
      residuals_(stack.layers.size()),
      tiles_of_depth_(static_cast<size_t>(depth) + 1) {
  for (uint32_t y = 0; y < tiles_.y; ++y)
    for (uint32_t x = 0; x < tiles_.x; ++x)
      if (const RefinedWindow window = windowOf({x, y}); isReached(window)) {
        tile_[size_t{y} * tiles_.x + x] = makeTile(window, overlaps);
        ++tiles_of_depth_[static_cast<size_t>(tile_[size_t{y} * tiles_.x + x]->depth)];
      }
}

RefinedWindow RefinedTiles::windowOf(glm::uvec2 tile) const {
  const glm::uvec2 first = tile * side_;
  return {first, glm::min(glm::uvec2(side_), last_ - first) + 1u};
}

bool RefinedTiles::isReached(const RefinedWindow& window) const {
  const double scale = std::ldexp(1.0, -depth_);
  const glm::dvec2 low = glm::dvec2(window.first) * scale, high = low + glm::dvec2(window.size - 1u) * scale;
  return std::ranges::any_of(stack_.layers, [&](const Layer& layer) {
    return layer.low.x <= high.x && layer.low.y <= high.y && layer.high.x >= low.x && layer.high.y >= low.y;
  });
}

RefinedTiles::Tile RefinedTiles::makeTile(const RefinedWindow& window, std::span<Overlap> overlaps) {
  MergedWindow merged = merge(stack_, depth_, window, overlaps);
  std::vector<std::vector<LayerSample>> samples;
  for (size_t i = 0; i < stack_.layers.size(); ++i)
    samples.push_back(samplesOf(stack_, static_cast<int16_t>(i), depth_, window, merged.owners));
  std::vector<double> residuals(samples.size());
  Tile tile;
  for (tile.depth = 0;; ++tile.depth) {
    const Grid grid{merged.metres, window, 1u << (depth_ - tile.depth)};
    for (size_t i = 0; i < samples.size(); ++i) residuals[i] = residualOf(grid, samples[i]);
    if (tile.depth == depth_) break;
    if (std::ranges::all_of(residuals, [&](double r) { return r <= residual_m_; }) && isWithin(grid, residual_m_))
      break;
  }
  for (size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].empty()) continue;
    residuals_[i].largest_m = std::max(residuals_[i].largest_m.value_or(0), residuals[i]);
    residuals_[i].samples += samples[i].size();
  }
  const uint32_t step = 1u << (depth_ - tile.depth);
  for (uint32_t y = 0; y < window.size.y; y += step)
    for (uint32_t x = 0; x < window.size.x; x += step)
      tile.metres.push_back(merged.metres[size_t{y} * window.size.x + x]);
  return tile;
}

double RefinedTiles::heightIn(const Tile& tile, const RefinedWindow& window, glm::uvec2 at) const {
  const uint32_t step = 1u << (depth_ - tile.depth);
  const glm::uvec2 first = window.first / step, last = (window.first + window.size - 1u) / step;
  const uint32_t width = last.x - first.x + 1;
  return drawnHeight(last, glm::dvec2(at) / double(step), [&](uint32_t x, uint32_t y) {
    return double{tile.metres[size_t{y - first.y} * width + (x - first.x)]};
  });
}

// On a border of tiles, of the deepest.
double RefinedTiles::heightAt(glm::uvec2 at) const {
  const glm::uvec2 high = glm::min(at / side_, tiles_ - 1u);
  const glm::uvec2 low = high - glm::min(high, glm::uvec2(at.x % side_ == 0, at.y % side_ == 0));
  const Tile* deepest = nullptr;
  glm::uvec2 where(0);
  for (uint32_t y = low.y; y <= high.y; ++y)
    for (uint32_t x = low.x; x <= high.x; ++x)
      if (const auto& tile = tile_[size_t{y} * tiles_.x + x]; tile && (!deepest || tile->depth > deepest->depth))
        deepest = &*tile, where = {x, y};
  if (deepest != nullptr) return heightIn(*deepest, windowOf(where), at);
  const Samples& ground = stack_.bottom.metres.empty() ? stack_.base : stack_.bottom;
  return drawnHeight(glm::uvec2(ground.width - 1, ground.height - 1), glm::dvec2(at) * std::ldexp(1.0, -depth_),
                     [&](uint32_t x, uint32_t y) { return double{ground.at(x, y)}; });
}

void RefinedTiles::readRow(uint32_t y, std::span<float> out) const {
  for (uint32_t x = 0; x < out.size(); ++x) out[x] = static_cast<float>(heightAt({x, y}));
}

}  // namespace foreland::terrain
